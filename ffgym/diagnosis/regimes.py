"""Residual over noise floor, joint by joint, by what the joint was doing."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.diagnosis.residual import Channel, MotionResidual, Residual, components
from ffgym.diagnosis.settings import settings
from ffgym.robot.friction import LuGreParameters


@dataclass(frozen=True, kw_only=True, eq=False)
class LogRows:
    """Rows of all motions, R in all, of one channel with C components; N joints."""

    motion: IntArray
    """Place of the motion in the log, shape (R,)."""
    time: Array
    """Time since the first motion began, pauses left out [s], shape (R,)."""
    residual: Array
    """Measured minus predicted, in the unit of the channel, shape (R, C); NaN in rows that do not count."""
    floor: Array
    """Noise floor of each row's motion, shape (R, C)."""
    speed: Array
    """Motor speed [rad/s], shape (R, N)."""
    angle: Array
    """Motor angle [rad], shape (R, N)."""
    position: Array
    """Joint position behind the gearbox, link side [rad], shape (R, N)."""
    load: Array
    """Part of the load behind the gearbox that the motor bears, motor side [N m], shape (R, N)."""
    travel: Array
    """Travel of each motor since it turned [rad], shape (R, N)."""
    stood: Array
    """Time for which each motor had stood before its move began [s], shape (R, N)."""
    temperature: Array
    """[degC], shape (R, N)."""


def collect_rows(residual: Residual, channel: Channel) -> LogRows:
    """Rows of a log with the residual of one channel, which all its motions have; none after the last that counts."""
    motions, n = residual.motions, residual.robot.n_joints
    # rows up to the last that counts; at least one
    counting = [np.flatnonzero(motion.valid) for motion in motions]
    kept = [int(rows[-1]) + 1 if len(rows) else 1 for rows in counting]
    # one time axis for all motions, end to end
    ends = np.cumsum([motion.t[k - 1] - motion.t[0] for motion, k in zip(motions, kept, strict=True)])
    begins = np.concatenate([[0.0], ends[:-1]])

    def join(of: Callable[[MotionResidual], Array]) -> Array:
        return np.concatenate([of(motion)[:k] for motion, k in zip(motions, kept, strict=True)])

    def state(name: str) -> Array:
        return join(lambda motion: np.broadcast_to(getattr(motion.state, name), (len(motion.t), n)))

    return LogRows(
        motion=np.repeat(np.arange(len(motions)), kept),
        time=join(lambda motion: motion.t - motion.t[0]) + np.repeat(begins, kept),
        residual=join(lambda motion: np.where(motion.valid[:, None], motion.residual[channel], np.nan)),
        floor=np.repeat(residual.floor[channel], kept, axis=0),
        speed=state("motor_speed"),
        angle=state("motor_angle"),
        position=state("joint_angle"),
        load=state("load_at_motor"),
        travel=join(lambda motion: motion.since_reversal),
        stood=join(lambda motion: motion.at_rest_for),
        temperature=state("temperature"),
    )


_LIMITS = settings().patterns

REGIMES: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {
        "motion": {
            "rest": f"motor slower than {_LIMITS.rest:g} rad/s",
            "presliding": f"within {_LIMITS.bristles:g} f_s / sigma_0 of travel after the motor turned",
            "reversal": f"after that, within {_LIMITS.reversal:g} f_s / sigma_0",
            "restart": f"within {_LIMITS.reversal:g} f_s / sigma_0 of travel after the motor had stood for "
            f"{_LIMITS.dwell:g} s",
            "slow": f"up to {_LIMITS.slow_motion:g} Stribeck velocities",
            "mid": "between slow and fast",
            "fast": "from where viscous friction is as large as Coulomb friction",
        },
        "load": {"low load": "load on the motor below a third of its largest", "high load": "above two thirds"},
        "position": {
            "low end": "lowest third of the positions that the joint went to",
            "middle": "middle third",
            "high end": "upper third",
        },
        "log": {"first third": "first third of the log", "last third": "last third of the log"},
        "temperature": {"cool": "lowest third of the temperatures of the log", "warm": "upper third"},
    }
)
"""Regimes in groups, and what each means; rows of a group do not overlap."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ResidualMap:
    """Residuals of one channel, sorted into places: regimes or motions; C components and P places."""

    channel: Channel
    components: tuple[str, ...]
    places: tuple[str, ...]
    groups: tuple[str, ...]
    """Group of each place, shape (P,)."""
    rms: Array
    """RMS of the residual, shape (C, P); NaN where the log says too little."""
    ratio: Array
    """RMS of the residual over the noise floor of each row's motion, shape (C, P): about 1 where nothing is wrong."""
    rows: IntArray
    """Number of rows, shape (C, P)."""

    @property
    def overall(self) -> Array:
        """RMS of the ratios over all rows of all places, shape (C,); for places that do not overlap."""
        energy, rows = np.nansum(self.ratio**2 * self.rows, axis=1), (self.rows * np.isfinite(self.ratio)).sum(axis=1)
        return np.sqrt(energy / np.where(rows > 0, rows, np.nan))


