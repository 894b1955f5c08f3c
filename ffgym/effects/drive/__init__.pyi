from .cogging import Cogging as Cogging
from .delay import TorqueDelay as TorqueDelay
from .offset import TorqueOffset as TorqueOffset
from .ripple import TorqueRipple as TorqueRipple
from .torque_constant import TorqueConstant as TorqueConstant
