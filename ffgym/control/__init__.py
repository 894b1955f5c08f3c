"""What a controller may compute: references, rigid feed-forward, laws, set-points; what an agent sees, and is."""

from ffgym.control.feedforward import CausalLaw as CausalLaw
from ffgym.control.feedforward import FeedForwardLaw as FeedForwardLaw
from ffgym.control.feedforward import NoCompensation as NoCompensation
from ffgym.control.feedforward import Window as Window
from ffgym.control.lugre_laws import DynamicLuGre as DynamicLuGre
from ffgym.control.lugre_laws import DynamicLuGreEuler as DynamicLuGreEuler
from ffgym.control.lugre_laws import DynamicLuGreExact as DynamicLuGreExact
from ffgym.control.lugre_laws import StaticLuGre as StaticLuGre
from ffgym.control.observation import ObservationLayout as ObservationLayout
from ffgym.control.policy import Agent as Agent
from ffgym.control.policy import Batchable as Batchable
from ffgym.control.policy import Policy as Policy
from ffgym.control.reference import Reference as Reference
from ffgym.control.reference import cartesian_reference as cartesian_reference
from ffgym.control.reference import joint_reference as joint_reference
from ffgym.control.rigid_feedforward import rigid_feedforward as rigid_feedforward
from ffgym.control.servo import ServoTorque as ServoTorque
from ffgym.control.servo import servo_torque as servo_torque
from ffgym.control.setpoints import Setpoints as Setpoints
