"""What a description must say about one quantity: shape, unit, side of the gearbox, range."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array

OTHER_UNITS = {
    "rad": {"deg": np.pi / 180},
    "rad/s": {"deg/s": np.pi / 180},
    "m": {"mm": 1e-3},
    "m/s": {"mm/s": 1e-3},
    "kg m^2": {"kg cm^2": 1e-4},
}
"""Units that descriptions may use in place of SI, with the factor that converts them."""

MOTOR, LINK = "motor", "link"
SIDES = (MOTOR, LINK)
"""Of a gearbox."""


@dataclass(frozen=True, kw_only=True)
class Rule:
    """What a description must say about one quantity."""

    meaning: str
    """What it is, in a few words."""
    shape: tuple[int | str, ...]
    """Wanted shape; 'N' stands for the number of joints."""
    unit: str
    """SI unit; on the link side, that of a hinge."""
    slide_unit: str | None = None
    """SI unit of a sliding joint, None if it is the same."""
    side: str | None = None
    """Side of the gearbox on which the quantity is kept, None where the question does not arise."""
    gear_power: int | None = None
    """p in: motor side = link side x |gear ratio|^p, for quantities that may be given on either side."""
    signed: bool = False
    """True if the quantity counts along the motion, so that the gear ratio's sign belongs to the conversion."""
    low: float = -np.inf
    """Smallest valid number."""
    open_low: bool = False
    """True if `low` itself is not valid."""
    nonzero: bool = False
    """True if 0 is not valid."""
    infinite: bool = False
    """True if +inf is valid (a rigid joint)."""
    optional: bool = False
    """True if a description may do without."""


@dataclass(frozen=True, kw_only=True, eq=False)
class JointFrame:
    """What the reading of a quantity must know about the joints."""

    types: tuple[str, ...]
    """'hinge' or 'slide', one per joint."""
    gear_ratio: Array | None = None
    """Motor over joint motion, shape (N,); None while it is not known."""

    @property
    def n_joints(self) -> int:
        """Number of joints N."""
        return len(self.types)


def si_units(rule: Rule, side: str | None, joints: JointFrame) -> tuple[str, ...]:
    """Wanted SI units on a side: one, or one per joint where hinges and sliding joints differ."""
    if rule.slide_unit is None or side == MOTOR or "N" not in rule.shape:
        return (rule.unit,)
    units = tuple(rule.slide_unit if kind == "slide" else rule.unit for kind in joints.types)
    return units if len(set(units)) > 1 else units[:1]


def unit_factors(path: str, unit: object, rule: Rule, side: str | None, joints: JointFrame) -> Array:
    """Factors that convert to SI: one number, or one per joint, shaped to multiply the value.

    Raises:
        FFGymError: if `unit` is none that the quantity may have.
    """
    wanted = si_units(rule, side, joints)
    if isinstance(unit, list) and "N" in rule.shape and len(unit) == joints.n_joints:
        wanted = wanted if len(wanted) > 1 else wanted * joints.n_joints
        factors = [_factor(have, want) for have, want in zip(unit, wanted, strict=True)]
    else:
        factors = [_factor(unit, wanted[0]) if len(wanted) == 1 else None]
    if None in factors:
        raise FFGymError(f"{path}: unit is {unit!r}, must be {_choices(wanted)}.")
    return _per_joint(np.array(factors, dtype=np.float64), rule)


def gear_factors(path: str, rule: Rule, side: str | None, joints: JointFrame) -> Array | float:
    """Factors that bring a quantity from the side it is given on to the one it is kept on.

    Raises:
        FFGymError: if the quantity does not exist on that side.
    """
    if side == rule.side:
        return 1.0
    if rule.gear_power is None or side not in (MOTOR, LINK):
        valid = repr(rule.side) if rule.gear_power is None else f"{MOTOR!r} or {LINK!r}"
        raise FFGymError(f"{path}: side is {side!r}, must be {valid}.")
    if joints.gear_ratio is None:
        raise FFGymError(f"{path}: side is {side!r}; to bring it to the {rule.side} side takes drive.gear_ratio.")
    power = rule.gear_power if rule.side == MOTOR else -rule.gear_power
    ratio = joints.gear_ratio if rule.signed else np.abs(joints.gear_ratio)
    return _per_joint(ratio ** float(power), rule)


def _factor(unit: object, wanted: str) -> float | None:
    if unit == wanted:
        return 1.0
    return OTHER_UNITS.get(wanted, {}).get(unit) if isinstance(unit, str) else None


def _choices(wanted: tuple[str, ...]) -> str:
    if len(wanted) > 1:
        return f"one per joint, {list(wanted)}"
    return " or ".join(repr(unit) for unit in (wanted[0], *OTHER_UNITS.get(wanted[0], {})))


def _per_joint(factors: Array, rule: Rule) -> Array:
    """Factors (1,) or (N,) in a shape that multiplies a value of shape (N, ...)."""
    return factors.reshape(-1, *[1] * (len(rule.shape) - 1)) if len(factors) > 1 else factors.reshape(())
