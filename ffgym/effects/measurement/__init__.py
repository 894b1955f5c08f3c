"""What is between the truth and its measurement."""

from ffgym.effects.measurement.joint_zeros import JointZeros as JointZeros
from ffgym.effects.measurement.link_clock import LinkClock as LinkClock
from ffgym.effects.measurement.resolver_error import ResolverRipple as ResolverRipple
from ffgym.effects.measurement.tool_frame import ToolFrame as ToolFrame
from ffgym.effects.measurement.torque_clock import TorqueClock as TorqueClock
from ffgym.effects.measurement.tracker_clock import TrackerClock as TrackerClock
from ffgym.effects.measurement.tracker_frame import TrackerFrame as TrackerFrame
