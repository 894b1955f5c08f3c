from .proposals import Proposal as Proposal
from .proposals import propose as propose
from .text import completed_text as completed_text
from .text import filled_text as filled_text
from .text import template as template
