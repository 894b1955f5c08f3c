from .controller import Execution as Execution
from .program import Program as Program
from .program import find_unreachable as find_unreachable
from .program import load_program as load_program
from .program import on_branches as on_branches
from .program import parse_program as parse_program
from .scope import join_errors as join_errors
