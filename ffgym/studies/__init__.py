"""The experiments of the thesis, and any motion, simulated and scored."""

from ffgym.studies.circle_scores import CircleScore as CircleScore
from ffgym.studies.circle_scores import circle_scores as circle_scores
from ffgym.studies.circle_scores import in_mm as in_mm
from ffgym.studies.circle_study import Cell as Cell
from ffgym.studies.circle_study import CircleStudy as CircleStudy
from ffgym.studies.circle_study import circle_references as circle_references
from ffgym.studies.circle_study import circle_study as circle_study
from ffgym.studies.circle_study import thesis_laws as thesis_laws
from ffgym.studies.motion_study import MotionResult as MotionResult
from ffgym.studies.motion_study import MotionStudy as MotionStudy
from ffgym.studies.motion_study import StretchError as StretchError
from ffgym.studies.motion_study import motion_study as motion_study
from ffgym.studies.one_axis_study import OneAxisStudy as OneAxisStudy
from ffgym.studies.one_axis_study import SineResult as SineResult
from ffgym.studies.one_axis_study import one_axis_study as one_axis_study
from ffgym.studies.one_axis_study import sine_references as sine_references
