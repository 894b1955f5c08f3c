"""Names under which `gymnasium.make` and `gymnasium.make_vec` find the environments; `import ffgym` registers them.

Heavy modules are not imported here: Gymnasium loads an environment's module when it is made.
"""

import gymnasium as gym

ENVIRONMENTS = {
    "ffgym/CirclePath-v0": "ffgym.envs.circle_path:CirclePath",
    "ffgym/OneAxis-v0": "ffgym.envs.one_axis:OneAxis",
    "ffgym/JointMotion-v0": "ffgym.envs.joint_motion:JointMotion",
    "ffgym/FollowPath-v0": "ffgym.envs.follow_path:FollowPath",
    "ffgym/WorkcellCircles-v0": "ffgym.envs.circle_path:WorkcellCircles",
}
"""Module and name by id; the class of the single environment ends in Env, that of the vector environment in
VectorEnv."""


def register() -> None:
    """Register every environment that is not registered yet."""
    for name, place in ENVIRONMENTS.items():
        if name not in gym.registry:
            gym.register(id=name, entry_point=f"{place}Env", vector_entry_point=f"{place}VectorEnv")
