"""Simulations that blow up: an error of ours in place of warnings that the engine prints."""

from collections.abc import Iterator
from contextlib import contextmanager

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray


def check_stable(warned: BoolArray, robot: str, began: Array, duration: float, physics_dt: float) -> None:
    """Check that no simulation became unstable.

    Args:
        warned: new warnings of the engine, shape (B, kinds).
        robot: name, for the message.
        began: when each simulation began [s], shape (B,).
        duration: how long it ran [s].
        physics_dt: physics step [s].

    Raises:
        FFGymError: if one did.
    """
    failed = np.flatnonzero(warned[:, _BAD].any(axis=1))
    if failed.size:
        first = int(failed[0])
        raise FFGymError(
            f"Simulation {first} of robot {robot!r} became unstable between t = {began[first]:.3f} s and "
            f"{began[first] + duration:.3f} s. Lower servo gains, torques or the physics step of {physics_dt} s."
        )


@contextmanager
def unprinted_warnings() -> Iterator[None]:
    """Keep MuJoCo from printing warnings and writing them to a file; an unstable simulation is an error of ours."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


_BAD = [
    int(mujoco.mjtWarning.mjWARN_BADQPOS),
    int(mujoco.mjtWarning.mjWARN_BADQVEL),
    int(mujoco.mjtWarning.mjWARN_BADQACC),
]
