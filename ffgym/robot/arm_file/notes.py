"""What a model has and a description of it leaves out."""

import mujoco
import numpy as np

from ffgym.robot.arm_file.chain import Chain


def left_out(model: mujoco.MjModel, chain: Chain) -> tuple[str, ...]:
    """One phrase for each kind of force on the arm that is not taken over; a description has its own forms of them."""
    joints, moved = list(chain.joints), chain.owner >= 0
    springs = np.any(model.jnt_stiffness[joints]) or np.any(model.jnt_stiffnesspoly[joints])
    tendons = np.any(model.tendon_stiffness) or np.any(model.tendon_damping) or np.any(model.tendon_frictionloss)
    medium = model.opt.density > 0 or model.opt.viscosity > 0
    found = {
        "springs in its joints": springs,
        "springs, damping or friction of its tendons (counterbalances are entries of [springs])": tendons,
        "compensated gravity (gravcomp)": np.any(model.body_gravcomp[moved]),
        "forces of the air or water around it": medium,
    }
    return tuple(f"{what} are left out" for what, there in found.items() if there)
