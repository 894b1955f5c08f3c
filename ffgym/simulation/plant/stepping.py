"""Physics steps of a batch: forces before each step, models of its own for each robot, checks of stability."""

from collections.abc import Iterator
from contextlib import contextmanager

import mujoco
import numpy as np
from mujoco import batch

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.robot import model_field
from ffgym.simulation.plant.forces import Forces


def stepped(
    engine: batch.Batch, forces: Forces, controls: Array, record: tuple[str, ...], ids: IntArray | None, dt: float
) -> dict[str, Array]:
    """As the engine's rollout, with torques of effects in each step.

    Args:
        engine: simulations.
        forces: their effects.
        controls: a row for each physics step, shape (B, S, 3 N).
        record: fields of the engine to return, as they are after every step.
        ids: which simulations, shape (B,); None is all.
        dt: physics step [s].
    """
    rows = slice(None) if ids is None or len(ids) == engine.nsim else ids
    ids = None if isinstance(rows, slice) else ids
    bound = {name: engine.bind(name) for name in record}
    out = {name: np.empty((*controls.shape[:2], *field.shape[1:])) for name, field in bound.items()}
    setpoints, chosen = engine.bind("ctrl"), forces.choose(rows)
    for k in range(controls.shape[1]):
        setpoints[rows] = controls[:, k]
        forces.apply(chosen, dt)
        engine.step(ids)
        for name, field in bound.items():
            out[name][:, k] = field[rows]
    return out


def check_stable(warned: BoolArray, robot: str, began: Array, duration: float, physics_dt: float) -> None:
    """Check that no simulation became unstable.

    Args:
        warned: new warnings of the engine, shape (B, kinds).
        robot: name, for the message.
        began: when each simulation began [s], shape (B,).
        duration: how long it ran [s].
        physics_dt: physics step [s].
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


def check_same_make(model: mujoco.MjModel, common: mujoco.MjModel, robot: str) -> None:
    """Check that a model differs from that of its batch in numbers alone."""
    if (model.nu, model.na) != (common.nu, common.na) or _joints(model) != _joints(common):
        raise FFGymError(
            f"Robot {robot!r} has other elastic joints, joints of effects or actuators than the other simulations of "
            f"the same batch; simulate it in a batch of its own."
        )


def give_model(engine: batch.Batch, common: mujoco.MjModel, index: int, model: mujoco.MjModel) -> None:
    """Let one simulation of an engine that was made for `common` have the numbers of `model`."""
    for name in batch.MODEL_FIELDS:
        own = model_field(model, name)
        if engine.expanded(name) is not None or not np.array_equal(own, model_field(common, name)):
            engine.expand(name)[index] = own


def _joints(model: mujoco.MjModel) -> list[str]:
    return [model.joint(i).name for i in range(model.njnt)]
