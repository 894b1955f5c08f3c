"""What residuals depend on, said without any effect: functions, periods, lines, other joints."""

from ffgym.diagnosis.patterns.cycles import cycles_per_turn as cycles_per_turn
from ffgym.diagnosis.patterns.find import find_patterns as find_patterns
from ffgym.diagnosis.patterns.spectrum import Spectrum as Spectrum
