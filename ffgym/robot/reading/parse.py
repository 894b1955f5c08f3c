"""Parser from the TOML of a description to a draft: every number is checked, none is required."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_choice, check_number, check_shape, errors_at
from ffgym.core.toml import parse_toml
from ffgym.robot.parts import JOINT_TYPES, Geom, Logs, Spring
from ffgym.robot.reading.draft import RobotDraft
from ffgym.robot.reading.quantity import SIDES, Quantity, parse_quantity
from ffgym.robot.reading.rules import POINT, RULES, SPRING_RULES


def _table(path: str, value: Any) -> dict[str, Any]:
    """Return `value` if it is a table."""
    if not isinstance(value, dict):
        raise FFGymError(f"[{path}] must be a table, got {value!r}.")
    return value


def _names(what: str, value: Any) -> tuple[str, ...]:
    """Return a list of names, one or more."""
    if not isinstance(value, list) or not value or not all(isinstance(name, str) and name for name in value):
        raise FFGymError(f"{what} must be names, non-empty text, got {value!r}.")
    return tuple(value)


_NAMED = {"name", "title", "joints", "links"}
_FROM_FILE = {"name", "title", "model"}


def _head(head: Any, folder: Path) -> dict[str, Any]:
    """Parse the table [robot] of a description in `folder`, and its arm file if it names one, as fields of a draft."""
    # joints by name, or those of an arm file
    keys = set(head) if isinstance(head, dict) else set()
    from_file = "model" in keys
    needed, others = (_FROM_FILE, {"joints", "tool_frame", "looks"}) if from_file else (_NAMED, {"types"})
    if not needed <= keys <= needed | others:
        raise FFGymError(
            "[robot] must have exactly name, title, joints and links, and may have types; or name, title and model, "
            f"and may have joints, tool_frame and looks. Got {sorted(map(str, keys)) or head!r}."
        )
    name, title = _names("[robot] name and title", [head["name"], head["title"]])
    fields: dict[str, Any] = {"name": name, "title": title}
    if not from_file:
        joints, links = _names("[robot] joints", head["joints"]), _names("[robot] links", head["links"])
        types = _names("[robot] types", head.get("types", ["hinge"] * len(joints)))
        for kind in types:
            check_choice("[robot] types", kind, JOINT_TYPES)
        if len(types) != len(joints):
            raise FFGymError(f"[robot] has {len(types)} types for {len(joints)} joints; give one per joint.")
        return fields | {"joints": joints, "links": links, "types": types, "quantities": {}, "geoms": ()}

    from ffgym.robot.arm_file import flange_at, read_arm  # loaded with the first arm file

    (model,) = _names("[robot] model", [head["model"]])
    (looks,) = _names("[robot] looks", [head.get("looks", "file")])
    check_choice("[robot] looks", looks, ("file", "none"))
    # masses, frames and shapes from the arm file, with the flange where one is named
    chosen = _names("[robot] joints", head["joints"]) if "joints" in head else None
    arm = read_arm(folder / model, chosen, looks=looks == "file")
    flange: Mapping[str, Quantity] = {}
    if "tool_frame" in head:
        (frame,) = _names("[robot] tool_frame", [head["tool_frame"]])
        flange = flange_at(arm, frame)
    quantities = {**arm.quantities, **flange}
    return fields | {
        "joints": arm.joints,
        "links": arm.links,
        "types": arm.types,
        "quantities": quantities,
        "geoms": arm.geoms,
    }


def _looks(look: Any, bodies: tuple[str, ...]) -> tuple[Geom, ...]:
    """Parse the primitives of the table [look] for a robot with these bodies."""
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


def parse_draft(text: str, where: str = "description", folder: str | Path = ".") -> RobotDraft:
    """Read a description that may lack entries; `where` names the text, paths of arm files start in `folder`."""
    tree = parse_toml(text, where)
    with errors_at(where):
        if "machine" in tree:
            raise FFGymError(
                "it is a machine file, and a description is needed here: give the robot that [machine] names in its "
                "place."
            )
        fields = _head(tree.pop("robot", None), Path(folder))
        # tables without physical quantities are read apart from the quantities
        look, logs, springs = tree.pop("look", {}), tree.pop("logs", {}), tree.pop("springs", {})
        quantities, waiting = _quantities(tree, fields["types"])
        fields["quantities"].update(quantities)
        spring_list = [
            _spring(name, table, fields["quantities"], fields["types"])
            for name, table in _table("springs", springs).items()
        ]
        if not set(_table("logs", logs)) <= {"torque", "position"}:
            raise FFGymError(f"[logs] may have torque and position, got {sorted(logs)}.")
        logged = Logs(**logs)
        fields["geoms"] = (*fields["geoms"], *_looks(look, ("base", *fields["links"], "tool")))
        draft = RobotDraft(where=where, waiting=waiting, springs=tuple(spring_list), logs=logged, **fields)
        draft.check()
    return draft


def _quantities(tree: dict[str, Any], types: tuple[str, ...]) -> tuple[dict[str, Quantity], tuple[str, ...]]:
    """Parse every quantity of the tree; also what has to wait for the gear ratios. Complain about what is not known."""
    points = _table("work_area", tree.get("work_area", {})).pop("positions", {})
    points = _table("work_area.positions", points)
    found = {
        f"{group}.{name}": table for group, entries in tree.items() for name, table in _table(group, entries).items()
    }
    unknown = sorted(set(found) - set(RULES))
    if unknown:
        raise FFGymError(f"Unknown entries {unknown}. Available: {', '.join(sorted(RULES))}.")
    # without gear ratios, ones serve to check what is given on the other side of the gearbox, which waits for them
    gears, path = np.ones(len(types)), "drive.gear_ratio"
    if path in found:
        gears = parse_quantity(path, found[path], RULES[path], types).value
    parsed = {path: parse_quantity(path, table, RULES[path], types, gears) for path, table in found.items()}
    waiting: tuple[str, ...] = ()
    if path not in found:
        sided = [path for path in found if RULES[path].side in SIDES]
        waiting = tuple(path for path in sided if found[path].get("side") != RULES[path].side)
    parsed = {path: quantity for path, quantity in parsed.items() if path not in waiting}
    for name, table in points.items():
        path = f"work_area.positions.{name}"
        parsed[path] = parse_quantity(path, table, POINT, types)
    return parsed, waiting


def _spring(name: str, table: Any, quantities: dict[str, Quantity], types: tuple[str, ...]) -> Spring:
    """Parse one spring; its numbers are added to `quantities`."""
    path = f"springs.{name}"
    entries = dict(_table(path, table))
    bodies = _names(f"{path}.bodies", entries.pop("bodies", None))
    needed = {key for key, rule in SPRING_RULES.items() if not rule.optional}
    if not needed <= set(entries) <= set(SPRING_RULES) or len(bodies) != 2:
        raise FFGymError(f"[{path}] must have two bodies and {', '.join(sorted(needed))}, got {sorted(table)}.")
    own = {key: parse_quantity(f"{path}.{key}", entries[key], SPRING_RULES[key], types) for key in entries}
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
