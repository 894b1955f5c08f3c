"""From the TOML of a description to a draft: every number that is there is checked, none has to be there."""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.robot.parts import Logs, Spring
from ffgym.robot.reading.draft import RobotDraft
from ffgym.robot.reading.head import parse_head
from ffgym.robot.reading.parse_looks import parse_looks
from ffgym.robot.reading.quantity import Quantity, parse_quantity
from ffgym.robot.reading.rule import SIDES, JointFrame, Rule
from ffgym.robot.reading.rules import POINT, RULES, SPRING_RULES
from ffgym.robot.reading.tables import names_of, table_of


def parse_draft(text: str, where: str = "description", folder: str | Path = ".") -> RobotDraft:
    """Read a description that may lack entries from TOML text.

    Args:
        text: the description.
        where: its name, for messages.
        folder: where the path of an arm file starts.

    Raises:
        FFGymError: if the text is not TOML, or an entry is unknown or invalid.
    """
    try:
        tree = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise FFGymError(f"{where} is not valid TOML: {error}.") from error
    try:
        draft = _draft(tree, where, Path(folder))
        draft.check()
    except FFGymError as error:
        raise FFGymError(f"{where}: {error}") from error
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
