from .find import Wiring as Wiring
from .find import find_wiring as find_wiring
from .mistake import Mistake as Mistake
