r"""Deflections of elastic joints whose motors move as measured: the arm as a system of springs that is driven.

.. math:: M(q) \ddot\delta + (d + H) \dot\delta + (K + G) \delta = p

with the mass matrix along the measured motion, and with what links ask for beside it where joints bend (`Bending`).
Newmark's method of constant average acceleration, stable at any step: a resonance above the sample rate follows its
load, as it should. It swings too slowly, by a twenty-fourth of the square of the phase of a step: ten swings at 13 Hz
are off by 0.07 rad in steps of 2 ms. A mass that is less by x^2 / 6 / (1 + x^2 / 40 + x^4 / 144) keeps time, where x is
that phase of a mode: two terms of the method's own series, and one that keeps all masses positive.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, IntArray
from ffgym.diagnosis.replay.recursions import cubics, places_of, swing
from ffgym.diagnosis.settings import settings

_STEPS = 512
"""Steps that are prepared at once; chosen: more of them take memory and no less time."""

_FEW = 3
"""Loads up to which motions are solved one by one; chosen: of more of them, steps of all motions at once take less."""

_KEPT = 2**27
"""Most memory that is taken for steps which other loads take, too [bytes]."""


_ITERATIONS = 20
"""Newton steps of a brake at most; chosen: hardly any sample takes a second one."""


class FlownAwayError(FFGymError):
    """An arm whose springs do not hold it: something pushes it away from where its motors are."""


Push = Callable[[int, Array, Array], Array]
"""Torque that acts on the springs at sample k, at deflection and rate (M, N), link side [N m], (M, N)."""


class Brake(ABC):
    """Friction on links, whose torque changes too fast with the rate for steps that are explicit in it."""

    joints: IntArray
    """Joints that have it."""

    @abstractmethod
    def expect(self, k: int, angle: Array, rate: Array) -> tuple[Array, Array]:
        """Return the torque at sample k at deflection and rate (M, N), and by how much it falls with the rate, >= 0."""

    @abstractmethod
    def is_near(self, faster: Array) -> bool:
        """Tell whether slopes hold for rates that are higher than expected by `faster` (M, N) [rad/s]."""

    @abstractmethod
    def conclude(self, k: int, faster: Array) -> None:
        """Remember the step to sample k, at which the rate was higher than expected (M, N) [rad/s]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Deflection:
    """Motion of links behind their gearboxes, link side, (T, M, N) or (T, M, N, V) each; 0 for rigid joints."""

    angle: Array
    """[rad]."""
    rate: Array
    """[rad/s]."""
    acceleration: Array
    """[rad/s^2]."""
    braking: Array | None = None
    """Torque of friction on the links that was part of it, link side [N m], (T, M, N); None without any."""

    def at_every(self, n: int) -> "Deflection":
        """At every n-th sample."""
        return Deflection(angle=self.angle[::n], rate=self.rate[::n], acceleration=self.acceleration[::n])


