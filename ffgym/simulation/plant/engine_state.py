"""States of effects, as the engine has them now."""

from mujoco import batch

from ffgym.core.types import Array, IntArray
from ffgym.effects import State
from ffgym.robot.drive import Drive
from ffgym.simulation.plant.addresses import Addresses
from ffgym.simulation.plant.numbers import Numbers
from ffgym.simulation.plant.reading import Reading


class EngineState:
    """Reads motors, springs, servos and bristles of simulations from the engine."""

    def __init__(self, engine: batch.Batch, at: Addresses, drive: Drive) -> None:
        self._at, self._drive = at, drive
        self._qpos, self._qvel, self._act = (engine.bind(name) for name in ("qpos", "qvel", "act"))
        self._time, self._controls = engine.bind("time"), engine.bind("ctrl")
        self._outputs = None if at.is_elastic.all() else (engine.bind("qfrc_actuator"), engine.bind("qacc"))

    def motor(self, rows: IntArray | slice) -> tuple[Array, Array]:
        """Motor angles [rad] and speeds [rad/s], motor side, (B, N) each."""
        at, drive = self._at, self._drive
        return (
            drive.motor_angle(self._qpos[rows][:, at.motor_qpos]),
            drive.motor_angle(self._qvel[rows][:, at.motor_qpos]),
        )

    def read(self, rows: IntArray | slice, own: Numbers, motor: Array | None = None) -> State:
        """State of simulations `rows` with the numbers `own`, (B, N) each.

        Args:
            rows: which simulations.
            own: their numbers.
            motor: torque that effects added to the motors in the last step, link side [N m]; None is none.
        """
        return Reading(
            self._at,
            self._drive,
            own,
            qpos=self._qpos[rows].copy(),
            qvel=self._qvel[rows].copy(),
            act=self._act[rows].copy(),
            controls=self._controls[rows].copy(),
            time=self._time[rows].reshape(-1, 1).copy(),
            passed=self._passed(rows, own, motor),
        )

    def _passed(self, rows: IntArray | slice, own: Numbers, motor: Array | None) -> Array | None:
        """What gearboxes of rigid joints passed on in the last step: all but what their rotors took (B, N) [N m]."""
        if self._outputs is None:
            return None
        driven, acceleration = (values[rows][:, self._at.motor_qpos] for values in self._outputs)
        passed: Array = driven - own.reflected_inertia * acceleration
        return passed if motor is None else passed + motor
