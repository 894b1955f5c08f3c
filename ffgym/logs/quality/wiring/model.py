"""Torque that a description allows for a motion: a regressor per joint, each coefficient in what machines may have."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.logs.quality.wiring.sample import SLIDES
from ffgym.robot import RigidArm, RobotDescription

_MASS = 0.05
"""Mass added to the last link for the columns of a payload, in that of the arm."""

_SHIFT = 0.1
"""Shift of that mass [m] for the columns of its moments."""

_BOUNDS = {
    "inertia": (0.4, 2.5),
    "rotors": (0.3, 3.0),
    "gravity": (0.4, 2.0),
    "mass": (-1.0, 8.0),
    "moment": (-6.0, 6.0),
    "balance": (-0.4, 0.4),
    "coulomb": (0.15, 8.0),
    "viscous": (0.0, 8.0),
    "load": (0.0, 0.3),
    "constant": (-1.0, 1.0),
}
"""Smallest and largest coefficient: masses that are typical, an unknown payload of two fifths of the arm, a
counterbalance that is not described (in the largest gravity torque of the joint), friction by a factor, losses of a
gearbox, offsets and friction that differs by direction (in Coulomb torques)."""


KNOWN_MASSES = {
    "inertia": (0.6, 1.6),
    "rotors": (0.5, 2.0),
    "gravity": (0.6, 1.6),
    "mass": (-0.5, 1.0),
    "moment": (-0.5, 0.5),
    "balance": (-0.1, 0.1),
    "coulomb": (0.25, 4.0),
    "viscous": (0.0, 4.0),
}
"""Bounds in place of these where masses are known to 60 %, a payload to a twentieth of the arm, friction to a factor of
four."""

_BODIES = ("inertia", "rotors", "gravity", "mass", "moment", "moment", "moment", "balance", "balance")
_NAMES = (*_BODIES, "coulomb", "viscous", "load", "constant")
"""Column by column."""

_SWEEPS = 40
"""Passes over all coefficients: enough for what is left, which is all that is asked; columns are next to orthogonal or
exchangeable."""

_RIDGE = 1e-3
"""Weight of the expected coefficients, in the energy of a column, which decides between columns that say the same."""


def bounds(changed: Mapping[str, tuple[float, float]] | None = None) -> tuple[Array, Array]:
    """Smallest and largest coefficients, (K,) each, of which some may be `changed`."""
    known = _BOUNDS | dict(changed or {})
    low, high = np.array([known[name] for name in _NAMES]).T
    return low, high


@dataclass(frozen=True, kw_only=True, eq=False)
class Columns:
    """Regressor of the motor torque of each joint at R rows."""

    values: Array
    """Motor side [N m], shape (N, R, K)."""
    expected: Array
    """Coefficients of the description as it is, shape (K,)."""
    counted: BoolArray
    """Rows in which each joint slides, shape (N, R)."""


class Regressor:
    """Regressor of a robot for any motion."""

    def __init__(self, robot: RobotDescription) -> None:
        """Compile the arm, and four of it with a payload."""
        self.robot = robot
        self.arm = RigidArm(robot)
        # the robot with more mass on its last link, and with that shifted along three axes
        bodies, last = robot.bodies, robot.n_joints - 1
        added = _MASS * (float(bodies.mass.sum()) + (robot.tool.mass if robot.tool is not None else 0.0))
        total = bodies.mass[last] + added
        heavier = np.where(np.arange(robot.n_joints) == last, total, bodies.mass)
        self._loaded = []
        for shift in (np.zeros(3), *(_SHIFT * axis for axis in np.eye(3))):
            com = bodies.com.copy()
            com[last] = com[last] + added / total * shift
            self._loaded.append(RigidArm(replace(robot, bodies=replace(bodies, mass=heavier, com=com))))
        ones = ("inertia", "rotors", "gravity", "coulomb", "viscous")
        self._expected = np.array([float(name in ones) for name in _NAMES])

    def __call__(self, q: Array, dq: Array, ddq: Array, ways: Array | None = None) -> Columns:
        """Regressor for joint positions, speeds and accelerations, link side, (R, N) each.

        `ways` are the signs of the motors' speeds, (R, N), filtered as the torque is; None takes those of `dq`.
        """
        drive, friction = self.robot.drive, self.robot.friction
        gravity = self.arm.holding_torque(q)
        inertia = self.arm.inverse_dynamics(q, dq, ddq)
        bare, *shifted = (arm.inverse_dynamics(q, dq, ddq, gravity=True) for arm in self._loaded)
        moments = [columns - bare for columns in shifted]
        mass = bare - inertia - self.arm.gravity_torque(q)
        balance = np.abs(gravity).max(axis=0)
        turns = np.where(self.robot.kinematics.is_sliding, 0.0, 1.0) * balance
        speed = drive.motor_angle(dq)
        sign = sliding(speed) if ways is None else ways
        at_joint = [inertia, gravity, mass, *moments, turns * np.sin(q), turns * np.cos(q)]
        links, held, *rest = (drive.motor_torque(torque) for torque in at_joint)
        parts = [links, drive.rotor_inertia * drive.motor_angle(ddq), held, *rest]
        parts += [friction.coulomb * sign, friction.viscous * speed, np.abs(links + held) * sign]
        parts += [np.broadcast_to(friction.coulomb, sign.shape)]
        values = np.stack([np.stack([part[:, j] for part in parts], axis=1) for j in range(q.shape[1])])
        return Columns(
            values=values,
            expected=self._expected,
            counted=np.asarray((np.abs(speed) > SLIDES * np.abs(speed).max(axis=0)).T),
        )


def sliding(speed: Array) -> Array:
    """Sign of speeds (R, ...), smoothly where a joint is slow."""
    return np.asarray(np.tanh(speed / np.maximum(SLIDES * np.abs(speed).max(axis=0), np.finfo(np.float64).tiny)))


@lru_cache(maxsize=1)
def regressor_of(robot: RobotDescription) -> Regressor:
    """Regressor of a robot, kept for the next logs of it."""
    return Regressor(robot)


def fit_bounded(gram: Array, moment: Array, low: Array, high: Array, expected: Array) -> Array:
    """Coefficients (B, K) that minimise the squares left by K columns, by coordinate descent.

    Args:
        gram: products of the columns, shape (B, K, K).
        moment: products of columns and target, shape (B, K).
        low: smallest coefficients, shape (K,).
        high: largest coefficients, shape (K,).
        expected: those that are taken where columns do not tell, shape (K,).
    """
    size = np.sqrt(np.maximum(np.einsum("bkk->bk", gram), 1e-300)).T.copy()
    # coefficients and columns first, so that all fits of one are side by side
    scaled = gram.transpose(2, 1, 0) / (size[None] * size[:, None])
    lowest, highest, wanted = low[:, None] * size, high[:, None] * size, expected[:, None] * size
    found = np.clip(wanted, lowest, highest)
    slope = np.einsum("bkl,bl->bk", scaled.transpose(2, 1, 0).copy(), found.T.copy()).T - moment.T / size
    for _ in range(_SWEEPS):
        before = found.copy()
        for k, column in enumerate(scaled):
            step = (slope[k] + _RIDGE * (found[k] - wanted[k])) / (1.0 + _RIDGE)
            new = np.minimum(np.maximum(found[k] - step, lowest[k]), highest[k])  # np.clip takes longer in a loop
            slope += column * (new - found[k])
            found[k] = new
        if np.array_equal(found, before):
            break
    return np.ascontiguousarray((found / size).T)
