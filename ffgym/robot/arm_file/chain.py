"""Which joints of a model are the serial arm, which bodies move with each of them, and that nothing ties them."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.types import IntArray
from ffgym.recordings.header import JOINT_NAME

BASE, ELSEWHERE = -1, -2
"""Owners of bodies that no joint of the chain moves: part of the fixed base, or not of the arm at all."""

TYPES = {mujoco.mjtJoint.mjJNT_HINGE.value: "hinge", mujoco.mjtJoint.mjJNT_SLIDE.value: "slide"}
"""Joints that a serial arm may have, as MuJoCo and descriptions call them."""

HELD = (
    "Name the joints that move from the base outwards, --joints of ffgym robot new or joints = [...] in [robot]; all "
    "others are held at zero."
)
"""The way out of files with more than one chain of hinges and sliding joints."""
_SHOWN = 4
"""Branches that an error lists before it counts the rest."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Chain:
    """A serial arm within a model."""

    joints: tuple[int, ...]
    """Its joints in the model, from the base outwards."""
    names: tuple[str, ...]
    """Their names."""
    types: tuple[str, ...]
    """'hinge' or 'slide', one per joint."""
    owner: IntArray
    """For each body of the model the joint (0 ... N-1) that it is behind, BASE or ELSEWHERE."""


def choose_chain(model: mujoco.MjModel, wanted: Sequence[str] | None) -> Chain:
    """The chain of the `wanted` joints, or of all there are.

    Raises:
        FFGymError: if they are no serial chain of hinges and sliding joints; the message lists the choices.
    """
    names = [model.joint(j).name or f"joint{j + 1}" for j in range(model.njnt)]
    if not names:
        raise FFGymError("It has no joints, so nothing can move. An arm needs at least one hinge or sliding joint.")
    if wanted is None:
        joints = list(range(model.njnt))
    else:
        joints = [names.index(check_choice("joint", name, names)) for name in wanted]
    _check_types(model, joints, names)
    before = _before(model, joints)
    if wanted is None:
        _check_single(joints, before, names)
    _check_order(joints, before, names)
    _check_names([names[j] for j in joints])
    _check_links(model, joints, names)
    return Chain(
        joints=tuple(joints),
        names=tuple(names[j] for j in joints),
        types=tuple(TYPES[model.jnt_type[j]] for j in joints),
        owner=_owners(model, joints),
    )


def _before(model: mujoco.MjModel, joints: Sequence[int]) -> dict[int, int | None]:
    """For each joint the one of `joints` that moves it, None for the first."""
    last: list[int | None] = [None] * model.nbody  # the last joint of the chain that moves each body
    before: dict[int, int | None] = {}
    for body in range(1, model.nbody):
        moving = last[model.body_parentid[body]]
        for j in range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body]):
            if j in joints:
                before[j] = moving
                moving = j
        last[body] = moving
    return before


def _owners(model: mujoco.MjModel, joints: Sequence[int]) -> IntArray:
    first = int(model.jnt_bodyid[joints[0]])
    own = {int(model.jnt_bodyid[j]): k for k, j in enumerate(joints)}
    root = _top(model, first)
    owner = np.full(model.nbody, ELSEWHERE)
    for body in range(1, model.nbody):
        inherited = BASE if body == root else owner[model.body_parentid[body]]
        owner[body] = own.get(body, inherited)
    return owner


def _top(model: mujoco.MjModel, body: int) -> int:
    """The ancestor of a body that stands in the world."""
    while model.body_parentid[body] != 0:
        body = int(model.body_parentid[body])
    return body


def _check_types(model: mujoco.MjModel, joints: Sequence[int], names: Sequence[str]) -> None:
    for j in joints:
        if model.jnt_type[j] not in TYPES:
            kind = mujoco.mjtJoint(model.jnt_type[j]).name.removeprefix("mjJNT_").lower()
            raise FFGymError(f"Joint {names[j]!r} is a {kind} joint; an arm has hinges and sliding joints. {HELD}")


def _check_single(joints: Sequence[int], before: dict[int, int | None], names: Sequence[str]) -> None:
    """All joints of a file must follow one another, or the user must choose."""
    chains = [_chain_to(leaf, before) for leaf in joints if leaf not in before.values()]
    if len(chains) == 1:
        return
    common = [row[0] for row in zip(*chains, strict=False) if len(set(row)) == 1]
    branches = [str([names[j] for j in chain[len(common) :]]) for chain in chains]
    shown = " or ".join(branches[:_SHOWN]) + (f" or {len(branches) - _SHOWN} more" if branches[_SHOWN:] else "")
    where = f"It branches after {names[common[-1]]!r}" if common else "It has several chains"
    raise FFGymError(f"{where}: {shown}. {HELD} For example joints = {[names[j] for j in common or chains[0]]}.")


def _chain_to(joint: int, before: dict[int, int | None]) -> list[int]:
    """All joints from the base to `joint`."""
    chain = [joint]
    while (j := before[chain[0]]) is not None:
        chain.insert(0, j)
    return chain


def _check_order(joints: Sequence[int], before: dict[int, int | None], names: Sequence[str]) -> None:
    if len(set(joints)) < len(joints) or not joints:
        raise FFGymError(f"joints = {[names[j] for j in joints]} must name at least one joint, and each once.")
    if before[joints[0]] is not None:
        raise FFGymError(
            f"joints = {[names[j] for j in joints]} must go from the base outwards, but {names[joints[0]]!r} is "
            f"moved by {names[before[joints[0]] or 0]!r}."
        )
    for j, k in pairwise(joints):
        if before[k] != j:
            raise FFGymError(
                f"joints = {[names[i] for i in joints]} must be one chain from the base outwards, but {names[k]!r} "
                f"does not follow {names[j]!r}."
            )


def _check_names(names: Sequence[str]) -> None:
    for name in names:
        if not JOINT_NAME.fullmatch(name):
            raise FFGymError(
                f"Joint {name!r} cannot name columns of recordings: letters, digits or any of _ / - can. Rename it."
            )


def _check_links(model: mujoco.MjModel, joints: Sequence[int], names: Sequence[str]) -> None:
    for j, k in pairwise(joints):
        if model.jnt_bodyid[j] == model.jnt_bodyid[k]:
            body = model.body(model.jnt_bodyid[j]).name
            raise FFGymError(
                f"Joints {names[j]!r} and {names[k]!r} are both in body {body!r}, so the link between them weighs "
                f"nothing. Put a body with a mass between them, or move only one of them. {HELD}"
            )


_BODIES = (mujoco.mjtEq.mjEQ_CONNECT.value, mujoco.mjtEq.mjEQ_WELD.value)


def check_open(model: mujoco.MjModel, chain: Chain) -> None:
    """Check that no active constraint ties links of the chain to each other, to the world, or joints together.

    Constraints within one link (the linkage of a gripper that is held still) change nothing.
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
