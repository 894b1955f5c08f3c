"""A mistake in wiring, in words."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.logs.quality.wiring.found import Found
from ffgym.logs.quality.wiring.hypothesis import EFFORTS, MOTIONS, Hypothesis, Kind
from ffgym.logs.quality.wiring.sample import Samples


@final
@dataclass(frozen=True, kw_only=True)
class Mistake:
    """A mistake that was made with columns of all logs."""

    kind: Kind
    families: tuple[str, ...]
    """Families of columns; empty for the clock."""
    joints: tuple[str, ...]
    """Joints, or axes of the tracker; empty for the clock."""
    factors: tuple[float, ...]
    """By which the numbers must be multiplied, one per joint; empty if they must not."""
    amount: float
    """Of a zero, which must be added [rad or m, as kept]; of a delay [s of the clock as given]."""
    before: float
    """Share of the energy of the signal that tells it, left unexplained by the logs as given."""
    after: float
    """The same without the mistake."""
    message: str
    """One sentence: what is wrong, what shows it, the way out."""


def mistake_of(found: Found, samples: Samples, ratio: tuple[float, ...]) -> Mistake:
    """What was found, for people and programs."""
    one = found.hypothesis
    family, part = found.telling
    before, after = found.before[found.telling], found.after[found.telling]
    names = _parts(one, samples)
    signal = f"{family} of {samples.joints[part]}" if part or not family.startswith("tcp") else family
    fault = _fault(one, names, samples, ratio)
    fault = fault[0].upper() + fault[1:] if fault.startswith(("all ", "timestamp")) else fault
    message = (
        f"{fault}. As given, {_share(before)} of the energy of {signal} is left unexplained, read otherwise "
        f"{_share(after)}. {_way_out(one)}."
    )
    return Mistake(
        kind=one.kind,
        families=one.families,
        joints=names,
        factors=one.factors,
        amount=one.amount,
        before=before,
        after=after,
        message=message,
    )


def _parts(one: Hypothesis, samples: Samples) -> tuple[str, ...]:
    names = tuple("xyz") if one.families and one.families[0].startswith("tcp") else samples.joints
    return tuple(names[part] for part in one.parts)


def _fault(one: Hypothesis, names: tuple[str, ...], samples: Samples, ratio: tuple[float, ...]) -> str:
    what, who = _what(one, samples), _who(names, samples)
    match one.kind:
        case "sign":
            return f"{what} of {who}: wrong sign"
        case "swap":
            return f"{what} of {names[0]} and {names[1]}: swapped"
        case "axes":
            order = ", ".join(("-" if f < 0 else "") + "xyz"[p] for p, f in zip(one.order, one.factors, strict=True))
            return f"{what}: axes in another order or direction, x, y, z of the robot are {order} of the file"
        case "unit":
            return f"{what} of {who}: in {one.unit}" if one.families[0][:3] != "tcp" else f"{what}: in {one.unit}"
        case "side":
            # a torque behind the gearbox is larger, a position smaller
            behind = (one.factors[0] < 1) == (one.families[0] in EFFORTS)
            return f"{what} of {who}: of the {'link' if behind else 'motor'} side of the gearbox"
        case "zero":
            turn = one.amount / (ratio[one.parts[0]] if samples.header.position_side == "motor" else 1.0)
            return f"{what} of {who}: zero off by {-np.degrees(turn):.1f} deg behind the gearbox"
        case "delay":
            return f"{what} of {who}: {'late' if one.amount > 0 else 'early'} by {abs(one.amount):.3g} s"
        case "clock":
            rate = f"in {one.unit}" if one.unit else f"runs {1 / one.factors[0]:g} times as fast as time"
            return f"timestamp: {rate}"
        case "current":
            sizes = ", ".join(f"{1 / factor:.3g}" for factor in one.factors)
            return f"{what} of {who}: {sizes} times what the description needs, as if it were a current in A"


def _what(one: Hypothesis, samples: Samples) -> str:
    """Families in a word, where there is one."""
    groups = {"all channels": (*MOTIONS, *EFFORTS), "all positions and speeds": MOTIONS, "all torques": EFFORTS}
    for name, families in groups.items():
        if one.families == tuple(f for f in families if f in samples.present) and len(one.families) > 1:
            return name
    return ", ".join(one.families)


def _who(names: tuple[str, ...], samples: Samples) -> str:
    return "all joints" if len(names) == len(samples.joints) > 1 else ", ".join(names)


def _way_out(one: Hypothesis) -> str:
    if one.kind == "current":
        return "Give the torque per ampere of each motor as scale; the corrected map holds what the logs say"
    return "Correct the columns, or read the files with the corrected column map"


def _share(left: float) -> str:
    if left > 1.0:
        return "more than all"
    return f"{left:.0%}" if left >= 0.1 else f"{left:.1%}"
