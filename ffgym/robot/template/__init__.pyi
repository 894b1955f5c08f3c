from .proposals import Proposal as Proposal
from .proposals import propose as propose
from .text import complete_text as complete_text
from .text import fill_text as fill_text
from .text import template as template
