"""An agent in one Python file of its author: PREVIEW, ACTION_SCALE and make_agent(robot, layout)."""

import ast
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from ffgym.control import Agent, ObservationLayout
from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text
from ffgym.core.provenance import installed
from ffgym.leaderboard.submission import judge
from ffgym.robot import RobotDescription

LIBRARIES: Mapping[str, str] = {
    "torch": "torch",
    "stable_baselines3": "stable-baselines3",
    "sb3_contrib": "sb3-contrib",
    "sklearn": "scikit-learn",
}
"""Modules that do at import what an agent must not do, and their packages: they are loaded before it is watched."""

HIDDEN = (*judge.HIDDEN, "ffgym.simulation", "ffgym.studies")
"""Modules that such an agent must not see: it might practise on the circles that it is scored on."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PythonPolicy:
    """What a file defines; see `ffgym.control.Policy`."""

    preview: int
    action_scale: float
    make: Callable[[RobotDescription, ObservationLayout], Agent]

    def agent(self, robot: RobotDescription, layout: ObservationLayout) -> Agent:
        """See `ffgym.control.Policy`.

        Raises:
            FFGymError: if what the file makes has no `predict`.
        """
        agent = self.make(robot, layout)
        if not callable(getattr(agent, "predict", None)):
            raise FFGymError(f"make_agent returned {type(agent).__name__}, which has no predict.")
        return agent


def prepare(source: Mapping[str, Any], folder: Path) -> None:
    """Load the libraries that the file imports, before it is run and watched.

    Raises:
        FFGymError: if the file is no Python, or needs a library that is not installed.
    """
    try:
        tree = ast.parse(read_text(folder / str(source["file"])))
    except (SyntaxError, ValueError, RecursionError) as error:
        raise FFGymError(f"It is no Python file: {error}.") from error
    for name in sorted(_imported(tree) & set(LIBRARIES)):
        if not installed(LIBRARIES[name]):
            raise FFGymError(f"It imports {name}; pip install {LIBRARIES[name]}.")
        import_module(name)
        if name == "sklearn":
            _count_threads()


def _count_threads() -> None:
    """Let scikit-learn look once, and for good, for the libraries of its threads, which it does through ctypes."""
    import_module("sklearn.cluster").KMeans(n_clusters=1, n_init=1).fit(np.zeros((2, 1)))


def load(source: Mapping[str, Any], folder: Path, robot: RobotDescription) -> PythonPolicy:
    """Run the file.

    Raises:
        FFGymError: if it does not define what it must.
    """
    place = folder / str(source["file"])
    module = ModuleType("submitted_agent")
    module.__file__ = str(place)
    sys.modules[module.__name__] = module  # dataclasses and pickle look for the module of a class there
    exec(compile(read_text(place), str(place), "exec"), module.__dict__)
    names = ("PREVIEW", "ACTION_SCALE", "make_agent")
    if missing := [name for name in names if not hasattr(module, name)]:
        raise FFGymError(f"It does not define {', '.join(missing)}.")
    preview, scale, make = (getattr(module, name) for name in names)
    if not callable(make):
        raise FFGymError("make_agent must be a function of robot and layout.")
    return PythonPolicy(preview=preview, action_scale=scale, make=make)


def _imported(tree: ast.AST) -> set[str]:
    """Top-level names of everything that a file imports."""
    names: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names.add(node.module.partition(".")[0])
    return names
