from .complete import completed_text as completed_text
from .fill import filled_text as filled_text
from .proposals import Proposal as Proposal
from .proposals import propose as propose
from .write import template as template
