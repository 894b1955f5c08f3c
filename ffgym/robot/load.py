"""Read a robot description from TOML; every number is checked for unit, side, shape, range and origin."""

import tomllib
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from ffgym.errors import FFGymError, check_choice, check_number, check_rotation, check_shape
from ffgym.friction import LuGreParameters
from ffgym.robot.description import RobotDescription
from ffgym.robot.drive import Drive
from ffgym.robot.parts import JOINT_TYPES, Geom, Kinematics, Links, Logs, Sensors, Servo, Spring, Tool, WorkArea
from ffgym.robot.quantity import Quantity, parse_quantity
from ffgym.robot.rule import JointFrame
from ffgym.robot.rules import POINT, RULES, SPRING_RULES


def builtin_robots() -> tuple[str, ...]:
    """Names of the robots that ship with the package."""
    folder = resources.files("ffgym.robot") / "data"
    return tuple(sorted(Path(f.name).stem for f in folder.iterdir() if f.name.endswith(".toml")))


def load_robot(robot: str | Path) -> RobotDescription:
    """Read a built-in robot by name, or a description file by path (anything that ends in .toml).

    Raises:
        FFGymError: if there is no such robot or file, or the file does not describe a robot.
    """
    if str(robot).endswith(".toml"):
        return parse_robot(_read_text(Path(robot)), where=str(robot))
    name = check_choice("robot", str(robot), builtin_robots())
    text = (resources.files("ffgym.robot") / "data" / f"{name}.toml").read_text(encoding="utf-8")
    return parse_robot(text, where=f"{name}.toml")


def robot_of(robot: RobotDescription | str | Path, what: str = "robot") -> RobotDescription:
    """Return a description as it is, or the one that a name or a path leads to; `what` names it in errors.

    Raises:
        FFGymError: if it is none of these.
    """
    if isinstance(robot, RobotDescription):
        return robot
    if not isinstance(robot, str | Path):
        raise FFGymError(
            f"{what} = {robot!r} must be a RobotDescription, one of {', '.join(builtin_robots())}, or a path to a "
            f".toml file."
        )
    return load_robot(robot)


def parse_robot(text: str, where: str = "description") -> RobotDescription:
    """Build a description from TOML text; `where` names the text in error messages.

    Raises:
        FFGymError: if the text is not TOML, or an entry is missing, unknown or invalid.
    """
    try:
        tree = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise FFGymError(f"{where} is not valid TOML: {error}.") from error
    try:
        return _build(tree)
    except FFGymError as error:
        raise FFGymError(f"{where}: {error}") from error


def _read_text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise FFGymError(
            f"Cannot read robot description {path}: {error}. Built-in robots: {', '.join(builtin_robots())}."
        ) from error


def _build(tree: dict[str, Any]) -> RobotDescription:
    head = tree.pop("robot", None)
    needed = {"name", "title", "joints", "links"}
    if not isinstance(head, dict) or not needed <= set(head) <= needed | {"types"}:
        raise FFGymError("[robot] must have exactly name, title, joints and links, and may have types.")
    joints, links = _names("joints", head["joints"]), _names("links", head["links"])
    name, title = _names("name and title", [head["name"], head["title"]])
    types = _types(head.get("types", ["hinge"] * len(joints)), len(joints))
    look, logs, springs = tree.pop("look", {}), tree.pop("logs", {}), tree.pop("springs", {})
    quantities = _quantities(tree, types)
    spring_list = _springs(springs, quantities, types)
    get = {path: quantity.value for path, quantity in quantities.items()}
    return RobotDescription(
        name=name,
        title=title,
        joints=joints,
        links=links,
        kinematics=_group(Kinematics, "kinematics", get, types=types),
        base_mass=float(get["base.mass"]),
        base_com=get["base.com"],
        bodies=_group(Links, "links", get),
        tool=_tool(get),
        drive=_group(Drive, "drive", get),
        friction=_group(LuGreParameters, "friction", get),
        servo=_group(Servo, "servo", get, control_dt=float(get["servo.control_dt"])),
        sensors=Sensors(
            encoder_bits=_whole("sensors.encoder_bits", get),
            tracker_noise=float(get.get("sensors.tracker_noise", 0.0)),
            tracker_period=float(get.get("sensors.tracker_period", 0.0)),
        ),
        physics_dt=float(get["simulation.physics_dt"]),
        gravity=get["simulation.gravity"],
        work_area=_work_area(get),
        geoms=_geoms(look, ("base", *links, "tool")),
        springs=spring_list,
        logs=_logs(logs),
        quantities=MappingProxyType(quantities),
    )


