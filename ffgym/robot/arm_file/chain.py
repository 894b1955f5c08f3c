"""Serial arm within a model: its joints, the bodies that move with each, and a check that no constraint ties them."""

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
    """Serial arm within a model."""

    joints: tuple[int, ...]
    """Its joints in the model, from the base outwards."""
    names: tuple[str, ...]
    """Names of the joints."""
    types: tuple[str, ...]
    """'hinge' or 'slide', one per joint."""
    owner: IntArray
    """Joint of each body of the model (0 ... N-1) in front of it, or BASE or ELSEWHERE."""


def choose_chain(model: mujoco.MjModel, wanted: Sequence[str] | None) -> Chain:
    """Find the chain of the `wanted` joints, or of all joints."""
    names = [model.joint(j).name or f"joint{j + 1}" for j in range(model.njnt)]
    if not names:
        raise FFGymError("It has no joints, so nothing can move. An arm needs at least one hinge or sliding joint.")
    joints = list(range(model.njnt))
    if wanted is not None:
        joints = [names.index(check_choice("joint", name, names)) for name in wanted]
    # serial chain of hinges and slides only, from the base outwards
    for j in joints:
        if model.jnt_type[j] not in TYPES:
            kind = mujoco.mjtJoint(model.jnt_type[j]).name.removeprefix("mjJNT_").lower()
            raise FFGymError(f"Joint {names[j]!r} is a {kind} joint; an arm has hinges and sliding joints. {HELD}")
    before = _before(model, joints)
    if wanted is None:
        _check_single(joints, before, names)
    _check_order(joints, before, names)
    # names must serve as columns of recordings
    for name in (names[j] for j in joints):
        if not JOINT_NAME.fullmatch(name):
            raise FFGymError(
                f"Joint {name!r} cannot name columns of recordings: letters, digits or any of _ / - can. Rename it."
            )
    # a link without mass between two joints has singular dynamics
    for j, k in pairwise(joints):
        if model.jnt_bodyid[j] == model.jnt_bodyid[k]:
            body = model.body(model.jnt_bodyid[j]).name
            raise FFGymError(
                f"Joints {names[j]!r} and {names[k]!r} are both in body {body!r}, so the link between them weighs "
                f"nothing. Put a body with a mass between them, or move only one of them. {HELD}"
            )
    # each body belongs to the last joint of the chain that moves it, or to the base that the first one stands on
    own = {int(model.jnt_bodyid[j]): k for k, j in enumerate(joints)}
    root = int(model.body_rootid[model.jnt_bodyid[joints[0]]])
    owner = np.full(model.nbody, ELSEWHERE)
    for index in range(1, model.nbody):
        owner[index] = own.get(index, BASE if index == root else owner[model.body_parentid[index]])
    return Chain(
        joints=tuple(joints),
        names=tuple(names[j] for j in joints),
        types=tuple(TYPES[model.jnt_type[j]] for j in joints),
        owner=owner,
    )


def _before(model: mujoco.MjModel, joints: Sequence[int]) -> dict[int, int | None]:
    """Find the one of `joints` that moves each joint, None for the first."""
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


def _check_single(joints: Sequence[int], before: dict[int, int | None], names: Sequence[str]) -> None:
    """Check that all joints of a file follow one another; if not, the user must choose."""
    chains = []
    for leaf in joints:
        if leaf not in before.values():
            chains.append([leaf])
            while (j := before[chains[-1][0]]) is not None:
                chains[-1].insert(0, j)
    if len(chains) == 1:
        return
    common = [row[0] for row in zip(*chains, strict=False) if len(set(row)) == 1]
    branches = [str([names[j] for j in chain[len(common) :]]) for chain in chains]
    shown = " or ".join(branches[:_SHOWN]) + (f" or {len(branches) - _SHOWN} more" if branches[_SHOWN:] else "")
    where = f"It branches after {names[common[-1]]!r}" if common else "It has several chains"
    raise FFGymError(f"{where}: {shown}. {HELD} For example joints = {[names[j] for j in common or chains[0]]}.")


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


def check_open(model: mujoco.MjModel, chain: Chain) -> None:
    """Check that no active constraint ties links of the chain to each other, to the world, or joints together.

    Constraints within one link (the linkage of a gripper that is held still) change nothing.
    """
    kinds = mujoco.mjtEq
    for i in np.flatnonzero(model.eq_active0):
        kind, ends = model.eq_type[i], (int(model.eq_obj1id[i]), int(model.eq_obj2id[i]))
        name = model.equality(i).name or f"number {i + 1}"
        # a constraint between bodies of different links closes a loop
        if kind in (kinds.mjEQ_CONNECT.value, kinds.mjEQ_WELD.value):
            sites = model.eq_objtype[i] == mujoco.mjtObj.mjOBJ_SITE.value
            bodies = [int(model.site_bodyid[end]) if sites else end for end in ends]
            if len({max(int(chain.owner[body]), BASE) for body in bodies}) > 1:
                first, second = (model.body(body).name for body in bodies)
                raise FFGymError(
                    f"The constraint {name!r} between {first!r} and {second!r} closes a loop; only serial arms can be "
                    f"described. Remove it; a counterbalance can be an entry of [springs], a parallel rod a "
                    f"drive.coupling."
                )
        # a constraint between joints ties what the model moves freely
        elif kind == kinds.mjEQ_JOINT.value:
            _check_untied(chain, name, ends)
        elif kind == kinds.mjEQ_TENDON.value:
            for tendon in ends:  # joints in its sum; a spatial tendon has none
                start = model.tendon_adr[tendon]
                wraps = range(start, start + model.tendon_num[tendon]) if tendon >= 0 else ()
                joint = mujoco.mjtWrap.mjWRAP_JOINT.value
                _check_untied(chain, name, [int(model.wrap_objid[w]) for w in wraps if model.wrap_type[w] == joint])


def _check_untied(chain: Chain, name: str, joints: Sequence[int]) -> None:
    tied = [chain.names[chain.joints.index(j)] for j in joints if j in chain.joints]
    if tied:
        raise FFGymError(
            f"The constraint {name!r} (equality, mimic) ties joint {' to '.join(map(repr, tied))} to another; the "
            f"joints of an arm move on their own. Remove it, or leave the joint out of joints = [...], which holds it."
        )
