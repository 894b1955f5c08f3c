from .cell import SealedMachine as SealedMachine
from .cell import Workcell as Workcell
from .draws import draw as draw
from .instances import INSTANCES as INSTANCES
from .instances import workcell as workcell
