"""What lies between motor and link."""

from ffgym.effects.transmission.backlash import Backlash as Backlash
from ffgym.effects.transmission.base_flexibility import BaseFlexibility as BaseFlexibility
from ffgym.effects.transmission.flexible_load import FlexibleLoad as FlexibleLoad
from ffgym.effects.transmission.hardening import Hardening as Hardening
from ffgym.effects.transmission.hysteresis import TorsionalHysteresis as TorsionalHysteresis
from ffgym.effects.transmission.kinematic_error import KinematicError as KinematicError
from ffgym.effects.transmission.stiffness import JointStiffness as JointStiffness
from ffgym.effects.transmission.wrist_coupling import WristCoupling as WristCoupling
