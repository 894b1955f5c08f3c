"""Arms from files: MJCF or URDF, read into the numbers of a robot description."""

from ffgym.robot.arm_file.arm_file import ArmFile as ArmFile
from ffgym.robot.arm_file.arm_file import JointHints as JointHints
from ffgym.robot.arm_file.arm_file import NamedFrame as NamedFrame
from ffgym.robot.arm_file.quantities import flange_at as flange_at
from ffgym.robot.arm_file.read import read_arm as read_arm
