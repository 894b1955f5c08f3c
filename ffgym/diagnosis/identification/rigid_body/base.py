r"""Base parameters: the combinations of inertial parameters, rotors and friction that torque can tell at all.

Many parameters act on no motor, or only together with others: of a first link that turns about the vertical axis,
torque tells one number of ten, and that together with its rotor. A column of the equations that is a combination of
those before it, whatever the motion, is left out, and its parameter joins theirs:

.. math:: \tau = W_1 x_1 + W_2 x_2, \quad W_2 = W_1 C \quad\Rightarrow\quad \tau = W_1 (x_1 + C x_2)

Reference:
    Gautier (1991), Journal of Robotic Systems 8(4), 485-506.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ffgym.core.measures import rms
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.diagnosis.identification.rigid_body.observation import Filtering
from ffgym.diagnosis.identification.rigid_body.terms import (
    DEFAULT_TERMS,
    Term,
    columns_of,
    read_description,
    rigid_motion,
    terms_named,
)
from ffgym.paths import Reference
from ffgym.robot import RobotDescription

_STATES = 40
"""Random states for each parameter that there is; chosen: rows enough that none is dependent by chance."""

_REVERSAL = 0.1
"""Time [s] in which random accelerations reach the speed limit; chosen: of the order of an industrial robot's."""

_RANK = 1e-8
"""Share of a column that must be its own; columns that depend on others have 1e-14, others 1e-4 and more."""

_SHOWN = 1e-6
"""Smallest coefficient of a combination, between columns of unit size, that is no rounding."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BaseParameters:
    """Combinations of K parameters that torque can tell, B of them."""

    own: IntArray
    """The parameter that each is called after, shape (B,)."""
    combination: Array
    """Coefficients of all parameters in each, shape (B, K)."""
    labels: tuple[str, ...]
    """Names of the K parameters."""

    def values(self, parameters: Array) -> Array:
        """Base parameters (..., B) of parameters (..., K)."""
        return parameters @ self.combination.T

    def text(self, i: int, digits: int = 4) -> str:
        """Combination i in words, e.g. 'upper.I_zz + 1.44 lower.mass'."""
        parts = [self.labels[self.own[i]]]
        for k in np.flatnonzero(self.combination[i]):
            if k != self.own[i]:
                factor = self.combination[i, k]
                parts.append(f"{'-' if factor < 0 else '+'} {abs(factor):.{digits}g} {self.labels[k]}")
        return " ".join(parts)


def base_parameters(robot: RobotDescription, terms: tuple[Term, ...], seed: int = 0) -> BaseParameters:
    """Base parameters of an arm, from random states within its joint limits.

    Args:
        robot: geometry, gravity, gears.
        terms: what is there to identify.
        seed: of the states; the result does not depend on it.
    """
    return _find_base_parameters(robot, terms, seed)


@lru_cache(maxsize=8)  # the same robot is fitted to many logs in turn
def _find_base_parameters(robot: RobotDescription, terms: tuple[Term, ...], seed: int) -> BaseParameters:
    """Base parameters, as public."""
    labels = tuple(label for term in terms for label in term.labels(robot))
    # independent states: positions within limits, speeds up to the limits, and what reaches them in a reversal
    rng, shape = np.random.default_rng(seed), (_STATES * len(labels), robot.n_joints)
    low, high = robot.kinematics.range.T
    speed = robot.kinematics.max_speed
    dq, ddq = rng.uniform(-speed, speed, shape), rng.uniform(-speed, speed, shape) / _REVERSAL
    columns = columns_of(robot, terms, rigid_motion(robot, rng.uniform(low, high, shape), dq, ddq))
    matrix = columns.swapaxes(1, 2).reshape(-1, len(labels))
    size = np.linalg.norm(matrix, axis=0)
    unit = matrix / np.where(size > 0, size, 1.0)
    own = _independent(unit)
    others = np.setdiff1d(np.flatnonzero(size > 0), own)
    combination = np.zeros((len(own), len(size)))
    combination[np.arange(len(own)), own] = 1.0
    if len(others):
        shared = np.linalg.lstsq(unit[:, own], unit[:, others], rcond=None)[0]
        shared[np.abs(shared) < _SHOWN] = 0.0
        combination[:, others] = shared * size[others] / size[own][:, None]
    return BaseParameters(own=own, combination=combination, labels=labels)


def condition_number(columns: Array, counts: BoolArray, base: BaseParameters) -> float:
    """Condition number of the equations of a motion for base parameters, columns at unit size; inf if one is silent.

    `columns` (R, K, N) are each motor's torque in units of its noise or size; rows count as `counts` (R, N) says.
    """
    matrix = columns[:, base.own].swapaxes(1, 2)[counts]
    size = np.linalg.norm(matrix, axis=0)
    return float(np.linalg.cond(matrix / size)) if np.all(size > 0) and len(matrix) >= len(size) else np.inf


def _independent(unit: Array) -> IntArray:
    """Columns of a matrix, at unit size, that are no combination of those before them (Gram-Schmidt, twice)."""
    basis = np.zeros((len(unit), 0))
    own = []
    for k, column in enumerate(unit.T):
        rest = column - basis @ (basis.T @ column)
        rest -= basis @ (basis.T @ rest)
        if np.linalg.norm(rest) > _RANK:
            own.append(k)
            basis = np.column_stack([basis, rest / np.linalg.norm(rest)])
    return np.array(own, dtype=np.intp)


def excitation_condition(reference: Reference) -> float:
    """Condition number of the equations of a motion for the base parameters of its robot; less tells more.

    Columns have unit size, and rows count where a motor moves as in an identification. The robot's masses weigh the
    motors: each motor's torque is in units of its RMS by the description.
    """
    robot, terms = reference.robot, terms_named(DEFAULT_TERMS)
    motion = rigid_motion(robot, reference.q, reference.dq, reference.ddq)
    columns = columns_of(robot, terms, motion)
    size = rms(np.einsum("tkn,k->tn", columns, read_description(robot, terms)), 0)
    moving = np.abs(motion.motor_dq / robot.drive.gear_ratio) > Filtering().moving
    return condition_number(columns / np.where(size > 0, size, 1.0), moving, base_parameters(robot, terms))
