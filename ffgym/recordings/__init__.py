"""Recordings of one motion, simulated or measured: one schema, one reader, one writer."""

from ffgym.recordings.folder import read_folder as read_folder
from ffgym.recordings.header import SCHEMA_VERSION as SCHEMA_VERSION
from ffgym.recordings.header import Header as Header
from ffgym.recordings.io import read_recording as read_recording
from ffgym.recordings.io import write_recording as write_recording
from ffgym.recordings.phase import PHASE_KINDS as PHASE_KINDS
from ffgym.recordings.phase import Phase as Phase
from ffgym.recordings.phase import PhaseKind as PhaseKind
from ffgym.recordings.phase import clipped as clipped
from ffgym.recordings.recording import Recording as Recording
from ffgym.recordings.rewiring import Rewire as Rewire
from ffgym.recordings.rewiring import Rewiring as Rewiring
from ffgym.recordings.schema import FAMILIES as FAMILIES
from ffgym.recordings.schema import Family as Family