def map_by_regime(residual: Residual, channel: Channel) -> ResidualMap:
    """Residuals by joint and regime, for a channel whose components are joints.

    Raises:
        FFGymError: if the components of the channel are none.
    """
    if channel == "tool":
        raise FFGymError("Channel tool has axes of the world, no joints, and so no regimes; see motion_map.")
    rows = collect_rows(residual, channel)
    per_joint = [_find_regimes(rows, residual, j) for j in range(residual.robot.n_joints)]
    places = {name: group for group, names in REGIMES.items() for name in names}
    chosen = np.stack([[found[name] for name in places] for found in per_joint], axis=-1)
    return _sort_into(residual, channel, rows, places, chosen)


def map_by_motion(residual: Residual, channel: Channel) -> ResidualMap:
    """Residuals by component and motion."""
    rows = collect_rows(residual, channel)
    places = {motion.motion: "motion" for motion in residual.motions}
    chosen = np.stack([rows.motion == m for m in range(len(residual.motions))])
    everywhere = np.broadcast_to(chosen[..., None], (*chosen.shape, rows.residual.shape[1]))
    return _sort_into(residual, channel, rows, places, everywhere)


def _sort_into(
    residual: Residual, channel: Channel, rows: LogRows, places: Mapping[str, str], chosen: BoolArray
) -> ResidualMap:
    """The map of rows that are `chosen` (P, R, C) for each place."""
    chosen = chosen & np.isfinite(rows.residual)
    count = chosen.sum(axis=1)
    enough = np.where(count >= settings().patterns.few, count, np.nan)
    values = np.nan_to_num(rows.residual)
    over = np.divide(values, rows.floor, out=np.full_like(values, np.nan), where=rows.floor > 0)
    return ResidualMap(
        channel=channel,
        components=components(channel, residual.robot),
        places=tuple(places),
        groups=tuple(places.values()),
        rms=np.sqrt(np.where(chosen, values**2, 0.0).sum(axis=1) / enough).T,
        ratio=np.sqrt(np.where(chosen, over**2, 0.0).sum(axis=1) / enough).T,
        rows=count.T,
    )


def _find_regimes(rows: LogRows, residual: Residual, j: int) -> dict[str, BoolArray]:
    """Rows (R,) of joint `j` in each regime."""
    motion = _find_motion_regimes(rows, residual.robot.friction, j)
    load = np.abs(rows.load[:, j])
    low, _, high = _split_thirds(load, 0.0, load.max())
    ends = _split_thirds(rows.position[:, j], rows.position[:, j].min(), rows.position[:, j].max())
    early, _, late = _split_thirds(rows.time, 0.0, rows.time[-1])
    cool, _, warm = _split_thirds(rows.temperature[:, j], rows.temperature[:, j].min(), rows.temperature[:, j].max())
    names = [name for group, entries in REGIMES.items() if group != "motion" for name in entries]
    return motion | dict(zip(names, (low, high, *ends, early, late, cool, warm), strict=True))


def _find_motion_regimes(rows: LogRows, friction: LuGreParameters, j: int) -> dict[str, BoolArray]:
    """Each row in exactly one regime of motion."""
    limits = settings().patterns
    speed, travel, stood = np.abs(rows.speed[:, j]), rows.travel[:, j], rows.stood[:, j] >= limits.dwell
    # scales of the friction model: deflection of bristles at breakaway, speed at which viscous friction prevails
    bristle = friction.static[j] / friction.bristle_stiffness[j]
    fast = friction.coulomb[j] / friction.viscous[j] if friction.viscous[j] > 0 else np.inf
    in_order = {
        "rest": speed < limits.rest,
        "restart": stood & (travel < limits.reversal * bristle),
        "presliding": travel < limits.bristles * bristle,
        "reversal": travel < limits.reversal * bristle,
        "slow": speed < limits.slow_motion * friction.stribeck_velocity[j],
        "fast": speed >= fast,
        "mid": np.ones_like(stood),
    }
    # a row belongs to the first regime that it satisfies
    left = np.ones_like(stood)
    found = {}
    for name, those in in_order.items():
        found[name] = left & those
        left = left & ~those
    return found


def _split_thirds(values: Array, low: float, high: float) -> tuple[BoolArray, BoolArray, BoolArray]:
    """Rows in each third of a range; none where the range is empty."""
    first, second = low + (high - low) / 3, low + 2 * (high - low) / 3
    wide = high > low
    return wide & (values < first), wide & (values >= first) & (values < second), wide & (values >= second)
