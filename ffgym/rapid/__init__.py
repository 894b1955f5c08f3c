"""RAPID programs: from text to moves."""

from ffgym.rapid.branches import on_branches as on_branches
from ffgym.rapid.execution import Execution as Execution
from ffgym.rapid.program import Program as Program
from ffgym.rapid.program import load_program as load_program
from ffgym.rapid.program import parse_program as parse_program
