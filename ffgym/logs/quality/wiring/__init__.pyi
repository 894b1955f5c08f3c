from .hypothesis import Mistake as Mistake
from .search import Wiring as Wiring
from .search import find_wiring as find_wiring
