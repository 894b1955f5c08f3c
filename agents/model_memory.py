"""Memory of model feed-forward from sample to sample: torques that are carried, the lead, friction, and effects."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import TypeVar

import numpy as np

from ffgym.agents.elastic_memory import ARM_ROWS, ArmPast
from ffgym.agents.flexible_joints import Lead
from ffgym.core.types import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Carried:
    """Torque that gearbox and spring carry at a sample, (..., N) each, link side but for the reaction."""

    load: Array
    """Torque that the gearbox passes on to the link [N m]."""
    bend: Array
    """Torque of a linear spring that bends as far [N m], less friction behind the elasticity in a law that knows it."""
    reaction: Array
    """Torque on the motor [N m], motor side."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Start:
    """The rest before the motion, from which everything counts, (..., N) each."""

    load: Array
    """Torque that gearboxes pass on [N m], link side."""
    bend: Array
    """Torque of linear springs that bend as far [N m], link side."""
    added: Array
    """Torque of effects on the motors [N m], motor side."""
    error: Array
    """Error of the resolvers, reading less true angle [rad], motor side."""


Parts = TypeVar("Parts", Carried, Start, Lead)


@dataclass(frozen=True, kw_only=True, eq=False)
class Past:
    """Memory of the law at a sample whose torque is computed, (..., N) each."""

    start: Start
    carried: tuple[Carried, ...]
    """Torques carried at the 2 w known samples around this one."""
    time: Array
    """Time of this sample since the motion began [s]; all that follow are at this sample."""
    lead: Lead
    integral: Array
    """Integral of the lead as the servo sees it [rad s], link side."""
    bristle: Array
    """Deflection of the bristles [rad]."""
    lost: Array
    """Part of friction, less torque of effects, of the step before [N m]."""
    springs: list[Array]
    """Memories of effects on springs and links at the newest sample, (..., N, M) each."""
    motors: list[Array]
    """Memories of effects on motors, (..., N, M) each."""
    arm: ArmPast | None = None
    """Friction behind the elasticity; None where the machine has none, as of the next."""
    arm_ahead: Array | None = None
    """Deflection of its bristles at the newest sample [rad], motor units."""

    def pack(self) -> Array:
        """Pack the memory into one array (..., K)."""
        rows = [*_columns(self.start), *(row for each in self.carried for row in _columns(each))]
        rows += [self.time, *_columns(self.lead), self.integral, self.bristle, self.lost]
        if self.arm is not None and self.arm_ahead is not None:
            rows += [*self.arm.rows, self.arm_ahead]
        flat = [memory.reshape(*memory.shape[:-2], -1) for memory in (*self.springs, *self.motors)]
        return np.concatenate([*rows, *flat], axis=-1)

    def first(self, count: int) -> "Past":
        """Return the memory of the first `count` of motions side by side, where nothing is behind the elasticity."""

        def cut(values: Array) -> Array:
            return values[:count]

        return replace(
            self,
            start=change_parts(cut, self.start),
            carried=tuple(change_parts(cut, each) for each in self.carried),
            time=cut(self.time),
            lead=change_parts(cut, self.lead),
            integral=cut(self.integral),
            bristle=cut(self.bristle),
            lost=cut(self.lost),
            springs=[cut(memory) for memory in self.springs],
            motors=[cut(memory) for memory in self.motors],
        )


def change_parts(change: Callable[..., Array], *each: Parts) -> Parts:
    """Return parts that `change` makes of the parts of the same name."""
    return type(each[0])(**{f.name: change(*(getattr(one, f.name) for one in each)) for f in fields(each[0])})


def unpack_past(
    memory: Array, n: int, samples: int, springs: Sequence[int], motors: Sequence[int], *, arm: bool
) -> Past:
    """Unpack memory of N joints, with the number of samples and the lengths of the memories of effects.

    `arm` says that friction behind the elasticity is part of it.
    """
    n_rows = len(fields(Start)) + samples * len(fields(Carried)) + 1 + len(fields(Lead)) + 3 + arm * (ARM_ROWS + 1)
    ends = np.cumsum([n * n_rows, *(n * length for length in (*springs, *motors))])
    first, *others = np.split(memory, ends[:-1], axis=-1)
    rows = iter([first[..., k * n : (k + 1) * n] for k in range(n_rows)])
    kept = [part.reshape(*part.shape[:-1], n, -1) for part in others]
    return Past(
        start=Start(**{f.name: next(rows) for f in fields(Start)}),
        carried=tuple(Carried(**{f.name: next(rows) for f in fields(Carried)}) for _ in range(samples)),
        time=next(rows),
        lead=Lead(**{f.name: next(rows) for f in fields(Lead)}),
        integral=next(rows),
        bristle=next(rows),
        lost=next(rows),
        springs=kept[: len(springs)],
        motors=kept[len(springs) :],
        arm=ArmPast.of(np.stack([next(rows) for _ in range(ARM_ROWS)], axis=-2)) if arm else None,
        arm_ahead=next(rows) if arm else None,
    )


def _columns(parts: Start | Carried | Lead) -> list[Array]:
    return [getattr(parts, f.name) for f in fields(parts)]
