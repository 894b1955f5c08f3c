"""Hypothesis: an effect on a joint with values for all its parameters, which is tried, fitted and named."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.diagnosis.result import make_label
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.variant import compute_step
from ffgym.effects import Effect
from ffgym.effects.parameters import Parameter
from ffgym.robot import RobotDescription
from ffgym.simulation.plant import Machine

_NUDGE, _CYCLES_NUDGE = 0.05, 1e-5
"""Change of a number by which slopes are found, as a share of its practical step: small against where effects bend,
large against rounding; and of a frequency, as a share of itself: after a hundred turns of a motor at sixty cycles per
turn, the phase is 0.4 rad further."""


@dataclass(frozen=True, kw_only=True)
class FreeParameter:
    """One number of a hypothesis that is fitted."""

    name: str
    part: int | None
    """Place of the number in a vector."""
    value: float
    step: float
    """A practical change, > 0."""
    low: float
    high: float
    nudge: float
    """A change by which slopes are found, > 0."""
    of_session: bool
    """True for the time in which a session changes something."""


def _find_span(p: Parameter, value: float) -> tuple[float, float, float]:
    """Find the practical step and the lowest and highest value of a number."""
    if p.role == "size":
        return abs(compute_step(p)), p.minimum, p.maximum
    if p.role == "phase":
        return 0.5, -np.inf, np.inf
    if p.is_looked_for:  # and found there
        step = settings().search.frequency_step * max(abs(value), 1.0)
        return step, max(p.minimum, value - step), value + step
    # beyond its plausible range a shape makes of an effect another one: a drift of a second is a level, and so is
    # friction that repeats after many turns
    low, high = min(p.low, value), max(p.high, value)
    if p.role == "cycles":  # somewhere between those that were tried
        step = 0.5 * float(np.min(np.diff(p.tries)))
        return step, max(low, value - step), min(high, value + step)
    return 0.1 * (p.high - p.low), low, high


HypothesisKey = tuple[str, str, int | None]
"""Effect, joint, and the joint that causes it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Hypothesis:
    """One effect on one joint, or on the machine."""

    kind: type[Effect]
    joint: str
    """Empty for the machine as a whole."""
    source: int | None
    """Joint that causes an effect of one joint on another."""
    values: Mapping[str, Array]
    """Value of every parameter, () or (3,) each."""
    null: frozenset[str] = frozenset()
    """Sizes that stay at their null values."""

    @property
    def label(self) -> str:
        """Such as 'backlash on j2'."""
        return make_label(self.kind.name, self.joint)

    @property
    def key(self) -> HypothesisKey:
        """Key that tells it from other hypotheses, whatever its values: effect, joint, and joint that causes it."""
        return self.kind.name, self.joint, self.source

    @property
    def values_key(self) -> tuple[Any, ...]:
        """Key that tells it from all others, those with other values included."""
        return *self.key, self.null, *((name, value.tobytes()) for name, value in self.values.items())

    def repeats(self, known: "Hypothesis") -> bool:
        """Tell whether it is the same as `known`; a wave of another frequency is not."""
        if self.key != known.key:
            return False
        cycles = [name for name, p in self.kind.parameters().items() if p.role == "cycles"]
        return not any(
            abs(self.values[name] / known.values[name] - 1) > settings().search.other_wave for name in cycles
        )

    def is_among(self, others: "Iterable[Hypothesis]") -> bool:
        """Tell whether it is the same as one of the others."""
        return any(self.repeats(other) for other in others)

    @property
    def implausible(self) -> str | None:
        """A size that lies far beyond what is plausible of it, in words; None if none does."""
        for name, value in self.values.items():
            p = self.kind.parameters()[name]
            if p.role == "size" and _widths_beyond(p, value) > settings().search.implausible:
                unit = "" if p.unit == "1" else f" {p.unit}"
                return f"{name} of {float(np.max(np.abs(value))):.3g}{unit}, where {p.low:g} to {p.high:g} is plausible"
        return None

    @property
    def is_unphysical(self) -> bool:
        """Tell whether a share is so far beyond what is plausible that no machine has it, as a stiffness times 15.

        Sizes with units are other for other machines; shares are not.
        """
        known = self.kind.parameters()
        shares = [(known[name], value) for name, value in self.values.items() if known[name].unit == "1"]
        return any(p.role == "size" and _widths_beyond(p, value) > settings().search.unphysical for p, value in shares)

    def effect(self, robot: RobotDescription) -> Effect:
        """Build the effect, on its joint alone."""
        known = self.kind.parameters()
        full: dict[str, Any] = {}
        for name, value in self.values.items():
            p, shape = known[name], known[name].shape(robot.n_joints)
            if p.per in ("machine", "vector"):
                full[name] = value
                continue
            # other joints get the neutral size, with which the effect does nothing there
            at = list(robot.joints).index(self.joint)
            spread = np.full(shape, p.neutral if p.role == "size" else float(value))
            if p.per == "pair":
                spread[at, self.source] = value
            else:
                spread[at] = value
            full[name] = spread
        return self.kind(**full)

    def on(self, machine: Machine) -> Machine:
        """Add the effect to a machine."""
        return replace(machine, effects=(*machine.effects, self.effect(machine.robot)))

    def list_free(self) -> list[FreeParameter]:
        """List all numbers that are fitted: sizes, and shapes that are neither a mere choice nor a scale."""
        found = []
        for name, values in self.values.items():
            p = self.kind.parameters()[name]
            if name in self.null or p.scale:
                continue
            of_session = "running" in self.kind.varies_with and p.unit == "s"
            for part in range(3) if p.per == "vector" else (None,):
                value = float(values if part is None else values[part])
                step, low, high = _find_span(p, value)
                nudge = _CYCLES_NUDGE * max(abs(value), 1.0) if p.role == "cycles" else _NUDGE * step
                ends = {"step": step, "low": low, "high": high, "nudge": nudge}
                found.append(FreeParameter(name=name, part=part, value=value, of_session=of_session, **ends))
        return found

    @property
    def is_null(self) -> bool:
        """Tell whether all sizes are at their null values, where the effect changes nothing."""
        known = self.kind.parameters()
        sizes = [name for name in self.values if known[name].role == "size"]
        return all(bool(np.all(self.values[name] == known[name].neutral)) for name in sizes)

    def fix_at_null(self, size: str) -> Self:
        """Fix one size at its null value for good."""
        neutral = np.full_like(self.values[size], self.kind.parameters()[size].neutral)
        return replace(self, values={**self.values, size: neutral}, null=self.null | {size})

    def scale(self, factor: float) -> Self:
        """Scale the distances of all sizes from their null values."""
        values = dict(self.values)
        for name, p in self.kind.parameters().items():
            if name in values and p.role == "size":
                values[name] = np.clip(p.neutral + factor * (values[name] - p.neutral), p.minimum, p.maximum)
        return replace(self, values=values)

    def move(self, changes: Sequence[float]) -> Self:
        """Change each free number, within its bounds."""
        values = {name: np.array(value, dtype=np.float64) for name, value in self.values.items()}
        for free, change in zip(self.list_free(), changes, strict=True):
            new = float(np.clip(free.value + change, free.low, free.high))
            if free.part is None:
                values[free.name] = np.array(new)
            else:
                values[free.name][free.part] = new
        return replace(self, values=values)