def _names(what: str, names: Any) -> tuple[str, ...]:
    if not isinstance(names, list) or not names or not all(isinstance(name, str) and name for name in names):
        raise FFGymError(f"[robot] {what} must be names, non-empty text, got {names!r}.")
    return tuple(names)


def _types(types: Any, n_joints: int) -> tuple[str, ...]:
    names = _names("types", types)
    for kind in names:
        check_choice("[robot] types", kind, JOINT_TYPES)
    if len(names) != n_joints:
        raise FFGymError(f"[robot] has {len(names)} types for {n_joints} joints; give one per joint.")
    return names


def _quantities(tree: dict[str, Any], types: tuple[str, ...]) -> dict[str, Quantity]:
    """Parse every quantity of the tree; complain about what is missing and what is not known."""
    points = _table("work_area", tree.get("work_area", {})).pop("positions", {})
    points = _table("work_area.positions", points)
    found = {
        f"{group}.{name}": table for group, entries in tree.items() for name, table in _table(group, entries).items()
    }
    unknown = sorted(set(found) - set(RULES))
    if unknown:
        raise FFGymError(f"Unknown entries {unknown}. Available: {', '.join(sorted(RULES))}.")
    missing = sorted(path for path, rule in RULES.items() if not rule.optional and path not in found)
    if missing:
        raise FFGymError(f"Missing entries: {', '.join(missing)}.")
    joints = JointFrame(types=types)
    ratio = parse_quantity("drive.gear_ratio", found["drive.gear_ratio"], RULES["drive.gear_ratio"], joints)
    joints = JointFrame(types=types, gear_ratio=ratio.value)
    parsed = {path: parse_quantity(path, table, RULES[path], joints) for path, table in found.items()}
    for name, table in points.items():
        path = f"work_area.positions.{name}"
        parsed[path] = parse_quantity(path, table, POINT, joints)
    return parsed


def _table(path: str, value: Any) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise FFGymError(f"[{path}] must be a table, got {value!r}.")
    return value


def _group(cls: Any, prefix: str, get: Mapping[str, Any], **others: Any) -> Any:
    """Build a dataclass from the quantities below `prefix`, and from `others`."""
    values = {path.removeprefix(prefix + "."): value for path, value in get.items() if path.startswith(prefix + ".")}
    return cls(**(values | others))


def _tool(get: Mapping[str, Any]) -> Tool | None:
    flange, masses = ("flange.rotation", "tool.tcp"), ("tool.mass", "tool.com", "tool.inertia")
    weighs = _all_or_none(masses, get)
    if not _all_or_none(flange, get):
        if weighs or "flange.position" in get:
            raise FFGymError(f"A tool needs {' and '.join(flange)}.")
        return None
    body = {path.removeprefix("tool."): get[path] for path in masses} if weighs else {}
    return Tool(
        rotation=check_rotation("flange.rotation", get["flange.rotation"]),
        position=get.get("flange.position", np.zeros(3)),
        tcp=get["tool.tcp"],
        **(body | {"mass": float(body.get("mass", 0.0))}),
    )


