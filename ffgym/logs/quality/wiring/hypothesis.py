"""Mistakes that people make with columns, each as the correction that would mend it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, permutations, product
from typing import Literal

import numpy as np

from ffgym.logs.quality.wiring.sample import WiringSamples
from ffgym.logs.quality.wiring.score import TORQUE, Channel, Lefts
from ffgym.recordings.rewiring import Rewiring
from ffgym.robot import RobotDescription

Kind = Literal["sign", "unit", "side", "swap", "axes", "zero", "delay", "clock", "current"]

MOTIONS = ("motor.position", "motor.velocity", "reference.position", "reference.velocity", "reference.acceleration")
"""Families of the motors' motion, which one reading of the axes makes."""

EFFORTS = (
    *("motor.effort", "command.effort", "feedforward.effort"),
    *("feedback.effort", "feedback.integral", "compensation.effort"),
)
"""Families of torque."""

_ANGLE_UNITS = {
    "deg": np.pi / 180,
    "mrad": 1e-3,
    "turn": 2 * np.pi,
    "rad, converted from deg": 180 / np.pi,
    "rad, converted from mrad": 1e3,
}
_SPEED_UNITS = {"rpm": np.pi / 30, "rad/s, converted from rpm": 30 / np.pi}
_TORQUE_UNITS = {"mN m": 1e-3, "kN m": 1e3}
_LENGTH_UNITS = {"mm": 1e-3, "m, converted from mm": 1e3, "cm": 1e-2}
_TIME_UNITS = {"ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "s, converted from ms": 1e3}
_RATES = (2.0, 0.5, 10.0, 0.1, 4.0, 0.25, 5.0, 0.2)
"""Factors of a clock that counts in other steps than it says."""

_ZEROS = (10.0, 20.0, 30.0, 45.0, 60.0, 90.0, 120.0, 180.0)
"""Offsets [deg] that are tried; what lies between is found from the nearest."""

_STEPS = 14
"""Delays that are tried in each direction."""

_COSTS: Mapping[Kind, float] = {"zero": 0.05, "axes": 0.05, "clock": 0.1}
"""Gain that mistakes with numbers of their own need beyond those without."""

LONGEST_DELAY = 0.3
"""[s]; periodic motions fit themselves again beyond."""


@dataclass(frozen=True, kw_only=True)
class WiringHypothesis:
    """One mistake, made with some families and joints."""

    kind: Kind
    families: tuple[str, ...]
    """All that the mistake was made with; empty for the clock."""
    parts: tuple[int, ...]
    """Numbers of the joints, or of the axes of the tracker; empty for the clock."""
    factors: tuple[float, ...] = ()
    """Factors by which the given numbers must be multiplied for mistakes of sign, unit, side, clock and current, one
    per part."""
    order: tuple[int, ...] = ()
    """Column that holds each part, for swaps."""
    amount: float = 0.0
    """Size of a zero [rad or m, as kept], and of a delay [s of the clock as given]."""
    unit: str = ""
    """Unit of the numbers, for units."""

    @property
    def cost(self) -> float:
        """Gain that a simpler mistake may lack, so that of two that explain the same the simpler one is named."""
        return 0.02 * len(self.families) + _COSTS.get(self.kind, 0.0)

    def correct(self, wiring: Rewiring, n_joints: int) -> Rewiring:
        """The reading without this mistake."""
        if self.kind == "clock":
            return Rewiring(families=wiring.families, clock=wiring.clock * self.factors[0])
        for family in self.families:
            rewire = wiring.of(family, 3 if family.startswith("tcp") else n_joints)
            if self.order:
                rewire = rewire.permute(self.order)
            if self.factors:
                rewire = rewire.scale_parts(self.parts, self.factors)
            if self.kind == "zero":
                rewire = rewire.shift_parts(self.parts, self.amount)
            if self.kind == "delay":
                rewire = rewire.delay_parts(self.parts, self.amount)
            wiring = wiring.with_family(family, rewire)
        return wiring


def motion_groups(samples: WiringSamples) -> list[tuple[str, ...]]:
    """Families of motion that are mistaken together."""
    there = tuple(family for family in MOTIONS if family in samples.present)
    motors = tuple(family for family in there if family.startswith("motor."))
    references = tuple(family for family in there if family.startswith("reference."))
    links = tuple(family for family in ("link.position", "link.velocity") if family in samples.present)
    return _distinct([there, motors, references, links, *((family,) for family in (*there, *links))])


def effort_groups(samples: WiringSamples) -> list[tuple[str, ...]]:
    """Families of torque that are mistaken together."""
    there = tuple(family for family in EFFORTS if family in samples.present)
    return _distinct([there, *((family,) for family in there if family != "feedback.integral")])


def hypotheses(samples: WiringSamples, n: int) -> Iterator[WiringHypothesis]:
    """All mistakes that need no search for a number, of a robot with `n` joints."""
    motions, efforts = motion_groups(samples), effort_groups(samples)
    sets = [(j,) for j in range(n)] + ([tuple(range(n))] if n > 1 else [])
    everything = tuple(family for family in (*MOTIONS, *EFFORTS) if family in samples.present)
    for group in _distinct([*motions, *efforts, everything]):
        yield from (WiringHypothesis(kind="sign", families=group, parts=s, factors=(-1.0,) * len(s)) for s in sets)
        for pair in combinations(range(n), 2):
            order = [*range(n)]
            order[pair[0]], order[pair[1]] = pair[1], pair[0]
            yield WiringHypothesis(kind="swap", families=group, parts=pair, order=tuple(order))
    for group in (*motions, *efforts):
        units = _TORQUE_UNITS if group in efforts else _ANGLE_UNITS
        if all(family.endswith("velocity") for family in group):
            units = _ANGLE_UNITS | _SPEED_UNITS
        for parts, (unit, factor) in product(sets, units.items()):
            yield WiringHypothesis(kind="unit", families=group, parts=parts, factors=(factor,) * len(parts), unit=unit)
    ratio = np.abs(samples.header.gear_ratio)
    for group in [*(g for g in motions if not g[0].startswith("link.")), *efforts]:
        for parts, power in product(sets, (1.0, -1.0)):
            if not np.allclose(ratio[list(parts)], 1.0):
                factors = tuple(float(ratio[j] ** power) for j in parts)
                yield WiringHypothesis(kind="side", families=group, parts=parts, factors=factors)
    for unit, factor in (*_TIME_UNITS.items(), *(("", rate) for rate in _RATES)):
        yield WiringHypothesis(kind="clock", families=(), parts=(), factors=(factor,), unit=unit)
    # unit and axes of the tracker
    there = tuple(family for family in ("tcp.position", "tcp_reference.position") if samples.has(family))
    for group in _distinct([there, *((family,) for family in there)]):
        for unit, factor in _LENGTH_UNITS.items():
            yield WiringHypothesis(kind="unit", families=group, parts=(0, 1, 2), factors=(factor,) * 3, unit=unit)
        for axes, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3)):
            if (axes, signs) != ((0, 1, 2), (1.0, 1.0, 1.0)):
                yield WiringHypothesis(kind="axes", families=group, parts=(0, 1, 2), order=axes, factors=signs)


