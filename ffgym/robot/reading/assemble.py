"""From checked numbers by name to the parts of a description."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_rotation
from ffgym.robot.drive import Drive
from ffgym.robot.friction import LuGreParameters
from ffgym.robot.parts import Kinematics, Links, Sensors, Servo, Tool, WorkArea

FLANGE = ("flange.rotation", "tool.tcp")
TOOL_MASSES = ("tool.mass", "tool.com", "tool.inertia")
HOME = "work_area.home"
POSITIONS = "work_area.positions."


def assemble(get: Mapping[str, Any], types: tuple[str, ...]) -> dict[str, Any]:
    """Numeric fields of a `RobotDescription` from values by entry; all that are required must be there.

    Raises:
        FFGymError: if entries do not fit one another.
    """
    return {
        "kinematics": _group(Kinematics, "kinematics", get, types=types),
        "base_mass": float(get["base.mass"]),
        "base_com": get["base.com"],
        "bodies": _group(Links, "links", get),
        "tool": _tool(get),
        "drive": _group(Drive, "drive", get),
        "friction": _group(LuGreParameters, "friction", get),
        "servo": _group(Servo, "servo", get, control_dt=float(get["servo.control_dt"])),
        "sensors": Sensors(
            encoder_bits=_whole("sensors.encoder_bits", get),
            tracker_noise=float(get.get("sensors.tracker_noise", 0.0)),
            tracker_period=float(get.get("sensors.tracker_period", 0.0)),
        ),
        "physics_dt": float(get["simulation.physics_dt"]),
        "gravity": get["simulation.gravity"],
        "work_area": _work_area(get),
    }


def begun(paths: Mapping[str, Any]) -> dict[str, tuple[str, ...]]:
    """Entries that others of their group call for, by one of those that are there; empty if all groups are whole."""
    groups = [(TOOL_MASSES, TOOL_MASSES), (FLANGE, FLANGE), (("flange.position", *TOOL_MASSES), FLANGE)]
    groups += [(tuple(path for path in paths if path.startswith("work_area.")), (HOME,))]
    found: dict[str, tuple[str, ...]] = {}
    for given, wanted in groups:
        missing = tuple(path for path in wanted if path not in paths)
        found |= {path: missing for path in given if path in paths and missing}
    return found


def _group(cls: Any, prefix: str, get: Mapping[str, Any], **others: Any) -> Any:
    """Build a dataclass from the quantities below `prefix`, and from `others`."""
    values = {path.removeprefix(prefix + "."): value for path, value in get.items() if path.startswith(prefix + ".")}
    return cls(**(values | others))


def _tool(get: Mapping[str, Any]) -> Tool | None:
    weighs = _all_or_none(TOOL_MASSES, get)
    if not _all_or_none(FLANGE, get):
        if weighs or "flange.position" in get:
            raise FFGymError(f"A tool needs {' and '.join(FLANGE)}.")
        return None
    body = {path.removeprefix("tool."): get[path] for path in TOOL_MASSES} if weighs else {}
    return Tool(
        rotation=check_rotation("flange.rotation", get["flange.rotation"]),
        position=get.get("flange.position", np.zeros(3)),
        tcp=get["tool.tcp"],
        **(body | {"mass": float(body.get("mass", 0.0))}),
    )


def _work_area(get: Mapping[str, Any]) -> WorkArea | None:
    others = [path for path in get if path.startswith("work_area.") and path != HOME]
    if HOME not in get:
        if others:
            raise FFGymError(f"{others[0]} needs {HOME}, the seed of the inverse kinematics; {HOME} is missing.")
        return None
    rotation = get.get("work_area.tool_rotation")
    return WorkArea(
        positions={path.removeprefix(POSITIONS): get[path] for path in others if path.startswith(POSITIONS)},
        tool_rotation=None if rotation is None else check_rotation("work_area.tool_rotation", rotation),
        normal=get.get("work_area.normal", np.array([0.0, 0.0, 1.0])),
        home=get[HOME],
    )


def _all_or_none(paths: tuple[str, ...], get: Mapping[str, Any]) -> bool:
    present = [path in get for path in paths]
    if any(present) and not all(present):
        raise FFGymError(
            f"{', '.join(paths)} belong together; {', '.join(p for p in paths if p not in get)} is missing."
        )
    return all(present)


def _whole(path: str, get: Mapping[str, Any]) -> int:
    number = float(get[path])
    if number != round(number):
        raise FFGymError(f"{path} = {number} must be a whole number.")
    return round(number)
