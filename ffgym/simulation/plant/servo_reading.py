"""What servos know, taken from the engine's state in one go."""

from dataclasses import dataclass

import numpy as np
from mujoco import batch

from ffgym.core.types import Array, IntArray
from ffgym.robot.drive import Drive
from ffgym.simulation.plant.addresses import Addresses


@dataclass(frozen=True, kw_only=True, eq=False)
class ServoReading:
    """Where the engine's state has position, speed and integral of each motor, and the factors on them."""

    engine: batch.Batch
    drive: Drive
    columns: IntArray
    """Shape (3 N,)."""
    scale: Array
    """Shape (3 N,)."""

    @classmethod
    def of(cls, engine: batch.Batch, at: Addresses, drive: Drive) -> "ServoReading":
        """Look the columns up once."""
        views = {name: engine.bind(name) for name in ("qpos", "qvel", "act")}
        starts = {
            name: (view.ctypes.data - engine.state.ctypes.data) // view.itemsize
            for name, view in views.items()
            if view.size
        }
        integral = np.where(at.has_integral, starts.get("act", 0) + at.integral, 0)
        columns = np.concatenate([starts["qpos"] + at.motor_qpos, starts["qvel"] + at.motor_qpos, integral])
        both = drive.gear_ratio if drive.coupling is None else np.ones_like(drive.gear_ratio)
        scale = np.concatenate([both, both, at.has_integral])
        return cls(engine=engine, drive=drive, columns=columns, scale=scale)

    def now(self) -> Array:
        """True motor position [rad], speed [rad/s] and integral [rad s], motor side, (B, 3 N), a copy."""
        state: Array = self.engine.state.take(self.columns, axis=1) * self.scale
        n = len(self.drive.gear_ratio)
        if self.drive.coupling is not None:
            for part in (slice(0, n), slice(n, 2 * n)):
                state[:, part] = self.drive.motor_angle(state[:, part])
        return state
