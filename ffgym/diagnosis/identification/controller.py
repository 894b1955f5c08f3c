"""Controller from recordings: delay and filter of its set-points, and gains of its servo where torque was recorded.

Delay and filter are fitted with a simulated robot under its servo (`identify_response`), which must have the gains of
the real one: a servo that is stiffer follows earlier, and would pass for a shorter delay. Where torque was recorded,
the servo's equation gives first gains without a model, then delay and filter are fitted with those of them that
contradict the documented ones, then the gains, with whichever delay and filter are known better.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ffgym.core.errors import check_class
from ffgym.core.types import Array
from ffgym.diagnosis.identification.servo_equation import ServoLog, why_no_torque, with_angles
from ffgym.diagnosis.identification.servo_gains import ServoFit, fit_servo, search_response
from ffgym.diagnosis.identification.setpoint_model import NUISANCES, ResponseModel, SetpointLog
from ffgym.diagnosis.identification.setpoint_response import ResponseFit, identify_response
from ffgym.recordings import Recording
from ffgym.robot import RigidArm
from ffgym.robot.parts import Servo
from ffgym.simulation.run import Progress

_MODEL_DELAY = 1e-4
"""Standard deviation of delay and lag together above which those of the simulated robot are taken for gains [s];
chosen: how a drive makes speeds of set-points moves the latter by so much."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ControllerFit:
    """Controller as recordings show it."""

    response: ResponseFit
    """Delay and filter."""
    servo: ServoFit | None
    """Gains; None where no torque was recorded."""
    no_torque: str
    """Why there are no gains; '' where there are."""


def identify_controller(
    recordings: Sequence[Recording],
    arm: RigidArm,
    *,
    feedforward: bool = True,
    n_threads: int = 0,
    seed: int = 0,
    progress: Progress | None = None,
) -> ControllerFit:
    """Identify delay and filter of a controller, and the gains of its servo where motor torque was recorded.

    Args:
        recordings: as for `identify_response`; with `motor.effort` for gains.
        arm: the robot as it is documented.
        feedforward: True for a controller that computes its rigid feed-forward from set-points; recorded
            `feedforward.effort` is taken before it.
        n_threads: threads of the engine, 0 for all cores.
        seed: of the bootstrap.
        progress: as for `identify_response`.

    Raises:
        FFGymError: as `identify_response`.
    """
    reason = why_no_torque(recordings)
    if reason or not recordings:
        return ControllerFit(
            response=identify_response(recordings, arm, n_threads=n_threads, progress=progress),
            servo=None,
            no_torque=reason,
        )
    check_class("arm", arm, RigidArm, "RigidArm(robot) makes one of a description")
    logs = [ServoLog.of(each, arm, feedforward=feedforward) for each in recordings]
    if not np.any([log.moves for log in logs]):
        identify_response(recordings, arm, n_threads=n_threads, progress=progress)  # says what is wrong
    servo, rng = arm.robot.servo, np.random.default_rng(seed)
    joints = arm.robot.joints
    # first gains from measured angles alone, then delay and filter with them
    searched = search_response(logs)
    first = fit_servo(logs, servo, searched.response, rng, joints=joints)
    near = _with_servo(arm, first.unlike_documented(servo))
    response = identify_response(recordings, near, n_threads=n_threads, progress=progress)
    # gains with instruments from the robot that moves as this one did
    angles = _simulate(recordings, near, response, n_threads)
    known = searched if searched.total_spread < _MODEL_DELAY else response
    found = fit_servo(
        logs,
        servo,
        known.response,
        rng,
        joints=joints,
        covariance=known.covariance,
        instruments=with_angles(logs, angles),
    )
    return ControllerFit(response=response, servo=found, no_torque="")


def _with_servo(arm: RigidArm, servo: Servo) -> RigidArm:
    """Return a robot with another servo."""
    return RigidArm(replace(arm.robot, servo=servo))


def _simulate(recordings: Sequence[Recording], arm: RigidArm, fit: ResponseFit, n_threads: int) -> list[Array]:
    """Simulate motor angles at the rows of each recording, motor side [rad], (T, N) each; held at the end."""
    logs = tuple(SetpointLog.of(each, arm.robot) for each in recordings)
    model = ResponseModel(arm=arm, logs=logs, n_threads=n_threads)
    factors = np.log(np.concatenate([fit.factors[name] for name in NUISANCES]))
    (residual,) = model.residuals([(fit.response, factors)])
    angles, start = list[Array](), 0
    for recording, log in zip(recordings, logs, strict=True):
        moved = log.measured - residual[start : start + len(log.t)]
        start += len(log.t)
        angles.append(np.pad(moved, ((0, len(recording) - len(moved)), (0, 0)), mode="edge"))
    return angles