def zeros(samples: WiringSamples, robot: RobotDescription) -> Iterator[WiringHypothesis]:
    """Zeros of one joint that are off."""
    there = tuple(f for f in ("motor.position", "reference.position") if f in samples.present)
    ratio = (
        np.asarray(samples.header.gear_ratio) if samples.header.position_side == "motor" else np.ones(robot.n_joints)
    )
    for group in _distinct([there, *((family,) for family in there)]):
        for j, degrees, way in product(range(robot.n_joints), _ZEROS, (1.0, -1.0)):
            if not robot.kinematics.is_sliding[j]:
                amount = float(way * np.radians(degrees) * ratio[j])
                yield WiringHypothesis(kind="zero", families=group, parts=(j,), amount=amount)


def delays(samples: WiringSamples, n_joints: int, least: float) -> Iterator[WiringHypothesis]:
    """Torques that come late or early, by more than `least` [s]."""
    sets = [(j,) for j in range(n_joints)] + ([tuple(range(n_joints))] if n_joints > 1 else [])
    amounts = np.geomspace(least, max(LONGEST_DELAY, 2 * least), _STEPS)
    for group in [g for g in effort_groups(samples) if TORQUE in g]:
        for parts, amount in product(sets, [*amounts.tolist(), *(-amounts).tolist()]):
            yield WiringHypothesis(kind="delay", families=group, parts=parts, amount=amount)


