"""From recordings to parameters: signals, friction, intervals of what was found."""

from ffgym.identification.bootstrap import Blocks as Blocks
from ffgym.identification.bootstrap import Intervals as Intervals
from ffgym.identification.bootstrap import bootstrap as bootstrap
from ffgym.identification.bootstrap import intervals as intervals
from ffgym.identification.estimate import Estimate as Estimate
from ffgym.identification.friction import FrictionIdentification as FrictionIdentification
from ffgym.identification.friction import identify_friction as identify_friction
from ffgym.identification.friction_torque import FrictionTorque as FrictionTorque
from ffgym.identification.friction_torque import friction_torque as friction_torque
from ffgym.identification.friction_torque import friction_torques as friction_torques
from ffgym.identification.joint_friction import JointFriction as JointFriction
from ffgym.identification.signals import LowPass as LowPass
from ffgym.identification.signals import Signals as Signals
from ffgym.identification.signals import signals_of as signals_of
from ffgym.identification.validation import Validation as Validation
from ffgym.identification.validation import predicted_friction as predicted_friction
from ffgym.identification.validation import validate as validate
