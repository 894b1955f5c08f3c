from .arm_file import ArmFile as ArmFile
from .arm_file import JointHints as JointHints
from .arm_file import NamedFrame as NamedFrame
from .measure import flange_at as flange_at
from .read import read_arm as read_arm
