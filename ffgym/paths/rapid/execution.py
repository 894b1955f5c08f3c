"""What running a program leaves: moves, and what the robot must be and do for them."""

from dataclasses import dataclass

from ffgym.paths.moves import Move
from ffgym.robot import RobotDescription

Configuration = tuple[int, int, int]
"""Quarter turns of axes 1, 4 and 6: k for angles in [90 k, 90 (k + 1)) deg; RAPID's cf1, cf4 and cf6."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Execution:
    """Moves of a program, for one robot with one tool."""

    robot: RobotDescription
    """Holds the program's tool."""
    moves: tuple[Move, ...]
    configurations: tuple[Configuration | None, ...]
    """One per move: the branch that the target asks for; None where the nearest is taken."""
