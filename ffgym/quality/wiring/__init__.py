"""Wiring: a fit over all logs of one robot of which columns are not what they are called."""

from ffgym.quality.wiring.find import Wiring as Wiring
from ffgym.quality.wiring.find import find_wiring as find_wiring
from ffgym.quality.wiring.mistake import Mistake as Mistake
