"""Models of single simulations: what the builder makes of other numbers, field by field, in one engine."""

import mujoco
import numpy as np
from mujoco import batch

from ffgym.core.errors import FFGymError
from ffgym.robot import model_field


def check_same_make(model: mujoco.MjModel, common: mujoco.MjModel, robot: str) -> None:
    """Check that a model differs from that of its batch in numbers alone.

    Raises:
        FFGymError: if it has other joints or actuators.
    """
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
