"""The table [robot] of a description: names, and the arm file if its geometry and masses come from one."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ffgym.core.errors import FFGymError, check_choice
from ffgym.robot.parts import JOINT_TYPES
from ffgym.robot.reading.quantity import Quantity
from ffgym.robot.reading.tables import names_of
from ffgym.robot.shapes import Geom

_NAMED = {"name", "title", "joints", "links"}
_FROM_FILE = {"name", "title", "model"}


@dataclass(frozen=True, kw_only=True, eq=False)
class Head:
    """Who the robot is, and what its arm file says."""

    name: str
    title: str
    joints: tuple[str, ...]
    links: tuple[str, ...]
    types: tuple[str, ...]
    """'hinge' or 'slide', one per joint."""
    quantities: Mapping[str, Quantity] = field(default_factory=dict)
    """Entries that the arm file gives, and the description may replace."""
    geoms: tuple[Geom, ...] = ()


def parse_head(head: Any, folder: Path) -> Head:
    """Read the table [robot] of a description in `folder`.

    Raises:
        FFGymError: if an entry is missing, unknown or invalid, or the arm file is.
    """
    keys = set(head) if isinstance(head, dict) else set()
    from_file = "model" in keys
    needed, others = (_FROM_FILE, {"joints", "tool_frame", "looks"}) if from_file else (_NAMED, {"types"})
    if not needed <= keys <= needed | others:
        raise FFGymError(
            "[robot] must have exactly name, title, joints and links, and may have types; or name, title and model, "
            f"and may have joints, tool_frame and looks. Got {sorted(map(str, keys)) or head!r}."
        )
    name, title = names_of("[robot] name and title", [head["name"], head["title"]])
    if from_file:
        return _from_file(name, title, head, folder)
    joints, links = names_of("[robot] joints", head["joints"]), names_of("[robot] links", head["links"])
    types = _types(head.get("types", ["hinge"] * len(joints)), len(joints))
    return Head(name=name, title=title, joints=joints, links=links, types=types)


def _types(types: Any, n_joints: int) -> tuple[str, ...]:
    names = names_of("[robot] types", types)
    for kind in names:
        check_choice("[robot] types", kind, JOINT_TYPES)
    if len(names) != n_joints:
        raise FFGymError(f"[robot] has {len(names)} types for {n_joints} joints; give one per joint.")
    return names


def _from_file(name: str, title: str, head: Mapping[str, Any], folder: Path) -> Head:
    from ffgym.robot.arm_file import flange_at, read_arm  # loaded with the first arm file

    (model,) = names_of("[robot] model", [head["model"]])
    (looks,) = names_of("[robot] looks", [head.get("looks", "file")])
    check_choice("[robot] looks", looks, ("file", "none"))
    joints = names_of("[robot] joints", head["joints"]) if "joints" in head else None
    arm = read_arm(folder / model, joints, looks=looks == "file")
    quantities = dict(arm.quantities)
    if "tool_frame" in head:
        (frame,) = names_of("[robot] tool_frame", [head["tool_frame"]])
        quantities |= flange_at(arm, frame)
    return Head(
        name=name,
        title=title,
        joints=arm.joints,
        links=arm.links,
        types=arm.types,
        quantities=quantities,
        geoms=arm.geoms,
    )
