"""Checks of the arguments of `reset` and `step`, made before anything has changed."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode

from ffgym.core.errors import FFGymError, check_shape
from ffgym.core.types import Array, BoolArray


def check_actions(actions: Any, shape: tuple[int, int], going: BoolArray | None) -> Array:
    """Return actions as float64 of `shape` (B, N), zero where no episode is `going`, None is everywhere."""
    try:
        values: Array = np.asarray(actions, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        return check_shape("actions", actions, shape)  # which names the mistake
    if values.shape == shape:
        if going is not None:
            values = np.where(going[:, None], values, 0.0)
        if np.count_nonzero(np.isfinite(values)) == values.size:
            return values
        actions = values
    return check_shape("actions", actions, shape)


def reset_mask(mask: Any, n: int) -> BoolArray:
    """Return the mask of `n` sub-environments to reset; None is all."""
    if mask is None:
        return np.ones(n, dtype=np.bool_)
    given = mask
    with suppress(ValueError):  # a ragged list
        mask = np.asarray(given)
    if isinstance(mask, np.ndarray) and mask.shape == (n,) and mask.dtype == np.bool_ and mask.any():
        return mask
    raise FFGymError(f"options['reset_mask'] must be an array of {n} bool with at least one True, got {given!r}.")


def options_for_each(options: Any, n: int) -> tuple[list[dict[str, Any]], Any]:
    """Return the options of each of `n` sub-environments, and the reset mask among them."""
    if not isinstance(options, Mapping | None):
        raise FFGymError(f"options = {options!r} must be a dict, e.g. {{'horizon': 250}}.")
    shared = dict(options or {})
    mask, each = shared.pop("reset_mask", None), shared.pop("each", None)
    if each is None:
        return [shared] * n, mask
    if not isinstance(each, Sequence) or len(each) != n or not all(isinstance(own, Mapping) for own in each):
        raise FFGymError(f"options['each'] must be a list of {n} dicts, one per sub-environment.")
    return [shared | dict(own) for own in each], mask


def seeds_for_each(seed: Any, n: int) -> list[int | None]:
    """Return seeds of `n` sub-environments: i gets seed + i, or one is given for each; None gives no seed."""
    if seed is None:
        return [None] * n
    if isinstance(seed, str) or not isinstance(seed, Sequence | np.ndarray):
        return [check_seed(seed) + i for i in range(n)]
    if len(seed) != n:
        raise FFGymError(f"seed has {len(seed)} entries, must be one number or {n}.")
    return [None if each is None else check_seed(each) for each in seed]


def check_seed(seed: Any) -> int:
    """Return a seed if it is a whole number from 0 on."""
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise FFGymError(f"seed = {seed!r} must be a whole number >= 0, or None.")
    return int(seed)


def parse_autoreset_mode(mode: AutoresetMode | str) -> AutoresetMode:
    """Return Gymnasium's autoreset mode of that name."""
    try:
        return AutoresetMode(mode)
    except ValueError as error:
        raise FFGymError(
            f"Unknown autoreset_mode {mode!r}. Available: {', '.join(m.value for m in AutoresetMode)}."
        ) from error