def _springs(springs: Any, quantities: dict[str, Quantity], types: tuple[str, ...]) -> tuple[Spring, ...]:
    """Springs of the description; their numbers are added to `quantities`."""
    found = []
    for name, table in _table("springs", springs).items():
        path = f"springs.{name}"
        entries = dict(_table(path, table))
        bodies = _names(f"{path}.bodies", entries.pop("bodies", None))
        needed = {key for key, rule in SPRING_RULES.items() if not rule.optional}
        if not needed <= set(entries) <= set(SPRING_RULES) or len(bodies) != 2:
            raise FFGymError(f"[{path}] must have two bodies and {', '.join(sorted(needed))}, got {sorted(table)}.")
        joints = JointFrame(types=types)
        own = {key: parse_quantity(f"{path}.{key}", entries[key], SPRING_RULES[key], joints) for key in entries}
        quantities |= {f"{path}.{key}": quantity for key, quantity in own.items()}
        stiffness = [
            float(own[key].value) if key in own else 0.0 for key in ("stiffness", "stiffness_2", "stiffness_3")
        ]
        found.append(
            Spring(
                name=name,
                bodies=(bodies[0], bodies[1]),
                start=own["start"].value,
                end=own["end"].value,
                length=float(own["length"].value),
                stiffness=(stiffness[0], stiffness[1], stiffness[2]),
            )
        )
    return tuple(found)


def _logs(logs: Any) -> Logs:
    if not set(_table("logs", logs)) <= {"torque", "position"}:
        raise FFGymError(f"[logs] may have torque and position, got {sorted(logs)}.")
    return Logs(**logs)


def _work_area(get: Mapping[str, Any]) -> WorkArea | None:
    prefix = "work_area.positions."
    points = {path.removeprefix(prefix): value for path, value in get.items() if path.startswith(prefix)}
    wanted = ("work_area.tool_rotation", "work_area.home")
    if not _all_or_none(wanted, get):
        if points:
            raise FFGymError(f"work_area.positions need {' and '.join(wanted)}.")
        return None
    return WorkArea(
        positions=MappingProxyType(points),
        tool_rotation=check_rotation("work_area.tool_rotation", get["work_area.tool_rotation"]),
        home=get["work_area.home"],
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


def _geoms(look: Any, bodies: tuple[str, ...]) -> tuple[Geom, ...]:
    unknown = sorted(set(_table("look", look)) - {"colours", "geoms"})
    if unknown:
        raise FFGymError(f"[look] has unknown entries {unknown}, may have colours and geoms.")
    colours = {
        name: tuple(check_shape(f"look.colours.{name}", value, (4,)).tolist())
        for name, value in _table("look.colours", look.get("colours", {})).items()
    }
    geoms = look.get("geoms", [])
    if not isinstance(geoms, list):
        raise FFGymError(f"look.geoms must be a list of tables, got {geoms!r}.")
    return tuple(_geom(i, _table(f"look.geoms[{i}]", entry), colours, bodies) for i, entry in enumerate(geoms))


def _geom(index: int, entry: dict[str, Any], colours: Mapping[str, Any], bodies: tuple[str, ...]) -> Geom:
    where = f"look.geoms[{index}]"

    def vector(key: str) -> Any:
        return tuple(check_shape(f"{where} {key}", entry[key], (3,)).tolist())

    try:
        body = check_choice(f"{where} body", entry["body"], bodies)
        kind = check_choice(f"{where} type", entry["type"], ("box", "cylinder", "capsule", "sphere"))
        colour = colours[check_choice(f"{where} colour", entry["colour"], list(colours))]
        size = vector("half_size") if kind == "box" else (check_number(f"{where} radius", entry["radius"], unit="m"),)
        long = kind in ("cylinder", "capsule")
        pos, end = (vector("from"), vector("to")) if long else (vector("centre"), None)
    except KeyError as error:
        raise FFGymError(f"{where} ({entry}) lacks {error.args[0]!r}.") from error
    if min(size) <= 0 or pos == end:
        raise FFGymError(f"{where} has size {size} m from {pos} to {end} m; sizes and lengths must be > 0.")
    return Geom(body=body, type=kind, size=size, pos=pos, end=end, colour=colour)
