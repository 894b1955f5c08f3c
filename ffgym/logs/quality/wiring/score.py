"""Share of each signal that a reading of the columns leaves unexplained: torques by the arm, others by the motion."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.logs.preparation import convert_to_joint_side, convert_to_motor_side
from ffgym.logs.quality.wiring.model import Columns, Regressor, bounds, fit_bounded
from ffgym.logs.quality.wiring.sample import SIGN, WiringSamples
from ffgym.recordings.rewiring import Rewire, Rewiring

FLOOR, TOOL_FLOOR = 0.005, 0.004
"""Shares of the energy of a signal, and of the path of the tool, below which what is left is not told apart:
elasticity, ripple and friction laws make them."""

_ROUNDING = 1e-5
"""Share that resolution and filters leave."""

CAP = 10.0
"""Share above which a signal is explained no worse: one of another unit leaves any multiple."""

_TRAVEL = 1e-3
"""Travel [rad or m, link side] from which on a joint is judged."""

_ENOUGH = 40
"""Rows in which a joint must slide to be judged by its torque."""

_MARGIN = 0.1
"""Share of the range of a joint by which it may be beyond: zeros that are a little off."""

_SPEED = 3.0
"""Multiple of the largest speed of a joint that none has."""

Channel = tuple[str, int]
"""Family that is explained, and number of the joint or 0."""

Lefts = dict[Channel, float]
"""Share of the energy of each channel that is left on rows that were left out; at least FLOOR, at most CAP."""

Bounds = Mapping[str, tuple[float, float]]
"""Smallest and largest coefficients by the names of columns of a regressor."""

TORQUE = "motor.effort"
POSITION = "motor.position"


class Scorer:
    """Judge of readings of one set of samples."""

    def __init__(self, samples: WiringSamples, regressor: Regressor) -> None:
        """Keep what is judged, and the arm that judges it."""
        self.samples, self.regressor, self.robot = samples, regressor, regressor.robot
        self.n = self.robot.n_joints
        self._columns = lru_cache(maxsize=24)(self._compute_columns)
        self._pairs = _pairs(samples)
        self._cheap = {"range", "speed", *(pair.channel for pair in self._pairs)}
        self._torques: dict[tuple[object, ...], float] = {}
        self._shares: dict[tuple[object, ...], float | None] = {}
        self._limit_shares: dict[tuple[object, ...], Lefts] = {}

    def values(self, wiring: Rewiring, family: str, order: int = 0) -> Array:
        """Columns of a family, or their derivatives, in a reading, (R, P)."""
        parts = 3 if family.startswith("tcp") else self.n
        return np.stack([self.part(wiring, family, part, order) for part in range(parts)], axis=1)

    def part(self, wiring: Rewiring, family: str, part: int, order: int = 0) -> Array:
        """One of these columns, (R,)."""
        rewire = wiring.of(family, 3 if family.startswith("tcp") else self.n)
        given = self.samples.column(family, rewire.source[part], order, rewire.delay[part])
        return np.asarray(rewire.factor[part] * given / wiring.clock**order + rewire.offset[part] * (order == 0))

    def cheap(self, wiring: Rewiring, floor: float = FLOOR) -> Lefts:
        """Channels that need no dynamics."""
        found = {(pair.channel, j): self._compare(wiring, pair, j) for pair in self._pairs for j in range(self.n)}
        known = {key: left for key, left in found.items() if left is not None} | self._limits(wiring)
        return _clip(known, floor)

    def update(self, before: Lefts, wiring: Rewiring, families: Sequence[str], parts: Sequence[int]) -> Lefts:
        """Update channels that need no dynamics, if `before` holds them but for some families and joints."""
        lefts = {key: left for key, left in before.items() if key[0] in self._cheap}
        for pair in self._pairs:
            if not pair.families.isdisjoint(families):
                for j in parts:
                    left = self._compare(wiring, pair, j)
                    if left is not None:
                        lefts[pair.channel, j] = min(max(left, FLOOR), CAP)
        return lefts | _clip(self._limits(wiring), FLOOR) if POSITION in families else lefts

    def _compare(self, wiring: Rewiring, pair: "Pair", j: int) -> float | None:
        """Share of a joint's column that another does not say; None if it does not move."""
        rewires = [wiring.of(family, self.n) for family, _ in (*pair.columns, *pair.others)]
        key = (pair.channel, j, wiring.clock, *((r.source[j], r.factor[j], r.offset[j], r.delay[j]) for r in rewires))
        if key not in self._shares:
            one, other = (
                np.sum([self.part(wiring, family, j, order) for family, order in terms], axis=0)
                for terms in (pair.columns, pair.others)
            )
            scale = float(pair.scale[j])
            moves = np.nanmax(one) - np.nanmin(one) > 0.0
            self._shares[key] = _misfit(one, scale * other) if moves else None
        return self._shares[key]

    def _limits(self, wiring: Rewiring) -> Lefts:
        """Rows in which a joint is where, or as fast as, it cannot be."""
        key = (wiring.of(POSITION, self.n), wiring.clock)
        if key not in self._limit_shares:
            low, high = self.robot.kinematics.range.T
            slack = _MARGIN * (high - low)
            q, dq = (self.link_side(self.values(wiring, POSITION, order)) for order in (0, 1))
            beyond = np.mean((q < low - slack) | (q > high + slack), axis=0)
            fast = np.mean(np.abs(dq) > _SPEED * self.robot.kinematics.max_speed, axis=0)
            shares = {"range": beyond, "speed": fast}
            self._limit_shares[key] = {
                (name, j): float(share[j]) for name, share in shares.items() for j in range(self.n)
            }
        return self._limit_shares[key]

    def torques(self, wiring: Rewiring, floor: float = FLOOR, known: Bounds | None = None) -> Lefts:
        """Channels that the dynamics of the arm explain, with some coefficients in other bounds, if `known`."""
        if not self.samples.has(TORQUE) or self.samples.header.torque_semantics == "unspecified":
            return {}
        columns, torque, rewire = self.columns(wiring), self.torque(wiring), wiring.of(TORQUE, self.n)
        motion = (known is None, wiring.of(POSITION, self.n), wiring.clock)
        keys = {
            j: (motion, j, rewire.source[j], rewire.factor[j], rewire.offset[j], rewire.delay[j])
            for j in self.list_judged(wiring)
        }
        todo = [j for j, key in keys.items() if key not in self._torques]
        if todo:
            found = left_by(columns, todo, torque[:, todo].T, self.samples.held_out, known)
            self._torques |= {keys[j]: left for j, left in zip(todo, found.tolist(), strict=True)}
        return _clip({(TORQUE, j): self._torques[key] for j, key in keys.items()}, floor)

    def tools(self, wiring: Rewiring, floor: float = TOOL_FLOOR) -> Lefts:
        """Channels that the kinematics of the arm explain."""
        lefts: Lefts = {}
        for tool, joints in (("tcp.position", POSITION), ("tcp_reference.position", "reference.position")):
            if self.robot.tool is None or not self.samples.has(tool) or not self.samples.has(joints):
                continue
            key = (tool, wiring.of(tool, 3), wiring.of(joints, self.n), wiring.clock)
            if key not in self._shares:
                path = self.regressor.arm.tcp_position(self.link_side(self.values(wiring, joints)))
                self._shares[key] = _misfit(self.values(wiring, tool), path, free=True)
            lefts[tool, 0] = self._shares[key] or 0.0
        return _clip(lefts, floor)

    def all(self, wiring: Rewiring) -> Lefts:
        """All channels."""
        return self.cheap(wiring) | self.tools(wiring) | self.torques(wiring)

    def left_at_all(self, wiring: Rewiring) -> float:
        """Sum of the logarithms of all that is left, down to rounding."""
        lefts = self.cheap(wiring, _ROUNDING) | self.tools(wiring, _ROUNDING) | self.torques(wiring, _ROUNDING)
        return float(np.sum(np.log([*lefts.values()])))

    def link_side(self, values: Array) -> Array:
        """Positions, speeds or accelerations of a family kept as `motor.position`, behind the gearbox."""
        return convert_to_joint_side(self.robot.drive, self.samples.header, values)

    def columns(self, wiring: Rewiring) -> Columns:
        """Regressor of the motion in a reading."""
        return self._columns(wiring.of(POSITION, self.n), wiring.clock)

    def _compute_columns(self, rewire: Rewire, clock: float) -> Columns:
        wiring = Rewiring(families={POSITION: rewire}, clock=clock)
        q, dq, ddq = (self.link_side(self.values(wiring, POSITION, order)) for order in range(3))
        ways = None
        if self.robot.drive.coupling is None:  # the sign of each motor's speed, filtered as torques are
            link = self.samples.header.position_side == "link"
            turns = np.sign(rewire.factor) * (np.sign(self.robot.drive.gear_ratio) if link else 1.0)
            signs = [self.samples.column(POSITION, rewire.source[j], SIGN, rewire.delay[j]) for j in range(self.n)]
            ways = np.stack(signs, axis=1) * turns
        columns = self.regressor(q, dq, ddq, ways)
        columns.counted[np.ptp(q, axis=0) < _TRAVEL] = False
        return columns

    def torque(self, wiring: Rewiring) -> Array:
        """Recorded torque, motor side, in a reading, (R, N)."""
        return convert_to_motor_side(self.robot.drive, self.samples.header, self.values(wiring, TORQUE))

    def list_judged(self, wiring: Rewiring) -> list[int]:
        """Joints that move enough for their torque to be judged."""
        return [j for j in range(self.n) if self.columns(wiring).counted[j].sum() >= _ENOUGH]

    def strength(self, wiring: Rewiring, j: int) -> float:
        """Torque of a joint as described over the torque as given, by least squares; 0 if they are opposite."""
        columns, torque = self.columns(wiring), self.torque(wiring)[:, j]
        rows = columns.counted[j]
        said = columns.values[j][rows] @ columns.expected
        along = float(said @ torque[rows])
        return float(said @ said) / along if along > 0 else 0.0


