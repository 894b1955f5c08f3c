"""From recordings to parameters: signals, friction, intervals of what was found."""

from ffgym.identification.bootstrap import Blocks as Blocks
from ffgym.identification.bootstrap import Intervals as Intervals
from ffgym.identification.bootstrap import bootstrap as bootstrap
from ffgym.identification.bootstrap import intervals as intervals
from ffgym.identification.signals import LowPass as LowPass
from ffgym.identification.signals import Signals as Signals
from ffgym.identification.signals import signals_of as signals_of
