"""Fingerprints of environment ids: their physics and behaviour as numbers that are kept with the version.

A published result names an id. If its behaviour changes, old results no longer compare with new ones, so that the
version must change too: `check` compares an environment with `fingerprints.json`.
"""

import hashlib
import json
from functools import cache
from importlib import resources
from typing import Any

import gymnasium as gym
import mujoco
import numpy as np
from mujoco import batch

from ffgym.core.errors import FFGymError
from ffgym.core.registration import find_spec
from ffgym.core.types import Array
from ffgym.robot import model_field

DIGITS = 9
"""Digits of the model's numbers that count: processors differ in the sixteenth."""
TOLERANCE = 1e-6
"""Relative difference of behaviour that counts as a change: far above the rounding of other processors, and far below
any change of a constant that is meant."""
STEPS = 300
"""Length of an episode of the golden trajectory, with random actions: 1.2 s, past the first rest of the circles."""
EPISODES: tuple[dict[str, Any], ...] = (
    {},
    {"reward": "feedback_effort"},
    {"reward": "path_error", "speed": 0.1},
    {"error_limit": 1e-3},
    {"reward": "relative_path_error", "speed": 0.1},
)
"""Options of the episodes: defaults, every reward, a circle that is reached, and an emergency stop. Options that an
environment lacks are left out; seeds count from 0."""


_UNRECORDED = ("clipped", "practice")
"""Entries of info that came after the first fingerprints, and follow from action and motion."""


def fingerprint(name: str) -> dict[str, Any]:
    """Compute the fingerprint of a registered environment with its default arguments.

    Returns:
        `mujoco` (version), `model` (hash of the compiled model's numbers), `layout` (of the observation) and
        `behaviour` (numbers along seeded episodes: observations, rewards, torques).
    """
    core = gym.make(find_spec(name)).unwrapped.core  # type: ignore[attr-defined]
    behaviour = [number for seed, options in enumerate(EPISODES) for number in _episode(name, seed, dict(options))]
    return {
        "mujoco": mujoco.__version__,
        "model": _model_hash(core.plant.model),
        "layout": list(core.observation_layout),
        "behaviour": behaviour,
    }


def _episode(name: str, seed: int, options: dict[str, Any]) -> list[float]:
    """Run an episode; return its numbers: observations, sum of rewards, and everything in info."""
    limit = {key: options.pop(key) for key in ("error_limit",) if key in options}
    env = gym.make(find_spec(name), **limit).unwrapped
    core = env.core  # type: ignore[attr-defined]
    if str(options.get("reward")).endswith("path_error") and core.robot.tool is None:
        return []
    known = {key: value for key, value in options.items() if key in ("reward", *core.tasks.option_names)}
    observation, info = env.reset(seed=seed, options=known)
    numbers, total = _round(observation), 0.0
    for action in np.random.default_rng(seed).uniform(-1, 1, size=(STEPS, core.robot.n_joints)):
        observation, reward, terminated, truncated, info = env.step(action)
        total += float(reward)
        if terminated or truncated:
            break
    numbers += [*_round(observation), *_round(np.array([total]))]
    told = [value for key, value in sorted(info.items()) if key not in _UNRECORDED]
    return numbers + [x for value in told if not isinstance(value, str | dict) for x in _round(value)]


def check(name: str) -> None:
    """Check that an environment still has the fingerprint of its id."""
    kept = read_fingerprints().get(name)
    if kept is None:
        raise FFGymError(f"{name} has no stored fingerprint; run python -m scripts.env_fingerprints.")
    now = fingerprint(name)
    changed = [key for key in ("mujoco", "model", "layout") if now[key] != kept[key]]
    if len(now["behaviour"]) != len(kept["behaviour"]) or not np.allclose(
        now["behaviour"], kept["behaviour"], rtol=TOLERANCE, atol=TOLERANCE
    ):
        changed.append("behaviour")
    if changed:
        base, _, version = name.rpartition("-v")
        raise FFGymError(
            f"{name} differs from its record: {', '.join(changed)} changed. Results under this id would not compare: "
            f"bump the version (register {base}-v{int(version) + 1} in ffgym/core/registration.py, say what changed in "
            f"CHANGELOG.md), then run python -m scripts.env_fingerprints."
        )


@cache
def read_fingerprints() -> dict[str, Any]:
    """Read the fingerprints that are kept with the package, by id."""
    text = (resources.files("ffgym.envs") / "fingerprints.json").read_text(encoding="utf-8")
    kept: dict[str, Any] = json.loads(text)
    return kept


def _model_hash(model: mujoco.MjModel) -> str:
    """Hash all numbers of a compiled model to DIGITS digits; return 16 hexadecimal digits."""
    digest = hashlib.sha256()
    for name in sorted(batch.MODEL_FIELDS):
        digest.update(f"{name} {_round(np.asarray(model_field(model, name)))}\n".encode())
    return digest.hexdigest()[:16]


def _round(values: Array) -> list[float]:
    """Round numbers to DIGITS significant digits; -0 becomes 0."""
    return [float(f"{x:.{DIGITS - 1}e}") + 0.0 for x in np.ravel(values).astype(np.float64).tolist()]
