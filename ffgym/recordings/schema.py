"""The columns a recording may have: names, units, sides and meanings, as data."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from types import MappingProxyType
from typing import Literal

from ffgym.core.errors import FFGymError

Side = Literal["motor", "link", "tool", "none"]
"""Place of a quantity: before the gearbox, after it, at the tool, or none of these."""

USER_PREFIX = "user."
"""Prefix of the user's own columns; their unit is in the header field `units`."""

VALID = "valid"
"""Family of masks: rows that count for each joint."""

_AFTER_GEARBOX = "after the gearbox (arm side); only of joints with an encoder there"

_USER_NAME = re.compile(r"user\.[A-Za-z0-9_./-]+")


@dataclass(frozen=True)
class Family:
    """Columns that share a name, a unit and a meaning: `<name>`, or `<name>.<part>` for each joint or axis."""

    name: str
    """Channel and field, for example `motor.position`."""
    unit: str
    """SI unit; degC for temperatures."""
    side: Side
    """Place of the quantity, unless the header field `decided_by` says otherwise."""
    meaning: str
    """One phrase for the documentation."""
    parts: Literal["one", "joint", "xyz", "quaternion"] = "joint"
    """One column, one per joint, one per Cartesian axis, or the four of a unit quaternion, scalar first."""
    decided_by: str = ""
    """Header field that may move the quantity to another side; empty if the side is fixed."""
    may_miss: bool = False
    """True if NaN marks a missing sample; in other families NaN is an error."""
    may_lack: bool = False
    """True if joints without such a sensor have no column; in other families all joints have one, or none has."""

    def columns(self, joints: Sequence[str]) -> tuple[str, ...]:
        """Return the names of all columns of this family on a robot with `joints`."""
        if self.parts == "one":
            return (self.name,)
        parts = {"joint": joints, "xyz": "xyz", "quaternion": ("qw", "qx", "qy", "qz")}[self.parts]
        return tuple(f"{self.name}.{part}" for part in parts)


_FAMILIES = (
    Family("timestamp", "s", "none", "controller clock, strictly increasing; required", parts="one"),
    Family("motor.position", "rad", "motor", "measured motor (resolver) angle", decided_by="position_side"),
    Family(
        "motor.velocity",
        "rad/s",
        "motor",
        "measured motor speed; never a filtered estimate without saying so in `filters`",
        decided_by="position_side",
    ),
    Family(
        "motor.effort",
        "N m",
        "motor",
        "motor torque; `torque_semantics` says how it is known",
        decided_by="torque_semantics",
    ),
    Family("reference.position", "rad", "motor", "set-point that the controller tracked", decided_by="position_side"),
    Family("reference.velocity", "rad/s", "motor", "speed of the set-point", decided_by="position_side"),
    Family("reference.acceleration", "rad/s^2", "motor", "acceleration of the set-point", decided_by="position_side"),
    Family(
        "correction.position",
        "rad",
        "motor",
        "part of the set-point that a feed-forward law added; `reference.position` has it, too",
        decided_by="position_side",
    ),
    Family("feedforward.effort", "N m", "motor", "rigid-body feed-forward u_ff", decided_by="torque_semantics"),
    Family(
        "feedback.effort",
        "N m",
        "motor",
        "feedback torque u_c, integral part included",
        decided_by="torque_semantics",
    ),
    Family(
        "feedback.integral", "N m", "motor", "integral part u_I of the feedback torque", decided_by="torque_semantics"
    ),
    Family("compensation.effort", "N m", "motor", "added feed-forward u_lff", decided_by="torque_semantics"),
    Family("command.effort", "N m", "motor", "total commanded torque", decided_by="torque_semantics"),
    Family("friction.effort", "N m", "motor", "true friction torque, simulation only"),
    Family("arm_friction.effort", "N m", "link", "true friction torque behind the elasticity, simulation only"),
    Family("link.position", "rad", "link", f"joint angle {_AFTER_GEARBOX}", may_lack=True),
    Family("link.velocity", "rad/s", "link", f"joint speed {_AFTER_GEARBOX}", may_lack=True),
    Family("tcp.position", "m", "tool", "tool centre point, measured", parts="xyz", may_miss=True),
    Family(
        "tcp.orientation",
        "1",
        "tool",
        "orientation of tool0 in the world, measured",
        parts="quaternion",
        may_miss=True,
    ),
    Family("tcp_reference.position", "m", "tool", "tool centre point, set-point", parts="xyz"),
    Family("tcp.timestamp", "s", "tool", "clock of the tool tracker", parts="one", may_miss=True),
    Family("temperature", "degC", "none", "motor or gearbox temperature; say which in `meta`", may_miss=True),
    Family(VALID, "1", "none", "1 where the row counts for the joint, 0 where it does not, as in a gap or a stop"),
)

