"""Set-points that do not depend on the agent, kept for motions that are followed again and again."""

import numpy as np

from ffgym.control.setpoints import interpolate_motion
from ffgym.core.types import Array, IntArray
from ffgym.simulation.plant import Plant

LARGEST = 64 * 2**20
"""Size beyond which nothing is kept [bytes]: room for all motions of the thesis' circle test."""


class SetpointTable:
    """Position and velocity at every physics step of every control step, in MuJoCo's order of controls.

    What it holds is computed as it would be at every step, bit for bit; docs/performance.md says what it saves.
    """

    def __init__(self, plant: Plant, fractions: Array) -> None:
        self._plant, self._fractions = plant, fractions
        self._rows = np.zeros((0, plant.n_substeps, plant.model.nu))

    def take(self, rows: IntArray) -> Array:
        """Controls of the control steps that begin at `rows` (B,), shape (B, S, 3 N), torque 0; a copy."""
        return self._rows.take(rows, axis=0)

    def write(self, start: int, position: Array, velocity: Array) -> None:
        """Compute the rows from `start` on, of motor-side samples [rad], [rad/s], shape (T, N) each; the last is 0."""
        steps = self._rows[start : start + len(position) - 1]
        out_position, out_velocity, _ = self._plant.split_controls(steps[None])
        dt = self._plant.robot.servo.control_dt
        self._rows[start + len(steps)] = 0.0
        interpolate_motion(position[None], velocity[None], dt, self._fractions, (out_position, out_velocity))

    def move(self, start: int, to: int, length: int) -> None:
        """Move `length` rows towards the front."""
        self._rows[to : to + length] = self._rows[start : start + length]

    def resize(self, length: int) -> bool:
        """Make room for `length` rows; False if that would be too large."""
        if length * self._rows[:0].itemsize * self._plant.n_substeps * self._plant.model.nu > LARGEST:
            self._rows = self._rows[:0].copy()
            return False
        if length > len(self._rows):
            self._rows.resize((length, *self._rows.shape[1:]), refcheck=False)
        return True
