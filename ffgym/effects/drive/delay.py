"""M5: a motor torque that comes later than commanded, by an effect or by numbers of the description."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
import scipy

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.effects.effect import TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques
from ffgym.robot.description import RobotDescription
from ffgym.robot.drive import loop_decay, next_torque

LENGTH = 40
"""Commands that are remembered: 9.5 ms at a physics step of 0.25 ms, far more than a servo bears."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueDelay(TorqueEffect):
    """Dead time of the drive, then the first-order lag of its current loop.

    Delays between two physics steps are interpolated. The lag takes the exact solution for a command that is held over
    the step.

    Raises:
        FFGymError: if the physics step is too short for the commands of the delay to be remembered.
    """

    name = "torque_delay"
    code = "M5"
    title = "delay and bandwidth of the torque loop"
    equation = r"T_c \dot \tau = u(t - d) - \tau"
    side = "motor"
    signature = "torque: proportional to its own rate of change, in quadrature with the acceleration"
    way_in = (
        "torque at every physics step, with memory, as `drive.torque_delay` of a description; delays of MuJoCo's "
        "actuators would delay set-points, not torque"
    )
    confusable_with = ("F2", "G2", "T8", "X5")
    separating_motions = ("excitation",)

    delay: Array = parameter(
        "d",
        unit="s",
        low=0.0,
        high=0.001,
        minimum=0.0,
        source="cycles of drives, 0.25 to 1 ms; servos as stiff as the built-in ones swing with 2 ms and more",
    )
    lag: Array = parameter(
        "T_c", unit="s", low=0.0, high=0.0005, minimum=0.0, source="current loops of 300 Hz and more bandwidth"
    )

    def check_step(self, dt: float) -> None:
        """Check that the commands of the delay can be remembered.

        Raises:
            FFGymError: if they are too many at that step.
        """
        steps = np.max(self.delay, initial=0.0) / dt
        if steps > LENGTH - 2:
            raise FFGymError(
                f"A delay of {steps:.1f} physics steps is too long for effect torque_delay, which remembers "
                f"{LENGTH - 2}; give a shorter delay or a longer physics_dt."
            )

    def initial_memory(self, state: State) -> Array:
        """Return commands, the latest first, then the torque of the current loop; at rest all are one torque."""
        return np.repeat(state.loop_torque[..., None], LENGTH + 1, axis=-1)

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """Return the torque of the delayed current loop beyond the command."""
        self.check_step(dt)
        given = memory[..., -1]
        # dead time: commands move up by one, the one that is due is interpolated
        later = np.empty_like(memory)
        commands = later[..., :-1]
        commands[..., 0], commands[..., 1:] = state.loop_torque, memory[..., :-2]
        due = _interpolate(commands, self.delay / dt)
        later[..., -1] = given = next_torque(given, due, loop_decay(self.lag, dt))
        return Torques(motor=given - state.loop_torque), later

    def torques_over(self, states: State, dt: float) -> Torques:
        """Filter all commands at once; they run straight between samples, which may be longer than the lag."""
        commands = np.broadcast_to(states.loop_torque, states.motor_angle.shape)
        given = np.empty_like(commands)
        for j in range(commands.shape[-1]):
            delay, lag = float(self.delay[j]), float(self.lag[j])
            keep = np.exp(-dt / lag) if lag > 0 else 0.0
            # exact step of the lag for a command that runs straight between samples
            now = 1 - (1 - keep) * lag / dt
            due = _shift(commands[..., j], delay / dt)
            given[..., j] = scipy.signal.lfilter(
                [now, 1 - keep - now], [1, -keep], due, axis=0, zi=(1 - now) * due[:1]
            )[0]
        return Torques(motor=given - commands)


def with_delay_of_drives(
    effects: Sequence[TorqueEffect], robot: RobotDescription, *, with_lag: bool = False
) -> tuple[TorqueEffect, ...]:
    """Return effects of a robot with its `drive.torque_delay`, as MuJoCo delays no torques, in one effect with theirs.

    Args:
        effects: effects of the robot's machine.
        robot: the description.
        with_lag: add `drive.torque_lag`, which a plant has in MuJoCo, where torques are computed without one.
    """
    delay, lag = robot.drive.delay, robot.drive.loop_lag if with_lag else np.zeros(robot.n_joints)
    if not np.any(delay) and not np.any(lag):
        return tuple(effects)
    delays = [effect for effect in effects if isinstance(effect, TorqueDelay)]
    others = [effect for effect in effects if not isinstance(effect, TorqueDelay)]
    total = TorqueDelay(delay=sum((one.delay for one in delays), delay), lag=sum((one.lag for one in delays), lag))
    return (*others, total)


def _shift(commands: Array, steps: float) -> Array:
    """Shift commands (T, ...) by `steps` samples; the first holds before its time."""
    whole, part = int(np.floor(steps)), steps - np.floor(steps)
    padded = np.concatenate([np.repeat(commands[:1], whole + 1, axis=0), commands])
    one, before = padded[1 : len(commands) + 1], padded[: len(commands)]
    return (1 - part) * one + part * before


def _interpolate(commands: Array, steps: Array) -> Array:
    """Return the command `steps` physics steps ago, (..., N), of `commands` (..., N, M), the latest first."""
    whole = np.trunc(np.broadcast_to(steps, commands.shape[:-1]))
    part, index = steps - whole, whole.astype(np.intp)[..., None]
    one, before = (np.take_along_axis(commands, index + k, axis=-1)[..., 0] for k in (0, 1))
    found: Array = (1 - part) * one + part * before
    return found
