"""Friction as a small recurrent network of speeds and its own past outputs, thesis 6.2."""

from ffgym.identification.narx.fit import Focus as Focus
from ffgym.identification.narx.fit import Structure as Structure
from ffgym.identification.narx.fit import best_simulating as best_simulating
from ffgym.identification.narx.fit import fitted as fitted
from ffgym.identification.narx.model import ARRAYS as ARRAYS
from ffgym.identification.narx.model import NarxModel as NarxModel
from ffgym.identification.narx.regressors import Regressors as Regressors
from ffgym.identification.narx.regressors import lags_of as lags_of
from ffgym.identification.narx.samples import Errors as Errors
from ffgym.identification.narx.samples import Misfit as Misfit
from ffgym.identification.narx.samples import Samples as Samples
