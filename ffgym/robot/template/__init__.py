"""A table to fill in for a new robot: what is asked, where answers are found, and what can be proposed."""

from ffgym.robot.template.complete import completed_text as completed_text
from ffgym.robot.template.fill import filled_text as filled_text
from ffgym.robot.template.proposals import Proposal as Proposal
from ffgym.robot.template.proposals import propose as propose
from ffgym.robot.template.write import template as template
