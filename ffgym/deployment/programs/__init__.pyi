from .folder import FORMATS as FORMATS
from .folder import WrittenProgram as WrittenProgram
from .folder import write_program as write_program
from .points import PathPoints as PathPoints
from .points import choose_points as choose_points
