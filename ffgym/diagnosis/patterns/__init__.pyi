from .cycles import cycles_per_turn as cycles_per_turn
from .find import find_patterns as find_patterns
from .spectrum import Spectrum as Spectrum
