from .find import find_patterns as find_patterns
from .periodic import Spectrum as Spectrum
from .periodic import cycles_per_turn as cycles_per_turn
