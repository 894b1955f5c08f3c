from .cell import SealedMachine as SealedMachine
from .cell import Workcell as Workcell
from .draws import SERIES as SERIES
from .draws import draw as draw
from .reading import INSTANCES as INSTANCES
from .reading import workcell as workcell
