"""Physics steps with torques of effects in between, one by one."""

import numpy as np
from mujoco import batch

from ffgym.core.types import Array, IntArray
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