def left_by(
    columns: Columns, joints: list[int], torque: Array, held_out: BoolArray, known: Bounds | None = None
) -> Array:
    """Share of each of the torques (Y, R) that the model of each of `joints` (Y) leaves on blocks left out, (Y,)."""
    grams, moments, energies = [], [], []
    for j, y in zip(joints, torque, strict=True):
        for fold in (held_out, ~held_out):
            rows = columns.counted[j] & fold
            x = columns.values[j][rows]
            grams.append(x.T @ x)
            moments.append(x.T @ y[rows])
            energies.append(float(y[rows] @ y[rows]))
    gram, moment, energy = np.stack(grams), np.stack(moments), np.array(energies)
    theta = fit_bounded(gram, moment, *bounds(known), columns.expected)
    other = np.arange(len(gram)).reshape(-1, 2)[:, ::-1].ravel()  # judged where it was not fitted
    theta = theta[other]
    left = energy - 2 * np.einsum("bk,bk->b", theta, moment) + np.einsum("bk,bkl,bl->b", theta, gram, theta)
    shares = left.reshape(-1, 2).sum(axis=1) / np.maximum(energy.reshape(-1, 2).sum(axis=1), 1e-300)
    return np.asarray(np.maximum(shares, 0.0))


def _misfit(measured: Array, said: Array, *, free: bool = False) -> float:
    """Share of the energy of columns (R, ...) about their mean that others leave; with `free` means do not count."""
    seen = np.isfinite(measured.reshape(len(measured), -1)).all(axis=1)
    if seen.sum() < _ENOUGH:
        return FLOOR
    a, b = measured[seen], said[seen]
    centred = a - a.mean(axis=0)
    gap = a - b - ((a - b).mean(axis=0) if free else 0.0)
    energy = float(np.sum(centred**2))
    return float(np.sum(gap**2)) / energy if energy > 0 else FLOOR


