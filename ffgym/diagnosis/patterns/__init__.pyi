from .find import find_patterns as find_patterns
from .periodic import cycles_per_turn as cycles_per_turn
from .spectra import Spectrum as Spectrum
