"""Plant + controller + path (+ feed-forward) -> recording."""

from ffgym.simulation.rig import Rig as Rig
from ffgym.simulation.rig import SimulatedRig as SimulatedRig
from ffgym.simulation.sensors import LaserTracker as LaserTracker
from ffgym.simulation.sensors import Resolver as Resolver
from ffgym.simulation.sensors import Sensor as Sensor
from ffgym.simulation.sensors import Thermometer as Thermometer
from ffgym.simulation.sensors import TorqueSensor as TorqueSensor
from ffgym.simulation.sensors import sensors_of as sensors_of
from ffgym.simulation.simulate import RECORD_DT as RECORD_DT
from ffgym.simulation.simulate import Run as Run
from ffgym.simulation.simulate import simulate as simulate
