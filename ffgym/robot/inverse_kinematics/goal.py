"""What is asked of the tool: where it is to be and, unless that is free, how it is to be turned."""

from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError, check_rotation, check_rotations, check_shape
from ffgym.core.types import Array, IntArray
from ffgym.robot.dynamics.arm import RigidArm
from ffgym.robot.inverse_kinematics.rotation import rotation_error


@dataclass(frozen=True, kw_only=True, eq=False)
class Goal:
    """Poses of the tool at T samples, each on its own."""

    positions: Array
    """TCP in the world [m], shape (T, 3)."""
    rotations: Array | None
    """Orientation of tool0 in the world, shape (T, 3, 3); None leaves it free."""

    @classmethod
    def of(cls, positions: Array, rotation: Array | None) -> "Goal":
        """Checked goal; one `rotation` (3, 3) holds for all positions.

        Raises:
            FFGymError: if there is no position, or shapes or values are wrong.
        """
        positions = check_shape("positions", positions, (None, 3))
        if len(positions) == 0:
            raise FFGymError("positions is empty, must hold at least one TCP position.")
        if rotation is None:
            return cls(positions=positions, rotations=None)
        if np.ndim(rotation) != 3:
            rotation = check_rotation("rotation", rotation)
            return cls(positions=positions, rotations=np.broadcast_to(rotation, (len(positions), 3, 3)))
        return cls(positions=positions, rotations=check_rotations("rotation", rotation, len(positions)))

    def __len__(self) -> int:
        return len(self.positions)

    def at(self, rows: slice | IntArray) -> "Goal":
        """Some of the samples."""
        return Goal(positions=self.positions[rows], rotations=None if self.rotations is None else self.rotations[rows])

    def miss(self, arm: RigidArm, q: Array) -> tuple[Array, Array]:
        """Twist from the tool at `q` (T, N) to the goal, [m] and [rad], and the Jacobian there, shape (T, 6, N).

        The twist has shape (T, 6), or (T, 3) where the orientation is free.
        """
        position, rotation, jacobian = arm.pose_and_jacobian(q)
        away = self.positions - position
        if self.rotations is None:
            return away, jacobian
        return np.concatenate([away, rotation_error(self.rotations, rotation)], axis=1), jacobian
