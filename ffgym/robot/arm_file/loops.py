"""Constraints that make an arm anything but a serial chain of independent joints."""

import mujoco

from ffgym.core.errors import FFGymError
from ffgym.robot.arm_file.chain import BASE, Chain

_BODIES = (mujoco.mjtEq.mjEQ_CONNECT.value, mujoco.mjtEq.mjEQ_WELD.value)


def check_open(model: mujoco.MjModel, chain: Chain) -> None:
    """Check that no active constraint ties links of the chain to each other, to the world, or joints together.

    Constraints within one link (the linkage of a gripper that is held still) change nothing.

    Raises:
        FFGymError: if one does; the message names it.
    """
    for i in range(model.neq):
        if not model.eq_active0[i]:
            continue
        kind, ends = model.eq_type[i], (int(model.eq_obj1id[i]), int(model.eq_obj2id[i]))
        name = model.equality(i).name or f"number {i + 1}"
        if kind in _BODIES:
            _check_bodies(model, chain, name, model.eq_objtype[i], ends)
        elif kind == mujoco.mjtEq.mjEQ_JOINT.value:
            _check_joints(chain, name, ends)
        elif kind == mujoco.mjtEq.mjEQ_TENDON.value:
            for tendon in ends:
                _check_joints(chain, name, _tendon_joints(model, tendon))


def _check_bodies(model: mujoco.MjModel, chain: Chain, name: str, kind: int, ends: tuple[int, int]) -> None:
    bodies = [int(model.site_bodyid[end]) if kind == mujoco.mjtObj.mjOBJ_SITE.value else end for end in ends]
    owners = {max(int(chain.owner[body]), BASE) for body in bodies}
    if len(owners) > 1:
        first, second = (model.body(body).name for body in bodies)
        raise FFGymError(
            f"The constraint {name!r} between {first!r} and {second!r} closes a loop; only serial arms can be "
            f"described. Remove it; a counterbalance can be an entry of [springs], a parallel rod a drive.coupling."
        )


def _check_joints(chain: Chain, name: str, joints: tuple[int, ...]) -> None:
    tied = [chain.names[chain.joints.index(j)] for j in joints if j in chain.joints]
    if tied:
        raise FFGymError(
            f"The constraint {name!r} (equality, mimic) ties joint {' to '.join(map(repr, tied))} to another; the "
            f"joints of an arm move on their own. Remove it, or leave the joint out of joints = [...], which holds it."
        )


def _tendon_joints(model: mujoco.MjModel, tendon: int) -> tuple[int, ...]:
    """Joints in a tendon's sum; a spatial tendon has none."""
    if tendon < 0:
        return ()
    start = model.tendon_adr[tendon]
    wraps = range(start, start + model.tendon_num[tendon])
    return tuple(int(model.wrap_objid[w]) for w in wraps if model.wrap_type[w] == mujoco.mjtWrap.mjWRAP_JOINT.value)
