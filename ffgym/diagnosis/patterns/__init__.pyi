from .find import find_patterns as find_patterns
from .periodic import Spectrum as Spectrum
from .periodic import compute_turn_spectrum as compute_turn_spectrum
