"""Model of the documented robot behind a controller: motor angles along the set-points that were sent.

Its servo follows the set-points behind delay and filter. Friction and inertia of each joint are those of the
description times factors, as a model that is wrong in them follows its set-points earlier or later than the robot does.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy

from ffgym.control import SetpointResponse
from ffgym.core.errors import FFGymError
from ffgym.core.measures import rms
from ffgym.core.types import Array, BoolArray
from ffgym.paths import Reference
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation import Run, simulate

NUISANCES = ("Coulomb friction", "viscous friction", "rotor inertia")
"""Nuisance parameters of each joint, as logarithms of factors."""
MOVES = 2e-3
"""Range of set-points below which a joint counts as at rest, motor side [rad]; some steps of a resolver."""
_FINER = 4
"""Set-points of the model's servo for each one that was sent; chosen: every millisecond, of 4."""
_BLOCK = 0.25
"""Length of a block of time [s]; chosen: some periods of the servo."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SetpointLog:
    """Set-points and motor angles of one recording."""

    name: str
    sent: Array
    """Set-points every control step, motor side [rad], shape (T, N)."""
    t: Array
    """Times of measurements [s], shape (M,), within the samples."""
    measured: Array
    """Motor angles, motor side [rad], shape (M, N)."""

    @classmethod
    def of(cls, recording: Recording, robot: RobotDescription) -> "SetpointLog":
        """Read a recording, from the first control step to the last whole one.

        Raises:
            FFGymError: if it is of other joints than those of the robot, or too short.
        """
        if (header := recording.header).joints != robot.joints:
            raise FFGymError(
                f"Recording {header.segment!r} is of joints {', '.join(header.joints)} of {header.robot!r}, robot "
                f"{robot.name!r} has {', '.join(robot.joints)}. Name the robot of the recording."
            )
        t, dt = recording.t - recording.t[0], robot.servo.control_dt
        grid = np.arange(int(t[-1] / dt + 1e-9) + 1) * dt
        if len(grid) < 2:
            raise FFGymError(f"Recording {recording.header.segment!r} lasts {t[-1]:.3g} s, needs a second or more.")
        sent, measured = (
            recording.header.motor_side(recording.joint_array(f"{name}.position")) for name in ("reference", "motor")
        )
        within = t <= grid[-1] + 1e-9
        samples = scipy.interpolate.make_interp_spline(t, sent, k=1)(np.minimum(grid, t[-1]))
        return cls(name=recording.header.segment, sent=samples, t=t[within], measured=measured[within])


@dataclass(frozen=True, kw_only=True, eq=False)
class ResponseModel:
    """Motor angles of the documented robot, by parameters: response, then logarithms of factors (3 N)."""

    arm: RigidArm
    logs: tuple[SetpointLog, ...]
    n_threads: int

    @property
    def step(self) -> float:
        """Smallest noise of a motor angle [rad]: that of the steps of the documented resolver."""
        return self.arm.robot.sensors.resolver_step / float(np.sqrt(12))

    @cached_property
    def robot(self) -> RobotDescription:
        """Robot whose servo gets set-points so often that lines between those that were sent stay straight."""
        servo = self.arm.robot.servo
        return replace(self.arm.robot, servo=replace(servo, control_dt=servo.control_dt / _FINER))

    @cached_property
    def moves(self) -> BoolArray:
        """True for joints whose set-points move, shape (N,)."""
        moves: BoolArray = np.max([np.ptp(log.sent, axis=0) for log in self.logs], axis=0) > MOVES
        return moves

    @cached_property
    def blocks(self) -> Array:
        """Number of the block of each row of all logs, shape (M,)."""
        starts = np.cumsum([0, *(int(log.t[-1] / _BLOCK) + 1 for log in self.logs[:-1])])
        return np.concatenate([start + log.t // _BLOCK for start, log in zip(starts, self.logs, strict=True)])

    def residuals(self, each: Sequence[tuple[SetpointResponse, Array]]) -> list[Array]:
        """Compute measured angles less those of the model for several parameters, side by side: (M, N) each."""
        runs, machines = [], []
        for response, factors in each:
            machine = scale(self.robot, *np.exp(factors.reshape(3, -1)))
            runs += [Run(reference=self._reference(log, response)) for log in self.logs]
            machines += [machine] * len(self.logs)
        dt = self.robot.servo.control_dt
        recordings = simulate(runs, arm=self.arm, machine=machines, record_dt=dt, n_threads=self.n_threads)
        found = [
            log.measured
            - scipy.interpolate.make_interp_spline(recording.t, recording.joint_array("motor.position"), k=3)(log.t)
            for recording, log in zip(recordings, self.logs * len(each), strict=True)
        ]
        count = len(self.logs)
        return [np.concatenate(found[i * count : (i + 1) * count]) for i in range(len(each))]

    @cached_property
    def late(self) -> Array:
        """Residuals of set-points that arrive at once, motor side [rad], shape (M, N)."""
        (residual,) = self.residuals([(SetpointResponse(), np.zeros(3 * self.arm.robot.n_joints))])
        return residual

    def guess(self) -> tuple[Array, float]:
        """Guess the noise of each joint [rad] and the delay [ms], by the shift at which motors move like the model."""
        residual = self.late
        measured = np.concatenate([log.measured for log in self.logs])
        speed = np.concatenate([np.gradient(log.measured, log.t, axis=0) for log in self.logs])
        # late by tau: measured = model(t - tau), so that residual = -tau times the speed
        weight = self.moves / np.maximum(rms(measured - measured.mean(axis=0), 0), 1e-9) ** 2
        late = -float((weight * speed * residual).sum() / (weight * speed**2).sum())
        return np.hypot(rms(residual + late * speed, 0), self.step), 1e3 * float(np.clip(late, 1e-3, 0.09))

    def _reference(self, log: SetpointLog, response: SetpointResponse) -> Reference:
        """Make the reference that a response makes of a log's set-points, which a drive joins by straight lines."""
        robot, dt = self.robot, self.robot.servo.control_dt
        arrived = response.apply(log.sent, _FINER * dt, _FINER)
        t = dt * np.arange(len(arrived), dtype=np.float64)
        path = scipy.interpolate.make_interp_spline(t, robot.drive.joint_angle(arrived), k=3)
        q, dq, ddq = (np.asarray(path(t, order), dtype=np.float64) for order in range(3))
        if not response.lag:  # lines have corners, over which a controller differences speeds
            cycle = _FINER * dt
            ddq = (dq - np.vstack([np.tile(dq[:1], (_FINER, 1)), dq[:-_FINER]])) / cycle
        return Reference(name=log.name, robot=robot, t=t, q=q, dq=dq, ddq=ddq, phases=())


def scale(robot: RobotDescription, coulomb: Array, viscous: Array, inertia: Array) -> RobotDescription:
    """Multiply static and Coulomb friction, viscous friction and rotor inertia of a robot by factors, (N,) each."""
    friction = replace(
        robot.friction,
        coulomb=robot.friction.coulomb * coulomb,
        static=robot.friction.static * coulomb,
        viscous=robot.friction.viscous * viscous,
    )
    return replace(
        robot, friction=friction, drive=replace(robot.drive, rotor_inertia=robot.drive.rotor_inertia * inertia)
    )
