"""A short name for the exact physics: equal fingerprints mean the same compiled model and engine."""

import hashlib
from typing import Any

import mujoco
import numpy as np


def model_bytes(model: mujoco.MjModel) -> bytes:
    """The compiled model as in a .mjb file, which this version of MuJoCo loads."""
    buffer = np.empty(mujoco.mj_sizeModel(model), dtype=np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()


def physics_fingerprint(model: mujoco.MjModel) -> str:
    """Hash of the compiled model and the MuJoCo version, 16 hexadecimal digits."""
    digest = hashlib.sha256(mujoco.__version__.encode())
    digest.update(model_bytes(model))
    return digest.hexdigest()[:16]


def model_field(model: mujoco.MjModel, name: str) -> Any:
    """Field of a model by its name in `mujoco.batch.MODEL_FIELDS`, where options are called 'opt.<name>'."""
    return getattr(model.opt, name[4:]) if name.startswith("opt.") else getattr(model, name)
