from .log import Log as Log
from .log import log_of as log_of
from .sampling import Sampling as Sampling
