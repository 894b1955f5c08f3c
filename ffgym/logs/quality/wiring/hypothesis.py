"""Mistakes that people make with columns, each as the correction that would mend it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, permutations, product
from typing import Literal, final

import numpy as np

from ffgym.logs.quality.wiring.sample import Samples
from ffgym.logs.quality.wiring.score import POSITION, TORQUE
from ffgym.recordings.rewiring import Rewiring
from ffgym.robot import RobotDescription

Kind = Literal["sign", "unit", "side", "swap", "axes", "zero", "delay", "clock", "current"]

MOTIONS = (
    "motor.position",
    "motor.velocity",
    "reference.position",
    "reference.velocity",
    "reference.acceleration",
)
"""Families of the motors' motion, which one reading of the axes makes."""

EFFORTS = (
    "motor.effort",
    "command.effort",
    "feedforward.effort",
    "feedback.effort",
    "feedback.integral",
    "compensation.effort",
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


@final
@dataclass(frozen=True, kw_only=True)
class Hypothesis:
    """One mistake, made with some families and joints."""

    kind: Kind
    families: tuple[str, ...]
    """All that the mistake was made with; empty for the clock."""
    parts: tuple[int, ...]
    """Numbers of the joints, or of the axes of the tracker; empty for the clock."""
    factors: tuple[float, ...] = ()
    """Of sign, unit, side, clock and current: by which the given numbers must be multiplied, one per part."""
    order: tuple[int, ...] = ()
    """Of swaps: the column that holds each part."""
    amount: float = 0.0
    """Of a zero [rad or m, as kept], and of a delay [s of the clock as given]."""
    unit: str = ""
    """Of units: what the numbers are in."""

    @property
    def cost(self) -> float:
        """Gain that a simpler mistake may lack, so that of two that explain the same the simpler one is named."""
        return 0.02 * len(self.families) + _COSTS.get(self.kind, 0.0)

    def mended(self, wiring: Rewiring, n_joints: int) -> Rewiring:
        """The reading without this mistake."""
        if self.kind == "clock":
            return Rewiring(families=wiring.families, clock=wiring.clock * self.factors[0])
        for family in self.families:
            rewire = wiring.of(family, 3 if family.startswith("tcp") else n_joints)
            if self.order:
                rewire = rewire.permuted(self.order)
            if self.factors:
                rewire = rewire.scaled(self.parts, self.factors)
            if self.kind == "zero":
                rewire = rewire.moved(self.parts, self.amount)
            if self.kind == "delay":
                rewire = rewire.delayed(self.parts, self.amount)
            wiring = wiring.with_family(family, rewire)
        return wiring


def motion_groups(samples: Samples) -> list[tuple[str, ...]]:
    """Families of motion that are mistaken together."""
    there = tuple(family for family in MOTIONS if family in samples.present)
    motors = tuple(family for family in there if family.startswith("motor."))
    references = tuple(family for family in there if family.startswith("reference."))
    links = tuple(family for family in ("link.position", "link.velocity") if family in samples.present)
    return _distinct([there, motors, references, links, *((family,) for family in (*there, *links))])


def effort_groups(samples: Samples) -> list[tuple[str, ...]]:
    """Families of torque that are mistaken together."""
    there = tuple(family for family in EFFORTS if family in samples.present)
    return _distinct([there, *((family,) for family in there if family != "feedback.integral")])


def everything(samples: Samples) -> list[tuple[str, ...]]:
    """All families of the motors."""
    return _distinct([tuple(f for f in (*MOTIONS, *EFFORTS) if f in samples.present)])


def hypotheses(samples: Samples, robot: RobotDescription) -> Iterator[Hypothesis]:
    """All mistakes that need no search for a number."""
    n = robot.n_joints
    motions, efforts = motion_groups(samples), effort_groups(samples)
    sets = [(j,) for j in range(n)] + ([tuple(range(n))] if n > 1 else [])
    for group in [*motions, *efforts, *everything(samples)]:
        yield from (Hypothesis(kind="sign", families=group, parts=s, factors=(-1.0,) * len(s)) for s in sets)
        for pair in combinations(range(n), 2):
            order = [*range(n)]
            order[pair[0]], order[pair[1]] = pair[1], pair[0]
            yield Hypothesis(kind="swap", families=group, parts=pair, order=tuple(order))
    for group, units in _unit_groups(motions, efforts):
        for parts, (unit, factor) in product(sets, units.items()):
            yield Hypothesis(kind="unit", families=group, parts=parts, factors=(factor,) * len(parts), unit=unit)
    ratio = np.abs(samples.header.gear_ratio)
    for group in [*(g for g in motions if not g[0].startswith("link.")), *efforts]:
        for parts, power in product(sets, (1.0, -1.0)):
            if not np.allclose(ratio[list(parts)], 1.0):
                factors = tuple(float(ratio[j] ** power) for j in parts)
                yield Hypothesis(kind="side", families=group, parts=parts, factors=factors)
    for unit, factor in _TIME_UNITS.items():
        yield Hypothesis(kind="clock", families=(), parts=(), factors=(factor,), unit=unit)
    yield from (Hypothesis(kind="clock", families=(), parts=(), factors=(rate,)) for rate in _RATES)
    yield from _tool(samples)


def zeros(samples: Samples, robot: RobotDescription) -> Iterator[Hypothesis]:
    """Zeros of one joint that are off."""
    there = tuple(f for f in ("motor.position", "reference.position") if f in samples.present)
    ratio = (
        np.asarray(samples.header.gear_ratio) if samples.header.position_side == "motor" else np.ones(robot.n_joints)
    )
    for group in _distinct([there, *((family,) for family in there)]):
        for j, degrees, way in product(range(robot.n_joints), _ZEROS, (1.0, -1.0)):
            if not robot.kinematics.is_sliding[j]:
                amount = float(way * np.radians(degrees) * ratio[j])
                yield Hypothesis(kind="zero", families=group, parts=(j,), amount=amount)


def delays(samples: Samples, n_joints: int, least: float) -> Iterator[Hypothesis]:
    """Torques that come late or early, by more than `least` [s]."""
    sets = [(j,) for j in range(n_joints)] + ([tuple(range(n_joints))] if n_joints > 1 else [])
    amounts = np.geomspace(least, max(LONGEST_DELAY, 2 * least), _STEPS)
    for group in [g for g in effort_groups(samples) if TORQUE in g]:
        for parts, amount in product(sets, [*amounts.tolist(), *(-amounts).tolist()]):
            yield Hypothesis(kind="delay", families=group, parts=parts, amount=amount)


def _unit_groups(
    motions: Sequence[tuple[str, ...]], efforts: Sequence[tuple[str, ...]]
) -> Iterator[tuple[tuple[str, ...], dict[str, float]]]:
    """Families with the units that they may be in."""
    for group in motions:
        if all(family.endswith("velocity") for family in group):
            yield group, _ANGLE_UNITS | _SPEED_UNITS
        else:
            yield group, _ANGLE_UNITS
    yield from ((group, _TORQUE_UNITS) for group in efforts)


def _tool(samples: Samples) -> Iterator[Hypothesis]:
    """Unit and axes of the tracker."""
    there = tuple(family for family in ("tcp.position", "tcp_reference.position") if samples.has(family))
    for group in _distinct([there, *((family,) for family in there)]):
        for unit, factor in _LENGTH_UNITS.items():
            yield Hypothesis(kind="unit", families=group, parts=(0, 1, 2), factors=(factor,) * 3, unit=unit)
        for order in permutations(range(3)):
            for signs in product((1.0, -1.0), repeat=3):
                if (order, signs) != ((0, 1, 2), (1.0, 1.0, 1.0)):
                    yield Hypothesis(kind="axes", families=group, parts=(0, 1, 2), order=order, factors=signs)


def _distinct(groups: Sequence[tuple[str, ...]]) -> list[tuple[str, ...]]:
    return [group for group in dict.fromkeys(groups) if group]


def touches_motion(hypothesis: Hypothesis) -> bool:
    """Whether the positions that the arm is computed for change."""
    return hypothesis.kind == "clock" or POSITION in hypothesis.families
