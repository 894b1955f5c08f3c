"""How late signals may be beside each other though nothing is wrong: by parts of a row, and of a cycle of the servo.

A row has one time stamp, but its columns are read one after the other; a servo computes for a part of its cycle, knows
speeds as differences of angles, and may filter them; friction lags behind the speed. No description says any of that.
An engine that takes steps does all of it, by half a step or a whole one.
"""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.replay import Replay, servo_feedback
from ffgym.diagnosis.signatures.column import Column
from ffgym.diagnosis.signatures.parts import Parts
from ffgym.effects import ClockEffect, Effect
from ffgym.effects.drive.delay import TorqueDelay
from ffgym.effects.effect import Side
from ffgym.effects.measurement.torque_clock import TorqueClock
from ffgym.effects.parameters import parameter

OF_ROW = 0.05
"""Standard deviation of the time between torque and position of a row, in rows; chosen: columns that are said to be of
one instant are read within a fifth of a row."""

OF_CYCLE = 0.25
"""Standard deviation of the times by which a servo's torque and the speeds that it knows are late, in its cycles;
chosen: up to a cycle of either is usual."""

OF_FRICTION = 2e-4
"""Standard deviation of the time by which friction lags behind the speed beyond what bristles say [s]; chosen: lags
that were measured are of some milliseconds in thick films, and of none in thin ones."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Lateness(ClockEffect):
    """Something of an earlier instant than the row that it stands in; a doubt, no effect to be named."""

    latency: Array = parameter("d", unit="s", low=-1e-3, high=1e-3, per="machine", source="only a doubt")


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RowOffset(Lateness):
    """Torque written for another instant of a row than position; a doubt, no effect to be named."""

    name: ClassVar[str] = "row_offset"
    title: ClassVar[str] = "instant of the torque within a row"
    equation: ClassVar[str] = r"u_{log}(t) = u(t - d)"
    side: ClassVar[Side] = "controller"
    signature: ClassVar[str] = "torque: proportional to its own rate of change"
    way_in: ClassVar[str] = "recorded motor torques"
    families: ClassVar[tuple[str, ...]] = ("motor.effort",)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class FrictionLag(Lateness):
    """Friction of the speed of an earlier instant; a doubt, no effect to be named.

    Reference:
        Hess, Soom (1990), ASME Journal of Tribology 112(1), 147-152: friction at oscillating sliding velocities.
    """

    name: ClassVar[str] = "friction_lag"
    title: ClassVar[str] = "lag of friction behind the speed"
    equation: ClassVar[str] = r"\tau_f(t) \to \tau_f(t - d)"
    side: ClassVar[Side] = "motor"
    signature: ClassVar[str] = "torque: proportional to the rate of change of friction; at reversals most"
    way_in: ClassVar[str] = "friction of the joints"
    families: ClassVar[tuple[str, ...]] = ("motor.effort",)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ServoCycle(Lateness):
    """Feedback torque that its servo computed from an earlier instant; a doubt, no effect to be named."""

    name: ClassVar[str] = "servo_cycle"
    title: ClassVar[str] = "computing time of the servo"
    equation: ClassVar[str] = r"u_{fb}(t) = u_c(t - d)"
    side: ClassVar[Side] = "controller"
    signature: ClassVar[str] = "servo: proportional to its own rate of change"
    way_in: ClassVar[str] = "recorded feedback torques"
    families: ClassVar[tuple[str, ...]] = ("feedback.effort",)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ServoSpeed(Lateness):
    """Feedback torque of a servo that knows speeds late, as differences or filtered; a doubt, no effect to be named."""

    name: ClassVar[str] = "servo_speed"
    title: ClassVar[str] = "lateness of the servo's speeds"
    equation: ClassVar[str] = r"K_v \dot e(t) \to K_v (\dot\theta_{ref}(t) - \dot\theta(t - d))"
    side: ClassVar[Side] = "controller"
    signature: ClassVar[str] = "servo: proportional to the acceleration of the motor"
    way_in: ClassVar[str] = "recorded feedback torques"
    families: ClassVar[tuple[str, ...]] = ("feedback.effort",)


def is_row_offset(kind: type[Effect], n_joints: int) -> bool:
    """Tell whether an effect makes the torque of all joints late by one time, as `RowOffset` does.

    A log shows the sum of both alone: with an effect of that kind in the model, the doubt would trade time with it.
    """
    return kind is TorqueClock or (kind is TorqueDelay and n_joints == 1)


def late_columns(run: Replay) -> list[tuple[Column, float]]:
    """Changes of the predictions per second that signals are late, each with the standard deviation of that time."""
    log, joints = run.log, range(run.robot.n_joints)
    row, cycle = OF_ROW * log.dt, OF_CYCLE * run.robot.servo.control_dt
    rates = log.sampling(-np.gradient(run.torque, log.dt, axis=0))
    lag = log.sampling(-np.gradient(run.bristles.torque, log.dt, axis=0))
    found = [
        (_column(RowOffset, {("torque", j): rates[..., j] for j in joints}), row),
        (_column(FrictionLag, {("torque", j): lag[..., j] for j in joints}), OF_FRICTION),
    ]
    if not log.shows_servo:
        return found
    computed = log.sampling(-np.gradient(servo_feedback(run.read, run.robot), log.dt, axis=0))
    known = log.sampling(run.robot.servo.velocity_gain * run.robot.drive.motor_angle(run.read.ddq))
    found.append((_column(ServoCycle, {("servo", j): computed[..., j] for j in joints}), cycle))
    found.append((_column(ServoSpeed, {("servo", j): known[..., j] for j in joints}), cycle))
    return found


def _column(effect: type[Lateness], parts: Parts) -> Column:
    """Of one number for the machine."""
    return Column(effect=effect, joint="", parameter="latency", part=None, choice=0, span=0, shape={}, parts=parts)
