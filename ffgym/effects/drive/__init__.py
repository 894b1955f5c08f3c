"""Motor and current loop: what becomes of the torque that the servo commands."""

from ffgym.effects.drive.cogging import Cogging as Cogging
from ffgym.effects.drive.delay import TorqueDelay as TorqueDelay
from ffgym.effects.drive.offset import TorqueOffset as TorqueOffset
from ffgym.effects.drive.ripple import TorqueRipple as TorqueRipple
from ffgym.effects.drive.torque_constant import TorqueConstant as TorqueConstant
