"""What every submission is run on: a few motions that nobody learns on, on two plants."""

from collections.abc import Mapping
from dataclasses import dataclass

from ffgym.envs.machines import is_workcell
from ffgym.envs.workcell_circles import CONTROLLER
from ffgym.leaderboard.plants import NOMINAL, ROBOT, THESIS_WORKCELL
from ffgym.leaderboard.tasks import Task
from ffgym.paths import RADII


@dataclass(frozen=True)
class Plan:
    """Tasks by plant."""

    tasks: Mapping[str, tuple[Task, ...]]
    """By name of the plant, see `ffgym.leaderboard.plants.plant_named`."""


POSITION = "p2"
"""Where submissions are run: a position that nobody learns on."""
_FAST, _MIDDLE, _SLOW = (Task(POSITION, speed, RADII, "positions") for speed in (0.1, 0.04, 0.01))

STANDARD = Plan({NOMINAL: (_FAST, _MIDDLE, _SLOW), THESIS_WORKCELL: (_FAST, _MIDDLE)})
"""All radii of the thesis. The slow circles are left out on the workcell, where they alone would take a minute."""


def controller_of(plant: str) -> str:
    """Name of the description that the controller of a plant knows, and agents on it."""
    return CONTROLLER if is_workcell(plant) else ROBOT


def actions_name(plant: str, task: int) -> str:
    """Name of the array with the actions of a task."""
    return f"{plant.replace(':', '_')}_{task}"
