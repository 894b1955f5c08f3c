from .joint_zeros import JointZeros as JointZeros
from .link_clock import LinkClock as LinkClock
from .resolver_error import ResolverRipple as ResolverRipple
from .tool_frame import ToolFrame as ToolFrame
from .torque_clock import TorqueClock as TorqueClock
from .tracker_clock import TrackerClock as TrackerClock
from .tracker_frame import TrackerFrame as TrackerFrame
