from .results import Row as Row
from .results import read_row as read_row
from .submission.rounds import draw_round as draw_round
