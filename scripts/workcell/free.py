"""What the calibration may change: factors on numbers of the prior, and shifts of them, each with its uncertainty."""

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ffgym.core.types import Array

File = Literal["machine", "controller"]
"""What the machine is, or what its controller knows."""

Trees = Mapping[File, dict[str, Any]]

MAIN, WRIST, ALL = (0, 1, 2), (3, 4, 5), (0, 1, 2, 3, 4, 5)
UNSOURCED = (1, 2, 3, 4, 5)
"""Joints whose friction nobody identified; that of joint 1 is the thesis'."""


@dataclass(frozen=True, kw_only=True)
class Free:
    """One free number x: prior values are multiplied by exp(x), or x times a scale is added to them."""

    name: str
    spread: float
    """Standard deviation of x: how well the prior is known."""
    entries: tuple[str, ...]
    """Entries of the file that it changes, e.g. 'friction.coulomb'."""
    joints: tuple[int, ...] = ALL
    file: File = "machine"
    added_to: str | None = None
    """Entry whose prior value is the scale of a shift, '1' for none; None is a factor."""
    low: float = -np.inf
    """Smallest x."""


def _each(name: str, spread: float, entries: Sequence[str], joints: Sequence[int] = ALL, **more: Any) -> list[Free]:
    """One free number per joint."""
    return [
        Free(name=f"{name}, joint {j + 1}", spread=spread, entries=tuple(entries), joints=(j,), **more) for j in joints
    ]


_LEVEL = ("friction.coulomb", "friction.static", "friction.bristle_stiffness", "friction.bristle_damping")
_WITH_LEVEL = tuple(f"effects.{name}.level" for name in ("slow_stribeck", "slip_elements", "one_way_friction"))
_LOSSES = "effects.gear_losses"

FREE: tuple[Free, ...] = (
    *_each("friction level", 0.3, (*_LEVEL, *_WITH_LEVEL), UNSOURCED),
    *_each("viscous friction", 0.8, ("friction.viscous", "effects.cold_oil.viscous"), UNSOURCED),
    Free(name="bristle stiffness", spread=0.5, entries=("friction.bristle_stiffness",), joints=UNSOURCED),
    *_each(
        "second Stribeck term", 0.1, ("effects.slow_stribeck.level",), UNSOURCED, added_to="friction.coulomb", low=-0.1
    ),
    Free(name="speed of the second Stribeck term", spread=0.7, entries=("effects.slow_stribeck.speed",)),
    *_each("difference by direction", 0.07, ("effects.one_way_friction.level",), added_to="friction.coulomb"),
    Free(name="losses, motor drives", spread=0.5, entries=(f"{_LOSSES}.driving",)),
    Free(name="losses, load drives", spread=0.5, entries=(f"{_LOSSES}.driven",)),
    Free(name="hysteresis, main", spread=0.7, entries=("effects.smooth_hysteresis.level",), joints=MAIN),
    Free(name="hysteresis, wrist", spread=0.7, entries=("effects.smooth_hysteresis.level",), joints=WRIST),
    Free(name="transmission error", spread=0.7, entries=("effects.two_harmonic_gear_error.amplitude",)),
    *_each("stiffness", 0.4, ("drive.joint_stiffness", "drive.joint_damping")),
    Free(name="damping, main", spread=0.5, entries=("drive.joint_damping",), joints=MAIN),
    Free(name="damping, wrist", spread=0.5, entries=("drive.joint_damping",), joints=WRIST),
    *_each("link", 0.2, ("links.mass", "links.inertia")),
    Free(name="rotors, main", spread=0.25, entries=("drive.rotor_inertia",), joints=MAIN),
    Free(name="rotors, wrist", spread=0.25, entries=("drive.rotor_inertia",), joints=WRIST),
    Free(name="payload", spread=4.0, entries=("payload.mass",), added_to="1", low=-2.0),
    *_each("older friction level", 0.25, _LEVEL, file="controller"),
    *_each("older viscous friction", 0.7, ("friction.viscous",), file="controller"),
    Free(
        name="older breakaway torque",
        spread=0.035,
        entries=("friction.static",),
        file="controller",
        added_to="friction.coulomb",
        low=-0.0497,  # then it is Coulomb friction
    ),
    Free(name="older Stribeck velocity", spread=0.7, entries=("friction.stribeck_velocity",), file="controller"),
    Free(name="older bristle stiffness", spread=0.7, entries=("friction.bristle_stiffness",), file="controller"),
    Free(name="older bristle damping", spread=0.7, entries=("friction.bristle_damping",), file="controller"),
)
"""Spreads: friction levels of one robot type differ by 30 % (Bittencourt 2012); viscous friction of joints 2 to 6 and
stiffness are known within factors of 5 and 2.5, masses and inertias within 30 %, rotors within a factor 2, read as two
to three spreads (docs/robots/irb4600_60_205.md); the rest is chosen, 0.5 to 0.7 where only the order of magnitude is
known."""

SPREAD = np.array([free.spread for free in FREE])
LOW = np.array([free.low for free in FREE])


def applied(prior: Trees, x: Array) -> dict[File, dict[str, Any]]:
    """The prior's tables with the free numbers `x` (K,) in them: shifts first, then factors."""
    out: dict[File, dict[str, Any]] = {name: deepcopy(tree) for name, tree in prior.items()}
    order = sorted(range(len(FREE)), key=lambda i: FREE[i].added_to is None)
    for i in order:
        free = FREE[i]
        for entry in free.entries:
            table = table_at(out[free.file], entry)
            values = np.array(table["value"], dtype=np.float64)
            where: Any = list(free.joints) if values.ndim else ...
            if free.added_to is None:
                values[where] *= np.exp(x[i])
            else:
                scale = (
                    1.0 if free.added_to == "1" else np.array(table_at(prior[free.file], free.added_to)["value"])[where]
                )
                values[where] += x[i] * scale
            table["value"] = values.tolist()
    return out


def changed_entries() -> set[tuple[File, str]]:
    """Files and entries that the calibration changes."""
    return {(free.file, entry) for free in FREE for entry in free.entries}


def table_at(tree: Mapping[str, Any], entry: str) -> dict[str, Any]:
    """Table of value, unit and source of an entry such as 'friction.coulomb'."""
    found: Any = tree
    for key in entry.split("."):
        found = found[key]
    table: dict[str, Any] = found
    return table