@dataclass(frozen=True, kw_only=True, eq=False)
class Bending:
    """Torque of links beside inertia where joints bend, per bending of the last axis; (T, M, N, N)."""

    rate: Array
    """Per rate of the deflection [N m s/rad]."""
    place: Array
    """Per deflection [N m/rad]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Springs:
    """Elastic joints along M motions of T samples."""

    mass: Array
    """Shape (T, M, N, N), link side [kg m^2]."""
    stiffness: Array
    """K [N m/rad], shape (N,); inf is rigid."""
    damping: Array
    """d [N m s/rad], shape (N,)."""
    dt: float
    bending: Bending | None = None
    """Torque that bending links take beside their inertia; None is nothing."""

    @cached_property
    def elastic(self) -> IntArray:
        """Joints that bend."""
        return np.flatnonzero(np.isfinite(self.stiffness))

    def _terms(self, rows: slice | IntArray) -> tuple[Array, Array, Array]:
        """M, D and K of the joints that bend, with what bending adds to the last two; (R, M, E, E) each."""
        e = self.elastic
        here = slice(None), slice(None), e[:, None], e
        mass = self.mass[rows][here]
        rate, place = np.zeros((2, *mass.shape))
        if self.bending is not None:
            rate, place = self.bending.rate[rows][here], self.bending.place[rows][here]
        return mass, rate + np.diag(self.damping[e]), place + np.diag(self.stiffness[e])

    def _late(self, at: IntArray) -> Array:
        """Mass by which a mass is less that keeps time, at samples, (R, M, E, E); on straight lines between some."""
        rows = np.unique(
            np.append(
                np.arange(0, len(self.mass), max(1, round(settings().replay.delay_period / self.dt))),
                len(self.mass) - 1,
            )
        )
        mass, _, place = self._terms(rows)
        # phase error of Newmark's method to the sixth order, and the mass that undoes it
        phase = np.linalg.solve(mass, self.dt**2 * place)  # its square, of a step
        full = np.eye(mass.shape[-1]) + phase / 40 + phase @ phase / 144
        late = mass @ np.linalg.solve(full, phase) / 6
        # straight lines between samples of the slowly changing mass
        left = np.clip(np.searchsorted(rows, at, side="right") - 1, 0, max(len(rows) - 2, 0))
        right = np.minimum(left + 1, len(rows) - 1)
        x = (at - rows[left]) / np.maximum(rows[right] - rows[left], 1)
        found: Array = late[left] + x[:, None, None, None] * (late[right] - late[left])
        return found

    def _at(self, samples: Callable[[Array], Array], dt: float) -> "Springs":
        """The same springs at other samples of the same motions."""
        bending = self.bending
        if bending is not None:
            bending = Bending(rate=samples(bending.rate), place=samples(bending.place))
        return replace(self, mass=samples(self.mass), bending=bending, dt=dt)

    def coarser(self, every: int) -> "Springs":
        """The same springs at every n-th sample."""
        return self._at(lambda values: values[::every], every * self.dt)

    @property
    def substeps(self) -> int:
        """Steps in a sample that are short enough to swing as springs do; 1 where samples are too rare to show it."""
        limits = settings().replay
        return int(np.ceil(self.dt / limits.spring_step - 1e-9)) if self.dt <= limits.rarest_rows else 1

    @cached_property
    def finer(self) -> "Springs":
        """The same springs with steps that are short enough."""
        return self._at(lambda values: straight(values, self.substeps), self.dt / self.substeps)

    def bending_torque(self, bent: Deflection) -> Array:
        """Torque that links ask for where joints bend, beside their motion without springs, link side [N m]."""
        parts = [(self.mass, bent.acceleration)]
        if self.bending is not None:
            parts += [(self.bending.rate, bent.rate), (self.bending.place, bent.angle)]
        found: Array = sum(np.einsum("tmij,tmj...->tmi...", per, of) for per, of in parts)
        return found

    def restoring(self, angle: Array) -> Array:
        """Torque that deflections (M, N) [rad] take at rest at the first sample, link side [N m].

        Rigid joints do not bend, whatever their stiffness is said to be.
        """
        stiff: Array = np.where(np.isfinite(self.stiffness), self.stiffness, 1.0) * angle
        return stiff if self.bending is None else stiff + np.matmul(self.bending.place[0], angle[..., None])[..., 0]

    def bent_by(self, torque: Array) -> Deflection:
        """Deflections under `torque` [N m], shape (T, M, N, V), for V loads at once, settled at the first sample."""
        e, dt, shape = self.elastic, self.dt, torque.shape
        if len(e) and self.substeps > 1:
            return self.finer.bent_by(between(torque, self.substeps)).at_every(self.substeps)
        angle, rate, acceleration = np.zeros(shape), np.zeros(shape), np.zeros(shape)
        found = Deflection(angle=angle, rate=rate, acceleration=acceleration)
        if not len(e):
            return found
        # springs in equilibrium at the first sample
        rest = np.linalg.solve(self._terms(slice(0, 1))[2][0], torque[0][:, e])
        # few loads: one banded system per motion
        if shape[3] <= _FEW:
            for m in range(shape[1]):
                swung = swing(*self._step(motion=m), torque[:, m, e], rest[m], dt)
                angle[:, m, e], rate[:, m, e], acceleration[:, m, e] = swung
            return found
        self._swing_together(torque, rest, angle, rate, acceleration)
        return found

    def bend_in_place(self, torque: Array) -> tuple[Array, Array]:
        """Deflections and rates, (T, M, N, V), as those of `bent_by` where all joints bend.

        Deflections may take the place of the loads: two arrays instead of four, as new memory takes time.
        """
        if self.substeps > 1 or torque.shape[3] <= _FEW:
            found = self.bent_by(torque)
            return found.angle, found.rate
        rest = np.linalg.solve(self._terms(slice(0, 1))[2][0], torque[0])
        rate = np.zeros(torque.shape)
        self._swing_together(torque, rest, torque, rate)
        return torque, rate

    def _swing_together(
        self, torque: Array, rest: Array, angle: Array, rate: Array, acceleration: Array | None = None
    ) -> None:
        """Swing under loads (T, M, N, V) from a `rest` (M, E, V) on, all motions at once, and write what is found.

        It is written into arrays of the same shape that are 0 at rigid joints and at the first sample. That of the
        angle may be that of the loads.
        """
        dt, shape, n = self.dt, torque.shape, len(self.elastic)
        every = slice(None) if n == shape[2] else self.elastic
        # load, deflection, rate and its change, all that a step is made of
        moved = np.zeros((shape[1], 4 * n, shape[3]))
        parts = [moved[:, k * n : (k + 1) * n] for k in range(4)]
        x, speed, after, both, more, other = np.zeros((6, shape[1], n, shape[3]))
        x[:] = rest
        angle[0][:, every] = x
        half, quarter = dt / 2, dt**2 / 4
        for first in range(1, shape[0], _STEPS):
            for k, step in enumerate(self._steps(first), start=first):
                # whole arrays and results in place, which is faster than parts of arrays and new ones
                for part, values in zip(parts, (torque[k][:, every], x, speed, after), strict=True):
                    part[:] = values
                np.matmul(step, moved, out=after)
                np.add(parts[3], after, out=both)
                np.add(np.multiply(dt, speed, out=more), np.multiply(quarter, both, out=other), out=more)
                np.add(x, more, out=x)
                np.add(speed, np.multiply(half, both, out=more), out=speed)
                angle[k][:, every], rate[k][:, every] = x, speed
                if acceleration is not None:
                    acceleration[k][:, every] = after

    def _steps(self, first: int) -> Array:
        """Accelerations after steps from a sample on, per load after it, and deflection, rate and acceleration before.

        Shape (R, M, E, 4E); they are kept for other loads if all of them are few.
        """
        if first in self._known_steps:
            return self._known_steps[first]
        dt, (by_load, by_place, by_rate) = self.dt, self._step(slice(first, first + _STEPS))
        parts = by_load, -by_place, -(by_rate + dt * by_place), -(dt / 2 * by_rate + dt**2 / 4 * by_place)
        made: Array = np.concatenate(parts, axis=-1)
        if 32 * self.mass[..., 0].size * len(self.elastic) <= _KEPT:
            self._known_steps[first] = made
        return made

    def _all_steps(self) -> Array:
        """Accelerations after all steps, per load, and less per place and rate that are expected, (T, M, E, 3E).

        They are kept from the second time on: with most springs an arm flies once.
        """
        if 0 in self._known_steps:
            return self._known_steps[0]
        made = self._steps_of_three()
        made = made.reshape(*made.shape[:-2], 3 * made.shape[-1])
        if self._have_flown:
            self._known_steps[0] = made
        self._have_flown.append(True)
        return made

    @cached_property
    def _have_flown(self) -> list[bool]:
        return []

    @cached_property
    def _known_steps(self) -> dict[int, Array]:
        return {}

    def _step(self, rows: slice = slice(None), motion: int | slice = slice(None)) -> tuple[Array, Array, Array]:
        """Accelerations per load, and less per deflection and rate that are expected, (R, M, E, E) each."""
        here = self._steps_of_three(rows, motion)
        return here[..., 0, :], here[..., 1, :], here[..., 2, :]

    def _steps_of_three(self, rows: slice = slice(None), motion: int | slice = slice(None)) -> Array:
        """The same side by side, (R, M, E, 3, E)."""
        weights, poses = self._known_poses
        weights, poses = weights[rows], poses[:, motion]
        here: Array = weights @ poses.reshape(len(poses), -1)
        return here.reshape(weights.shape[0], *poses.shape[1:])

    @cached_property
    def _known_poses(self) -> "tuple[scipy.sparse.csr_array, Array]":
        """Weights (T, P) of some samples in all of them, and the same there, (P, M, E, 3, E)."""
        dt, places = self.dt, places_of(len(self.mass), max(1, round(settings().replay.pose_period / self.dt)))
        mass, rate, place = self._terms(places)
        inverse = np.linalg.inv(mass - self._late(places) + dt / 2 * rate + dt**2 / 4 * place)
        return cubics(places), np.stack([inverse, np.matmul(inverse, place), np.matmul(inverse, rate)], axis=3)

    def integrate(self, torque: Array, push: Push | None, start: Array, brake: Brake | None = None) -> Deflection:
        """Deflections under `torque` (T, M, N) and a `push` that depends on them, from rest at `start` (..., M, N).

        Brakes of several machines may hold the same springs, side by side on axes before those of the motions.

        The push is evaluated where the arm is expected after the step, so that it does not lag behind. A `brake` is
        linear about that in the rate (Rosenbrock 1963), so that bristles of light links may be stiff.
        """
        e, shape, n = self.elastic, (len(torque), *start.shape), len(self.elastic)
        angles, rates, accelerations = np.zeros(shape), np.zeros(shape), np.zeros(shape)
        if push is not None:
            push(0, start, np.zeros_like(start))
        # matrices of all steps, and what they act on: load, place and rate that the step before leads to
        steps, every = self._all_steps(), _slice_of(e)
        moved, free = np.zeros((*start.shape[:-1], 3 * n, 1)), np.zeros((*start.shape[:-1], n, 1))
        of_load, of_place, of_rate = (moved[..., k * n : (k + 1) * n, 0] for k in range(3))
        x, (rate, change, more) = np.ascontiguousarray(start[..., e]), np.zeros((3, *start.shape[:-1], n))
        angles[0][..., every] = x
        expected, expected_rate = start.copy(), np.zeros_like(start)
        held = None if brake is None else _Held.of(brake, e, steps, start.shape, self.dt)
        # predict place and rate, evaluate the push there, solve for the acceleration; numbers are arrays, and results
        # in place, as steps of so few joints take most of their time beside the arithmetic
        most, dt, half, quarter = settings().replay.largest_deflection, *_as_arrays(self.dt)
        for k in range(1, shape[0]):
            np.add(rate, np.multiply(dt, change, out=more), out=rate)
            np.add(x, np.multiply(dt, rate, out=more), out=x)
            if k % _CHECKED == 0:
                _check_bent(x, most)
            expected[..., every] = np.add(x, np.multiply(quarter, change, out=more), out=more)
            expected_rate[..., every] = np.add(rate, np.multiply(half, change, out=more), out=more)
            of_load[:] = (torque[k] if push is None else torque[k] + push(k, expected, expected_rate))[..., every]
            of_place[:], of_rate[:] = np.negative(x, out=more), -rate  # they pull back
            np.matmul(steps[k], moved, out=free)
            change = (
                free[..., 0].copy() if held is None else held.hold(k, free[..., 0], change, expected, expected_rate)
            )
            angles[k][..., every], rates[k][..., every], accelerations[k][..., every] = x, rate, change
        _check_bent(x, most)
        # correct place and rate by the acceleration at the sample
        angles += quarter * accelerations
        rates += half * accelerations
        return Deflection(angle=angles, rate=rates, acceleration=accelerations)


_CHECKED = 16
"""Steps between two looks at where an arm is; chosen: one that flies away is not far by then."""


def _check_bent(x: Array, most: float) -> None:
    """Raise an error where deflections are beyond the largest that springs have, or no numbers."""
    if not (bent := float(np.abs(x).max(initial=0.0))) < most:
        raise FlownAwayError(f"An arm does not stay where its motors are: it bends by {bent:g} rad.")


def _slice_of(places: IntArray) -> slice | IntArray:
    """Places as a slice if they are consecutive, which indexing is faster with."""
    if len(places) and places[-1] - places[0] + 1 == len(places):
        return slice(int(places[0]), int(places[-1]) + 1)
    return places


def _as_arrays(dt: float) -> tuple[Array, Array, Array]:
    """A step [s], half of it, and a quarter of its square [s^2], as arrays, which are faster to multiply by."""
    return np.array(dt), np.array(dt / 2), np.array(dt**2 / 4)


@dataclass(kw_only=True, eq=False)
class _Held:
    """Joints that a brake holds back in steps which are implicit in its torque."""

    brake: Brake
    joints: slice | IntArray
    """Those that it holds, of all joints."""
    among: slice | IntArray
    """The same, of those that bend."""
    bends: slice | IntArray
    """Joints that bend."""
    per_torque: Array
    """Acceleration of joints that bend per torque on those that are held, (T, M, E, H)."""
    own: Array
    """The same of those that are held, (T, M, H, H)."""
    one: Array
    """Matrices of one, (..., M, H, H)."""
    half: Array
    """Half a step [s], shape ()."""
    faster: Array
    """Rates that were higher than expected in the last step [rad/s], (..., M, N)."""

    @classmethod
    def of(cls, brake: Brake, elastic: IntArray, steps: Array, shape: tuple[int, ...], dt: float) -> "_Held":
        """Joints of a brake in the matrices (T, M, E, 3E) of all steps, for motions of a `shape` (..., M, N)."""
        among, n = np.searchsorted(elastic, brake.joints), len(brake.joints)
        per_torque = steps[..., among]
        return cls(
            brake=brake,
            joints=_slice_of(brake.joints),
            among=_slice_of(among),
            bends=_slice_of(elastic),
            per_torque=per_torque,
            own=np.ascontiguousarray(per_torque[..., among, :]),
            one=np.broadcast_to(np.eye(n), (*shape[:-1], n, n)).copy(),
            half=np.array(dt / 2),
            faster=np.zeros(shape),
        )

    def hold(self, k: int, free: Array, before: Array, angle: Array, expected: Array) -> Array:
        """Accelerations (..., M, E) that a step leads to where it would be `free`, and was `before`.

        Newton's method about the expected rate (..., M, N), which mostly is as good as the one after the step at once.
        """
        half, per_torque, own, joints = self.half, self.per_torque[k], self.own[k], self.joints
        was, about, faster = half * before[..., self.among].copy(), expected, self.faster
        scale: Array | float = 1.0
        last: Array | None = None
        for iteration in range(_ITERATIONS):
            braked, slope = self.brake.expect(k, angle, about)
            falls = slope[..., joints].copy()
            force = braked[..., joints].copy() + falls * was
            if iteration:
                force += falls * (about - expected)[..., joints]
            pushed = free + np.matmul(per_torque, force[..., None])[..., 0]
            change = self._hold_back(pushed, per_torque, own, half * falls)
            faster[..., self.bends] = half * (change - before)
            if iteration:
                faster -= about - expected
            if self.brake.is_near(faster):
                break
            # joints that turn back go half as far
            if last is not None:
                scale = scale * np.where(faster * last < 0, 0.5, 1.0)
            last, about = faster.copy(), about + scale * faster
        self.brake.conclude(k, faster)
        return change

    def _hold_back(self, free: Array, per_torque: Array, own: Array, falls: Array) -> Array:
        """Solve for accelerations (..., M, E) of joints of which some are held by torques that fall with them.

        Args:
            free: accelerations without that, (..., M, E).
            per_torque: acceleration of all joints per torque on each of those that are held, (M, E, H).
            own: the same of those that are held, (M, H, H).
            falls: torque by which they are held per acceleration [kg m^2], (..., M, H).
        """
        # accelerations of those that are held, and by them of all
        system = self.one + own * falls[..., None, :]
        alone, held = falls.shape[-1] == 1, self.among
        there = free[..., held] / system[..., 0] if alone else np.linalg.solve(system, free[..., held, None])[..., 0]
        found: Array = free - np.matmul(per_torque, (falls * there)[..., None])[..., 0]
        return found


def between(values: Array, every: int) -> Array:
    """Samples (T, ...) and those between them, `every` times as many, on cubics through the four samples around."""
    # at either end a further value on the curve through up to four
    weights = {1: [1.0], 2: [-1.0, 2.0], 3: [1.0, -3.0, 3.0], 4: [-1.0, 4.0, -6.0, 4.0]}[min(len(values), 4)]
    first, last = (np.tensordot(weights, four, axes=1)[None] for four in (values[:4][::-1], values[-4:]))
    padded = np.concatenate([first, values, last])
    n = (len(values) - 1) * every + 1
    found = np.empty((n, *values.shape[1:]))
    found[::every] = values
    # Lagrange's cubic through the two samples on either side
    before, left, right, after = padded[:-3], padded[1:-2], padded[2:-1], padded[3:]
    for part in range(1, every):
        x = part / every
        found[part::every] = (
            -x * (x - 1) * (x - 2) / 6 * before
            + (x + 1) * (x - 1) * (x - 2) / 2 * left
            - (x + 1) * x * (x - 2) / 2 * right
            + (x + 1) * x * (x - 1) / 6 * after
        )
    return found


def straight(values: Array, every: int) -> Array:
    """Samples (T, ...) and those between them on straight lines: of what changes slowly, or has edges."""
    n = (len(values) - 1) * every + 1
    found = np.empty((n, *values.shape[1:]))
    for part in range(every):
        share = part / every
        found[part : n - 1 : every] = (1 - share) * values[:-1] + share * values[1:]
    found[-1] = values[-1]
    return found
