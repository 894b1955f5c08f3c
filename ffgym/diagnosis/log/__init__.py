"""Recordings made ready to be replayed."""

from ffgym.diagnosis.log.log import Log as Log
from ffgym.diagnosis.log.log import log_of as log_of
from ffgym.diagnosis.log.sampling import Sampling as Sampling
