"""A description that lacks entries, made whole by stand-ins, so that files can name it: each says that it is one."""

import os
import re
from pathlib import Path

import numpy as np

from ffgym.core.types import Array
from ffgym.robot.description import RobotDescription
from ffgym.robot.reading.draft import RobotDraft, stand_ins
from ffgym.robot.reading.parameters import GROUPS
from ffgym.robot.reading.rules import RULES
from ffgym.robot.template.fill import filled_text
from ffgym.robot.template.proposals import Proposal
from ffgym.robot.template.toml_text import text

_SOURCE = "stand-in: nobody said it; what depends on it means nothing"

_MODEL = re.compile(r'^(\s*model\s*=\s*)"([^"]*)"', re.MULTILINE)
"""The entry of [robot] that names the arm file."""


def completed_text(toml: str, draft: RobotDraft, robot: RobotDescription, *, before: Path, folder: Path) -> str:
    """Text of a description with stand-ins for all that it lacks; numbers that `robot` has of it are taken from there.

    Args:
        toml: text of the description.
        draft: what it says.
        robot: the same robot with numbers that were fitted since.
        before: folder of the description, where the path of its arm file begins.
        folder: folder that the text is for.
    """
    known = {path: quantity.value for path, quantity in draft.quantities.items()}
    instead = stand_ins(known, len(draft.joints)) | {path: _fitted(robot, path) for path in draft.missing if _has(path)}
    proposals = [
        Proposal(path=path, value=np.asarray(instead[path]), source=_SOURCE, side=RULES[path].side)
        for path in draft.missing
    ]
    return filled_text(_moved(toml, before, folder), proposals, draft.types)


def _has(path: str) -> bool:
    return path.partition(".")[0] in GROUPS


def _fitted(robot: RobotDescription, path: str) -> Array:
    group, _, name = path.partition(".")
    return np.asarray(getattr(getattr(robot, GROUPS[group]), name), dtype=np.float64)


def _moved(toml: str, before: Path, folder: Path) -> str:
    """The text with the path of its arm file from another folder."""

    def named(match: re.Match[str]) -> str:
        path = (before / match.group(2)).resolve()
        try:
            relative = Path(os.path.relpath(path, folder.resolve())).as_posix()
        except ValueError:  # another drive
            relative = path.as_posix()
        return f"{match.group(1)}{text(relative)}"

    return _MODEL.sub(named, toml, count=1)