def _widths_beyond(p: Parameter, value: Array) -> float:
    """Count widths of its plausible range by which a number lies beyond it; negative inside."""
    beyond = max(float(np.max(value)) - p.high, p.low - float(np.min(value)))
    return beyond / (p.high - p.low)


def move_hypotheses(hypotheses: Sequence[Hypothesis], steps: Array) -> tuple[Hypothesis, ...]:
    """Move free numbers of all hypotheses by practical steps, within their bounds."""
    found, at = [], 0
    for hypothesis in hypotheses:
        free = hypothesis.list_free()
        found.append(hypothesis.move([float(x) * f.step for x, f in zip(steps[at:], free, strict=False)]))
        at += len(free)
    return tuple(found)


def build_machine(nominal: Machine, hypotheses: Sequence[Hypothesis]) -> Machine | None:
    """Build the machine with all hypotheses; None if it cannot exist, e.g. with less breakaway than Coulomb torque."""
    return exchange_effects(nominal, [*nominal.effects, *(h.effect(nominal.robot) for h in hypotheses)])


def exchange_effects(like: Machine, effects: Sequence[Effect]) -> Machine | None:
    """Exchange the effects of a machine; None if it cannot exist."""
    try:
        machine = replace(like, effects=tuple(effects))
        _ = machine.physical
    except FFGymError:
        return None
    return machine
