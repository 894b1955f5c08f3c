"""Motions from files and names (path descriptions, tables, RAPID programs) as references for a robot."""

from ffgym.motions.compose import compose as compose
from ffgym.motions.load import list_motions as list_motions
from ffgym.motions.load import load_motion as load_motion
from ffgym.motions.motion import Motion as Motion
