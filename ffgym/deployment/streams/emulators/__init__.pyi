from .controller import DirectTorque as DirectTorque
from .controller import EmulatedController as EmulatedController
from .drive_log import record_drive as record_drive
from .lock_step import run_in_lock_step as run_in_lock_step
from .network import Faults as Faults
from .network import FaultyNetwork as FaultyNetwork
from .robot import EmulatedRobot as EmulatedRobot
