"""An agent in one Python file of its author: PREVIEW, ACTION_SCALE and make_agent(robot, layout)."""

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any, cast

from ffgym.control import Agent, ObservationLayout
from ffgym.control.observation import Channel
from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text
from ffgym.robot import RobotDescription


@dataclass(frozen=True, kw_only=True, eq=False)
class View:
    """Arguments of the environment that an agent needs, and its maker; an `ffgym.control.Policy`."""

    preview: int
    action_scale: float
    feedback: bool = True
    """True if it observes errors of the motors."""
    channel: Channel = "torque"
    """Quantity that its actions are added to."""
    make: Callable[[RobotDescription, ObservationLayout], Agent] | None = None
    """Function that makes the agent; None if the agent is passed in another way."""

    def agent(self, robot: RobotDescription, layout: ObservationLayout) -> Agent:
        """Make the agent; FFGymError if it has no `predict`."""
        agent = self.make and self.make(robot, layout)
        if not callable(getattr(agent, "predict", None)):
            raise FFGymError(f"make_agent returned {type(agent).__name__}, which has no predict.")
        return cast(Agent, agent)


def load(source: Mapping[str, Any], folder: Path, robot: RobotDescription) -> View:
    """Run the file; FFGymError if it is no Python, or a definition is missing."""
    place = folder / str(source["file"])
    try:
        code = compile(read_text(place), str(place), "exec")
    except (SyntaxError, ValueError, RecursionError) as error:
        raise FFGymError(f"It is no Python file: {error}.") from error
    module = ModuleType("submitted_agent")
    module.__file__ = str(place)
    sys.modules[module.__name__] = module  # dataclasses and pickle look for the module of a class there
    exec(code, module.__dict__)
    names = ("PREVIEW", "ACTION_SCALE", "make_agent")
    if missing := [name for name in names if not hasattr(module, name)]:
        raise FFGymError(f"It does not define {', '.join(missing)}.")
    preview, scale, make = (getattr(module, name) for name in names)
    if not callable(make):
        raise FFGymError("make_agent must be a function of robot and layout.")
    return View(preview=preview, action_scale=scale, make=make)
