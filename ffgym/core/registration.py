"""Names under which `gymnasium.make` and `gymnasium.make_vec` find the environments; `import ffgym` registers them.

Heavy modules are not imported here: Gymnasium loads an environment's module when it is made.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import gymnasium as gym
from gymnasium.envs.registration import EnvSpec


@dataclass(frozen=True)
class Registered:
    """An environment that an id stands for."""

    place: str
    """Module and name; the class of the single environment ends in Env, that of the vector environment in VectorEnv."""
    defaults: Mapping[str, Any] = field(default_factory=dict)
    """Keyword arguments in which the id departs from its class."""
    longest: int | None = None
    """Longest episode [control steps]; None runs every motion to its end."""


def _residual(place: str, *, longest: int, **own: Any) -> Registered:
    """Describe an environment of the second version: a bounded residual on a base law, scored as on the leaderboard."""
    shared: dict[str, Any] = {
        "base": "elastic",
        "bound": 0.6,
        "features": True,
        "preview": 4,
        "reward": "log_rms_error",
        "sensing": "resolver",
        "horizon": longest,
    }
    return Registered(place, shared | own, longest)


_ARM = "irb4600_60_205_arm_drives"

ENVIRONMENTS: Mapping[str, Registered] = MappingProxyType(
    {
        "ffgym/CirclePath-v0": Registered("ffgym.envs.circle_path:CirclePath"),
        "ffgym/OneAxis-v0": Registered("ffgym.envs.one_axis:OneAxis"),
        "ffgym/JointMotion-v0": Registered("ffgym.envs.joint_motion:JointMotion"),
        "ffgym/FollowPath-v0": Registered("ffgym.envs.follow_path:FollowPath"),
        "ffgym/WorkcellCircles-v0": Registered("ffgym.envs.circle_path:WorkcellCircles"),
        "ffgym/Adapt-v0": _residual("ffgym.envs.adapt:Adapt", longest=6000, robot=_ARM),
        "ffgym/CirclePath-v1": _residual("ffgym.envs.circle_path:CirclePath", longest=6000, robot=_ARM),
        "ffgym/OneAxis-v1": _residual(
            "ffgym.envs.one_axis:OneAxis", longest=2500, robot="one_axis_drives", base="lugre_dynamic"
        ),
        "ffgym/JointMotion-v1": _residual("ffgym.envs.joint_motion:JointMotion", longest=2500, robot=_ARM),
        "ffgym/FollowPath-v1": _residual(
            "ffgym.envs.follow_path:FollowPath",
            longest=6000,
            robot=_ARM,
            path=["rounded_square", "spiral", "tilted_circles", "low_circles"],
        ),
        "ffgym/WorkcellCircles-v1": _residual(
            "ffgym.envs.circle_path:WorkcellCircles", longest=6000, workcell="thesis_drives"
        ),
    }
)
"""Environments by id."""


def find_spec(name: str) -> str | EnvSpec:
    """Find what Gymnasium makes an environment from; for a name it would warn of an old version, which is asked for."""
    return gym.registry.get(name, name)


def register() -> None:
    """Register every environment that is not registered yet."""
    for name, known in ENVIRONMENTS.items():
        if name not in gym.registry:
            gym.register(
                id=name,
                entry_point=f"{known.place}Env",
                vector_entry_point=f"{known.place}VectorEnv",
                max_episode_steps=known.longest,
                kwargs=dict(known.defaults),
            )
