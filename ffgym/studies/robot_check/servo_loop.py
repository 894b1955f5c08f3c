"""Whether the servos hold the arm: the linear model of the very simulation, without friction, in one pose."""

from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.robot import ModelOptions, RobotDescription
from ffgym.simulation.plant import Plant

_OPTIONS = ModelOptions(friction=False, looks=False)
"""Friction only damps small motions, so that a loop that is stable without it is stable with it, unless the step is too
long for that damping, which `doubts` asks."""
_NUDGE = 1e-6
"""Step of the finite differences [rad, m]: the cube root of the rounding error, to an order of magnitude."""
_STABLE = 1 + 1e-7
"""Growth in a step that counts as none: finite differences are no better; at 0.25 ms it doubles in half an hour."""
_HIGHEST_MARGIN = 100.0
"""Where the search for the gain margin ends: a loop with more is far from any limit."""
_SEARCH_STEPS = 12
"""Halvings of the search on a logarithmic scale: log(100) / 2^12 is 0.1 %."""


@dataclass(frozen=True, kw_only=True)
class ServoLoop:
    """Small motions about rest, all joints together, of the sampled simulation."""

    place: str
    stable: bool
    gain_margin: float | None = None
    """Factor on all gains at which the loop becomes unstable; None if it is beyond 100, or the loop is unstable."""
    frequency: float = 0.0
    """Of the least damped oscillation [Hz]."""
    damping: float = 1.0
    """Damping ratio of that oscillation; 1 where nothing oscillates."""
    problem: str = ""
    """Why the robot does not even rest there."""


def servo_loop(robot: RobotDescription, place: str, q: Array) -> ServoLoop:
    """Servo loop of the robot resting at joint positions `q` (N,), link side."""
    try:
        poles = _poles(robot, q)
    except FFGymError as error:
        return ServoLoop(place=place, stable=False, problem=str(error))
    stable = bool(np.abs(poles).max() < _STABLE)
    swinging = np.log(poles[poles.imag > 0]) / robot.physics_dt
    ratios = -swinging.real / np.abs(swinging)
    worst = int(np.argmin(ratios)) if swinging.size else None
    return ServoLoop(
        place=place,
        stable=stable,
        gain_margin=_gain_margin(robot, q) if stable else None,
        frequency=0.0 if worst is None else float(np.abs(swinging[worst]) / (2 * np.pi)),
        damping=1.0 if worst is None else float(ratios[worst]),
    )


def _gain_margin(robot: RobotDescription, q: Array) -> float | None:
    """Factor on all servo gains at which the loop becomes unstable."""
    if _is_stable(robot, q, _HIGHEST_MARGIN):
        return None
    low, high = 0.0, np.log(_HIGHEST_MARGIN)
    for _ in range(_SEARCH_STEPS):
        middle = (low + high) / 2
        low, high = (middle, high) if _is_stable(robot, q, np.exp(middle)) else (low, middle)
    return float(np.exp(low))


def _is_stable(robot: RobotDescription, q: Array, factor: float) -> bool:
    servo = robot.servo
    gains = {name: factor * getattr(servo, name) for name in ("position_gain", "velocity_gain", "integral_gain")}
    return bool(np.abs(_poles(replace(robot, servo=replace(servo, **gains)), q)).max() < _STABLE)


def _poles(robot: RobotDescription, q: Array) -> NDArray[np.complex128]:
    """Poles of one physics step of the robot at rest."""
    plant = Plant(robot, 1, options=_OPTIONS, n_threads=1)
    plant.rest(q[None])
    model, data = plant.model, mujoco.MjData(plant.model)
    data.qpos[:], data.act[:] = plant.batch.qpos[0], plant.batch.act[0]
    plant.split_controls(data.ctrl)[0][:] = robot.drive.motor_angle(q)
    size = 2 * model.nv + model.na
    transition = np.zeros((size, size))
    mujoco.mjd_transitionFD(model, data, _NUDGE, True, transition, None, None, None)
    return np.linalg.eigvals(transition).astype(np.complex128)
