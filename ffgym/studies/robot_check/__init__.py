"""What a robot description amounts to: reach, loads, margins, resonances, servo, and numbers that are hardly true."""

from ffgym.studies.robot_check.places import Place as Place
from ffgym.studies.robot_check.servo_loop import ServoLoop as ServoLoop
from ffgym.studies.robot_check.skeleton import POSES as POSES
from ffgym.studies.robot_check.skeleton import Skeleton as Skeleton
from ffgym.studies.robot_check.skeleton import skeleton as skeleton
from ffgym.studies.robot_check.study import RobotCheck as RobotCheck
from ffgym.studies.robot_check.study import check_robot as check_robot