def _distinct(groups: Sequence[tuple[str, ...]]) -> list[tuple[str, ...]]:
    return [group for group in dict.fromkeys(groups) if group]


@dataclass(frozen=True, kw_only=True)
class Found:
    """A mistake with what speaks for it."""

    hypothesis: WiringHypothesis
    before: Lefts
    after: Lefts
    gain: float = 0.0
    """Sum of the logarithms of what is left less; of a current it is not asked."""

    @property
    def worth(self) -> float:
        """Gain less what a simpler mistake may lack."""
        return self.gain - self.hypothesis.cost

    @property
    def telling(self) -> Channel:
        """The signal that it explains most."""
        return max(self.before, key=lambda key: np.log(self.before[key] / self.after.get(key, self.before[key])))


@dataclass(frozen=True, kw_only=True)
class Mistake:
    """A mistake that was made with columns of all logs."""

    kind: Kind
    families: tuple[str, ...]
    """Families of columns; empty for the clock."""
    joints: tuple[str, ...]
    """Joints, or axes of the tracker; empty for the clock."""
    factors: tuple[float, ...]
    """Factors by which the numbers must be multiplied, one per joint; empty if they must not."""
    amount: float
    """Size of a zero, which must be added [rad or m, as kept]; of a delay [s of the clock as given]."""
    before: float
    """Share of the energy of the signal that tells it, left unexplained by the logs as given."""
    after: float
    """The same without the mistake."""
    message: str
    """One sentence: what is wrong, what shows it, the way out."""


def mistake_of(found: Found, samples: WiringSamples, ratio: tuple[float, ...]) -> Mistake:
    """Describe a mistake for people and programs."""
    one = found.hypothesis
    of_tool = bool(one.families) and one.families[0].startswith("tcp")
    joints = tuple("xyz"[part] if of_tool else samples.joints[part] for part in one.parts)
    family, part = found.telling
    before, after = found.before[found.telling], found.after[found.telling]
    signal = f"{family} of {samples.joints[part]}" if part or not family.startswith("tcp") else family
    way_out = "Correct the columns, or read the files with the corrected column map"
    if one.kind == "current":
        way_out = "Give the torque per ampere of each motor as scale; the corrected map holds what the logs say"
    fault = _fault(one, joints, samples, ratio)
    fault = fault[0].upper() + fault[1:] if fault.startswith(("all ", "timestamp")) else fault
    message = (
        f"{fault}. As given, {_share(before)} of the energy of {signal} is left unexplained, read otherwise "
        f"{_share(after)}. {way_out}."
    )
    return Mistake(
        kind=one.kind,
        families=one.families,
        joints=joints,
        factors=one.factors,
        amount=one.amount,
        before=before,
        after=after,
        message=message,
    )


def _fault(one: WiringHypothesis, joints: tuple[str, ...], samples: WiringSamples, ratio: tuple[float, ...]) -> str:
    """Say what is wrong: families and joints in a word, where there is one, and what was done to them."""
    groups = {"all channels": (*MOTIONS, *EFFORTS), "all positions and speeds": MOTIONS, "all torques": EFFORTS}
    there = {name: tuple(f for f in families if f in samples.present) for name, families in groups.items()}
    named = (name for name, families in there.items() if one.families == families and len(families) > 1)
    what = next(named, ", ".join(one.families))
    who = "all joints" if len(joints) == len(samples.joints) > 1 else ", ".join(joints)
    match one.kind:
        case "sign":
            return f"{what} of {who}: wrong sign"
        case "swap":
            return f"{what} of {joints[0]} and {joints[1]}: swapped"
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


def _share(left: float) -> str:
    """Share in percent."""
    if left > 1.0:
        return "more than all"
    return f"{left:.0%}" if left >= 0.1 else f"{left:.1%}"
