"""Corrections of set-points that the servos of a batch follow: actions and base of the set-point channel."""

from typing import Any

import numpy as np

from ffgym.control.setpoints import interpolate_motion
from ffgym.core.types import Array, IntArray
from ffgym.envs.tasks import copy_changing, restore_changing
from ffgym.simulation.plant import Plant


class Corrections:
    """Corrections of B robots at the present sample, and their speeds as the drives difference them; motor side.

    Args:
        plant: plant whose controls they are added to.
    """

    def __init__(self, plant: Plant) -> None:
        shape = plant.n_robots, plant.robot.n_joints
        self._plant, self._dt = plant, plant.robot.servo.control_dt
        self._fractions = np.arange(plant.n_substeps) / plant.n_substeps
        self.position = np.zeros(shape)
        """[rad], shape (B, N)."""
        self.speed = np.zeros(shape)
        """[rad/s], shape (B, N)."""

    def rest(self, ids: IntArray) -> None:
        """Begin without correction in sub-environments `ids`."""
        self.position[ids] = self.speed[ids] = 0.0

    def advance(self, ids: IntArray | None, following: Array, controls: Array) -> None:
        """Move to the corrections of the next sample, and add them to the controls on the way.

        Args:
            ids: sub-environments that move, shape (B',); None is all.
            following: corrections at the next sample [rad], shape (B', N).
            controls: MuJoCo's controls of the control step, shape (B', S, 3 N), changed in place.
        """
        rows = slice(None) if ids is None else ids
        present, speed = self.position[rows], self.speed[rows]
        change = (following - present) / self._dt
        ways = np.empty((2, len(following), 1, len(self._fractions), following.shape[1]))
        samples = np.stack([present, following], axis=1), np.stack([speed, change], axis=1)
        interpolate_motion(*samples, self._dt, self._fractions, (ways[0], ways[1]))
        position, velocity, _ = self._plant.split_controls(controls)
        position += ways[0, :, 0]
        velocity += ways[1, :, 0]
        self.position[rows], self.speed[rows] = following, change

    def save(self) -> dict[str, Any]:
        """Copy all that changes."""
        return copy_changing(self, ("position", "speed"))

    def restore(self, saved: dict[str, Any]) -> None:
        """Go back."""
        restore_changing(self, saved)
