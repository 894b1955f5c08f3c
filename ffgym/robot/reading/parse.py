"""From the TOML of a description to a draft: every number that is there is checked, none has to be there."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_choice, check_number, check_shape, errors_at
from ffgym.core.toml import parse_toml
from ffgym.robot.parts import JOINT_TYPES, Geom, Logs, Spring
from ffgym.robot.reading.draft import RobotDraft
from ffgym.robot.reading.quantity import SIDES, JointFrame, Quantity, Rule, parse_quantity
from ffgym.robot.reading.rules import POINT, RULES, SPRING_RULES


def table_of(path: str, value: Any) -> dict[str, Any]:
    """Return `value` if it is a table."""
    if not isinstance(value, dict):
        raise FFGymError(f"[{path}] must be a table, got {value!r}.")
    return value


def names_of(what: str, value: Any) -> tuple[str, ...]:
    """Return a list of names, one or more."""
    if not isinstance(value, list) or not value or not all(isinstance(name, str) and name for name in value):
        raise FFGymError(f"{what} must be names, non-empty text, got {value!r}.")
    return tuple(value)


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


def parse_looks(look: Any, bodies: tuple[str, ...]) -> tuple[Geom, ...]:
    """Primitives of the table [look] for a robot with these bodies.

    Raises:
        FFGymError: if an entry is unknown or invalid.
    """
    unknown = sorted(set(table_of("look", look)) - {"colours", "geoms"})
    if unknown:
        raise FFGymError(f"[look] has unknown entries {unknown}, may have colours and geoms.")
    colours = {
        name: tuple(check_shape(f"look.colours.{name}", value, (4,)).tolist())
        for name, value in table_of("look.colours", look.get("colours", {})).items()
    }
    geoms = look.get("geoms", [])
    if not isinstance(geoms, list):
        raise FFGymError(f"look.geoms must be a list of tables, got {geoms!r}.")
    return tuple(_geom(i, table_of(f"look.geoms[{i}]", entry), colours, bodies) for i, entry in enumerate(geoms))


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


def parse_draft(text: str, where: str = "description", folder: str | Path = ".") -> RobotDraft:
    """Read a description that may lack entries from TOML text.

    Args:
        text: the description.
        where: its name, for messages.
        folder: where the path of an arm file starts.

    Raises:
        FFGymError: if the text is not TOML, or an entry is unknown or invalid.
    """
    tree = parse_toml(text, where)
    with errors_at(where):
        draft = _draft(tree, where, Path(folder))
        draft.check()
    return draft


def _draft(tree: dict[str, Any], where: str, folder: Path) -> RobotDraft:
    if "machine" in tree:
        raise FFGymError(
            "it is a machine file, and a description is needed here: give the robot that [machine] names in its place."
        )
    head = parse_head(tree.pop("robot", None), folder)
    look, logs, springs = tree.pop("look", {}), tree.pop("logs", {}), tree.pop("springs", {})
    quantities, waiting = _quantities(tree, head.types)
    quantities = {**head.quantities, **quantities}
    spring_list = _springs(springs, quantities, head.types)
    return RobotDraft(
        where=where,
        name=head.name,
        title=head.title,
        joints=head.joints,
        links=head.links,
        types=head.types,
        quantities=quantities,
        waiting=waiting,
        springs=spring_list,
        logs=_logs(logs),
        geoms=(*head.geoms, *parse_looks(look, ("base", *head.links, "tool"))),
    )


def _quantities(tree: dict[str, Any], types: tuple[str, ...]) -> tuple[dict[str, Quantity], tuple[str, ...]]:
    """Parse every quantity of the tree; also what has to wait for the gear ratios. Complain about what is not known."""
    points = table_of("work_area", tree.get("work_area", {})).pop("positions", {})
    points = table_of("work_area.positions", points)
    found = {
        f"{group}.{name}": table for group, entries in tree.items() for name, table in table_of(group, entries).items()
    }
    unknown = sorted(set(found) - set(RULES))
    if unknown:
        raise FFGymError(f"Unknown entries {unknown}. Available: {', '.join(sorted(RULES))}.")
    joints, has_gears = _joint_frame(found, types)
    parsed = {path: parse_quantity(path, table, RULES[path], joints) for path, table in found.items()}
    waiting = () if has_gears else tuple(path for path in found if _is_of_other_side(found[path], RULES[path]))
    parsed = {path: quantity for path, quantity in parsed.items() if path not in waiting}
    for name, table in points.items():
        path = f"work_area.positions.{name}"
        parsed[path] = parse_quantity(path, table, POINT, joints)
    return parsed, waiting


def _joint_frame(found: dict[str, Any], types: tuple[str, ...]) -> tuple[JointFrame, bool]:
    """Types and gear ratios of the joints, and whether the ratios are given; if not, ones serve to check the rest."""
    path, joints = "drive.gear_ratio", JointFrame(types=types)
    if path not in found:
        return JointFrame(types=types, gear_ratio=np.ones(len(types))), False
    return JointFrame(types=types, gear_ratio=parse_quantity(path, found[path], RULES[path], joints).value), True


def _is_of_other_side(table: Any, rule: Rule) -> bool:
    """Whether a valid entry is given on the side of the gearbox on which it is not kept."""
    return rule.side in SIDES and table.get("side") != rule.side


def _springs(springs: Any, quantities: dict[str, Quantity], types: tuple[str, ...]) -> tuple[Spring, ...]:
    """Springs of the description; their numbers are added to `quantities`."""
    return tuple(_spring(name, table, quantities, types) for name, table in table_of("springs", springs).items())


def _spring(name: str, table: Any, quantities: dict[str, Quantity], types: tuple[str, ...]) -> Spring:
    path = f"springs.{name}"
    entries = dict(table_of(path, table))
    bodies = names_of(f"{path}.bodies", entries.pop("bodies", None))
    needed = {key for key, rule in SPRING_RULES.items() if not rule.optional}
    if not needed <= set(entries) <= set(SPRING_RULES) or len(bodies) != 2:
        raise FFGymError(f"[{path}] must have two bodies and {', '.join(sorted(needed))}, got {sorted(table)}.")
    joints = JointFrame(types=types)
    own = {key: parse_quantity(f"{path}.{key}", entries[key], SPRING_RULES[key], joints) for key in entries}
    quantities |= {f"{path}.{key}": quantity for key, quantity in own.items()}
    first, second, third = (
        float(own[key].value) if key in own else 0.0 for key in ("stiffness", "stiffness_2", "stiffness_3")
    )
    return Spring(
        name=name,
        bodies=(bodies[0], bodies[1]),
        start=own["start"].value,
        end=own["end"].value,
        length=float(own["length"].value),
        stiffness=(first, second, third),
    )


def _logs(logs: Any) -> Logs:
    if not set(table_of("logs", logs)) <= {"torque", "position"}:
        raise FFGymError(f"[logs] may have torque and position, got {sorted(logs)}.")
    return Logs(**logs)