def _clip(lefts: Lefts, floor: float) -> Lefts:
    return {key: min(max(left, floor), CAP) for key, left in lefts.items()}


@dataclass(frozen=True, kw_only=True, eq=False)
class Pair:
    """Two ways to say one thing, joint by joint: sums of columns or of their derivatives."""

    channel: str
    columns: tuple[tuple[str, int], ...]
    """Families and orders of derivatives that are added."""
    others: tuple[tuple[str, int], ...]
    """Other columns that say the same."""
    scale: Array
    """Factors by which the others are multiplied, shape (N,)."""

    @cached_property
    def families(self) -> frozenset[str]:
        """All that it compares."""
        return frozenset(family for family, _ in (*self.columns, *self.others))


def _pairs(samples: WiringSamples) -> list[Pair]:
    """List the pairs of samples that say the same twice."""
    ones = np.ones(len(samples.joints))
    motions = [
        ("motor.velocity", (POSITION, 1)),
        ("reference.position", (POSITION, 0)),
        ("reference.velocity", ("reference.position", 1)),
        ("reference.acceleration", ("reference.position", 2)),
        ("command.effort", (TORQUE, 0)),
    ]
    pairs = [
        Pair(channel=family, columns=((family, 0),), others=(other,), scale=ones)
        for family, other in motions
        if samples.has(family) and samples.has(other[0])
    ]
    ratio = np.asarray(samples.header.gear_ratio) if samples.header.position_side == "motor" else ones
    if samples.header.coupling is None:
        pairs += [
            Pair(channel=family, columns=((family, 0),), others=((POSITION, order),), scale=1 / ratio)
            for family, order in (("link.position", 0), ("link.velocity", 1))
            if samples.has(family)
        ]
    if all(samples.has(family) for family in ("feedback.effort", "feedforward.effort", TORQUE)):
        parts = [f for f in ("feedback.effort", "feedforward.effort", "compensation.effort") if samples.has(f)]
        total = tuple((part, 0) for part in parts)
        pairs.append(Pair(channel="feedback.effort", columns=total, others=((TORQUE, 0),), scale=ones))
    return pairs
