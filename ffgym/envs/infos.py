"""Infos of vector environments in Gymnasium's form: arrays over sub-environments, with masks of who has them."""

from typing import Any

import numpy as np

from ffgym.core.types import Array, BoolArray, IntArray


def masks_for(info: dict[str, Any], n: int) -> dict[str, BoolArray]:
    """Masks that say that all `n` sub-environments have every entry of `info`; one read-only array."""
    every = np.ones(n, dtype=np.bool_)
    every.flags.writeable = False
    return dict.fromkeys([f"_{name}" for name in info], every)


def score(done: BoolArray, returns: Array, lengths: IntArray) -> dict[str, Any]:
    """Return and length of the episodes that are done."""
    mask = done.copy()
    values = {
        "return": np.where(done, returns, 0.0),
        "length": np.where(done, lengths, 0),
        "_return": mask,
        "_length": mask,
    }
    return {"score": values, "_score": mask}


def finals(observation: Array, info: dict[str, Any], done: BoolArray) -> dict[str, Any]:
    """Last observation and info of the episodes that are done, for the autoreset mode SAME_STEP."""
    final_obs = np.full(len(done), None, dtype=object)
    for i in np.flatnonzero(done):
        final_obs[i] = observation[i].copy()
    final_info = {name: value for name, value in info.items() if not name.startswith("_")}
    final_info |= {f"_{name}": done.copy() for name in final_info}
    return {"final_obs": final_obs, "_final_obs": done.copy(), "final_info": final_info, "_final_info": done.copy()}
