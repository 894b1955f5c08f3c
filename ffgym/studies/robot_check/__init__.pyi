from .loads import ServoLoop as ServoLoop
from .shape import POSES as POSES
from .shape import CheckedPose as CheckedPose
from .shape import Skeleton as Skeleton
from .shape import skeleton as skeleton
from .study import RobotCheck as RobotCheck
from .study import check_robot as check_robot
