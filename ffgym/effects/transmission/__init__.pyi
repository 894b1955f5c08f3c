from .backlash import Backlash as Backlash
from .base_flexibility import BaseFlexibility as BaseFlexibility
from .flexible_load import FlexibleLoad as FlexibleLoad
from .hardening import Hardening as Hardening
from .hysteresis import TorsionalHysteresis as TorsionalHysteresis
from .kinematic_error import KinematicError as KinematicError
from .stiffness import JointStiffness as JointStiffness
from .wrist_coupling import WristCoupling as WristCoupling