FAMILIES: Mapping[str, Family] = MappingProxyType({family.name: family for family in _FAMILIES})
"""Every family by name, in the order of the documentation."""


def family_named(name: str) -> Family:
    """Return the family called `name`; an error lists the closest names."""
    if name not in FAMILIES:
        raise FFGymError(f"Unknown column family {short(name)!r}. {closest(name, FAMILIES)}")
    return FAMILIES[name]


def family_of(column: str) -> Family | None:
    """Return the family of a column; None for the user's own columns."""
    return FAMILIES.get(column) or FAMILIES.get(column.rpartition(".")[0])


def check_columns(names: Iterable[str], joints: Sequence[str], units: Mapping[str, str]) -> None:
    """Check that `names` are columns of the schema, or of the user with a unit, and that families are complete."""
    owner = _owners(tuple(joints))
    present = list(names)
    for name in present:
        if name not in owner:
            _check_user_column(name, joints, units, owner)
    held = set(present)
    for family in dict.fromkeys(owner[name] for name in present if name in owner):
        missing = [column for column in family.columns(joints) if column not in held]
        if missing and not family.may_lack:
            raise FFGymError(f"{family.name} is incomplete: {', '.join(missing)} missing. Add them or drop the family.")


@lru_cache(maxsize=64)
def _owners(joints: tuple[str, ...]) -> Mapping[str, Family]:
    """Map every column of a robot with `joints` to its family."""
    return MappingProxyType({column: family for family in _FAMILIES for column in family.columns(joints)})


def _check_user_column(name: str, joints: Sequence[str], units: Mapping[str, str], owner: Iterable[str]) -> None:
    """Accept a well-named user column that has a unit; explain the mistake of any other."""
    if not isinstance(name, str):
        raise FFGymError(f"Column names must be text, got {name!r}.")
    if name.startswith(USER_PREFIX):
        if not _USER_NAME.fullmatch(name):
            raise FFGymError(f"Column {short(name)!r} must be user. followed by letters, digits or any of _ . / -")
        if name not in units:
            raise FFGymError(f"Column {name!r} has no unit. Give one in the header: units={{{name!r}: 'N m'}}.")
        return
    if name in FAMILIES:
        raise FFGymError(f"Column {name!r} lacks its last part, must be {', '.join(FAMILIES[name].columns(joints))}.")
    family, _, part = name.rpartition(".")
    if family in FAMILIES and FAMILIES[family].parts == "joint" and part not in joints:
        raise FFGymError(f"Column {short(name)!r} names joint {short(part)!r}, but header.joints is {tuple(joints)}.")
    way_out = f"{closest(name, owner)} Name columns of your own user.<name> and give their unit in header.units."
    raise FFGymError(f"Unknown column {short(name)!r}. {way_out}")


def closest(name: str, known: Iterable[str]) -> str:
    """List known names that look like an unknown one, or all of them, for messages."""
    known = list(known)
    return alike(name, known) or f"Available: {', '.join(known)}."


def alike(name: str, known: Iterable[str]) -> str:
    """List known names that look like an unknown one, if there are any, for messages."""
    near = get_close_matches(short(name), list(known), n=3, cutoff=0.5)
    return f"Closest: {', '.join(near)}." if near else ""


def short(name: str) -> str:
    """Shorten a name that is too long for a message or a search of similar names."""
    return name if len(name) <= 80 else name[:77] + "..."
