"""The columns a recording may have: names, units, sides and meanings, as data."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from types import MappingProxyType
from typing import Literal

from ffgym.core.errors import FFGymError

Side = Literal["motor", "link", "tool", "none"]
"""Where a quantity lives: before the gearbox, after it, at the tool, or nowhere in particular."""

USER_PREFIX = "user."
"""Columns of your own start with this; their unit stands in the header field `units`."""

VALID = "valid"
"""Family that says which rows count for which joint."""

_USER_NAME = re.compile(r"user\.[A-Za-z0-9_./-]+")


@dataclass(frozen=True, kw_only=True)
class Family:
    """Columns that share a name, a unit and a meaning: `<name>`, or `<name>.<part>` for each joint or axis."""

    name: str
    """Channel and field, for example `motor.position`."""
    unit: str
    """SI unit; degC for temperatures."""
    side: Side
    """Where the quantity lives, unless the header field `decided_by` says otherwise."""
    meaning: str
    """One phrase for the documentation."""
    parts: Literal["one", "joint", "xyz", "quaternion"] = "joint"
    """One column, one per joint, one per Cartesian axis, or the four of a unit quaternion, scalar first."""
    decided_by: str = ""
    """Header field that may move the quantity to another side; empty if the side is fixed."""
    may_miss: bool = False
    """Whether NaN marks a missing sample. Elsewhere NaN is an error."""
    may_lack: bool = False
    """Whether joints without such a sensor have no column. Elsewhere all joints have one, or none has."""

    def columns(self, joints: Sequence[str]) -> tuple[str, ...]:
        """Names of all columns of this family on a robot with `joints`."""
        if self.parts == "one":
            return (self.name,)
        parts = {"joint": joints, "xyz": "xyz", "quaternion": ("qw", "qx", "qy", "qz")}[self.parts]
        return tuple(f"{self.name}.{part}" for part in parts)


def _position(name: str, unit: str, meaning: str) -> Family:
    return Family(name=name, unit=unit, side="motor", meaning=meaning, decided_by="position_side")


def _torque(name: str, meaning: str) -> Family:
    return Family(name=name, unit="N m", side="motor", meaning=meaning, decided_by="torque_semantics")


_FAMILIES = (
    Family(
        name="timestamp", unit="s", side="none", parts="one", meaning="controller clock, strictly increasing; required"
    ),
    _position("motor.position", "rad", "measured motor (resolver) angle"),
    _position(
        "motor.velocity", "rad/s", "measured motor speed; never a filtered estimate without saying so in `filters`"
    ),
    _torque("motor.effort", "motor torque; `torque_semantics` says how it is known"),
    _position("reference.position", "rad", "set-point that the controller tracked"),
    _position("reference.velocity", "rad/s", "speed of the set-point"),
    _position("reference.acceleration", "rad/s^2", "acceleration of the set-point"),
    _torque("feedforward.effort", "rigid-body feed-forward u_ff"),
    _torque("feedback.effort", "feedback torque u_c, integral part included"),
    _torque("feedback.integral", "integral part u_I of the feedback torque"),
    _torque("compensation.effort", "added feed-forward u_lff"),
    _torque("command.effort", "total commanded torque"),
    Family(name="friction.effort", unit="N m", side="motor", meaning="true friction torque, simulation only"),
    Family(
        name="link.position",
        unit="rad",
        side="link",
        may_lack=True,
        meaning="joint angle after the gearbox (arm side); only of joints with an encoder there",
    ),
    Family(
        name="link.velocity",
        unit="rad/s",
        side="link",
        may_lack=True,
        meaning="joint speed after the gearbox (arm side); only of joints with an encoder there",
    ),
    Family(
        name="tcp.position", unit="m", side="tool", parts="xyz", may_miss=True, meaning="tool centre point, measured"
    ),
    Family(
        name="tcp.orientation",
        unit="1",
        side="tool",
        parts="quaternion",
        may_miss=True,
        meaning="orientation of tool0 in the world, measured",
    ),
    Family(name="tcp_reference.position", unit="m", side="tool", parts="xyz", meaning="tool centre point, set-point"),
    Family(
        name="tcp.timestamp", unit="s", side="tool", parts="one", may_miss=True, meaning="clock of the tool tracker"
    ),
    Family(
        name="temperature",
        unit="degC",
        side="none",
        may_miss=True,
        meaning="motor or gearbox temperature; say which in `meta`",
    ),
    Family(
        name=VALID,
        unit="1",
        side="none",
        meaning="1 where the row counts for the joint, 0 where it does not, as in a gap or a stop",
    ),
)

FAMILIES: Mapping[str, Family] = MappingProxyType({family.name: family for family in _FAMILIES})
"""Every family by name, in the order of the documentation."""


def family_named(name: str) -> Family:
    """Return the family called `name`; an error lists the closest names."""
    if name not in FAMILIES:
        raise FFGymError(f"Unknown column family {short(name)!r}. {closest(name, FAMILIES)}")
    return FAMILIES[name]


def family_of(column: str) -> Family | None:
    """Family that a column belongs to; None for a column of the user's own."""
    return FAMILIES.get(column) or FAMILIES.get(column.rpartition(".")[0])


def check_columns(names: Iterable[str], joints: Sequence[str], units: Mapping[str, str]) -> None:
    """Check that `names` are columns of the schema, or of the user with a unit, and no family is left half filled."""
    owner = {column: family for family in _FAMILIES for column in family.columns(joints)}
    present = list(names)
    for name in present:
        if name not in owner:
            _check_user_column(name, joints, units, owner)
    held = set(present)
    for family in dict.fromkeys(owner[name] for name in present if name in owner):
        missing = [column for column in family.columns(joints) if column not in held]
        if missing and not family.may_lack:
            raise FFGymError(f"{family.name} is incomplete: {', '.join(missing)} missing. Add them or drop the family.")


def _check_user_column(name: str, joints: Sequence[str], units: Mapping[str, str], owner: Iterable[str]) -> None:
    """Accept a well-named user column that has a unit; say what is wrong with anything else."""
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
    """For messages about an unknown name: the known ones that look like it, or all of them."""
    known = list(known)
    return alike(name, known) or f"Available: {', '.join(known)}."


def alike(name: str, known: Iterable[str]) -> str:
    """For messages about an unknown name: the known ones that look like it, or nothing."""
    near = get_close_matches(short(name), list(known), n=3, cutoff=0.5)
    return f"Closest: {', '.join(near)}." if near else ""


def short(name: str) -> str:
    """Cut a name so long that it can only be damage, for messages and for the search of close ones."""
    return name if len(name) <= 80 else name[:77] + "..."
