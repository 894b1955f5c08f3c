"""Base laws of an environment by name."""

from importlib import import_module

from ffgym.control import FeedForwardLaw
from ffgym.core.errors import FFGymError
from ffgym.robot import RobotDescription

_PLACE = "ffgym.agents.residual.bases"
"""Module that makes laws from their names. Agents stand above environments, so that it is found by its name, as
Gymnasium finds environments."""


def find_base(base: str | FeedForwardLaw, robot: RobotDescription) -> FeedForwardLaw | None:
    """Return a law as it is, or make the one of a name for the robot of the controller; None for 'none'.

    Raises:
        FFGymError: if it is no law and no known name, or cannot be made for the robot.
    """
    if isinstance(base, type) or not isinstance(base, str | FeedForwardLaw):
        raise FFGymError(f"base = {base!r} must be the name of a law, e.g. 'elastic', or a feed-forward law.")
    if not isinstance(base, str):
        return base
    if base == "none":
        return None
    bases = import_module(_PLACE)
    law: FeedForwardLaw | None = bases.base_law(*bases.base_named(base), robot)
    return law
