"""States of effects, as the engine has them now."""

from mujoco import batch

from ffgym.effects import State
from ffgym.plant.addresses import Addresses
from ffgym.plant.numbers import Numbers
from ffgym.plant.reading import Reading
from ffgym.robot.drive import Drive
from ffgym.types import Array, IntArray


class EngineState:
    """Reads motors, springs, servos and bristles of simulations from the engine."""

    def __init__(self, engine: batch.Batch, at: Addresses, drive: Drive) -> None:
        self._at, self._drive = at, drive
        self._qpos, self._qvel, self._act = (engine.bind(name) for name in ("qpos", "qvel", "act"))
        self._time, self._controls = engine.bind("time"), engine.bind("ctrl")

    def motor(self, rows: IntArray | slice) -> tuple[Array, Array]:
        """Motor angles [rad] and speeds [rad/s], motor side, (B, N) each."""
        at, drive = self._at, self._drive
        return (
            drive.motor_angle(self._qpos[rows][:, at.motor_qpos]),
            drive.motor_angle(self._qvel[rows][:, at.motor_qpos]),
        )

    def read(self, rows: IntArray | slice, own: Numbers) -> State:
        """State of simulations `rows` with the numbers `own`, (B, N) each."""
        return Reading(
            self._at,
            self._drive,
            own,
            qpos=self._qpos[rows].copy(),
            qvel=self._qvel[rows].copy(),
            act=self._act[rows].copy(),
            controls=self._controls[rows].copy(),
            time=self._time[rows].reshape(-1, 1).copy(),
        )
