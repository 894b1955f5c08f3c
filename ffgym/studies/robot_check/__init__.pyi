from .draft import POSES as POSES
from .draft import Skeleton as Skeleton
from .draft import skeleton as skeleton
from .places import Place as Place
from .servo_loop import ServoLoop as ServoLoop
from .study import RobotCheck as RobotCheck
from .study import check_robot as check_robot
