from .results import Row as Row
from .results import read_row as read_row
