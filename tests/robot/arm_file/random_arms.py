"""Random serial chains, written as MJCF and as URDF."""

from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation


@dataclass(frozen=True, kw_only=True)
class Body:
    """A body with its joint (or None), as a file may give it; angles [rad], lengths [m]."""

    joint: str | None
    position: tuple
    rpy: tuple
    anchor: tuple
    axis: tuple
    ref: float
    mass: float
    com: tuple
    inertia_rpy: tuple
    moments: tuple
    has_frame: bool


lengths = st.floats(-1, 1, allow_subnormal=False).map(lambda x: round(x, 6))
angles = st.floats(-3.1, 3.1, allow_subnormal=False).map(lambda x: round(x, 6))
vectors, turns = st.tuples(lengths, lengths, lengths), st.tuples(angles, angles, angles)
axes = vectors.filter(lambda axis: np.linalg.norm(axis) > 0.05)
squares = st.floats(0.01, 1).map(lambda x: round(x, 6))
moments = st.tuples(squares, squares, squares).map(lambda s: (s[1] + s[2], s[2] + s[0], s[0] + s[1]))


def bodies(joint):
    """Strategy for a body with this type of joint."""
    return st.builds(
        Body, joint=joint, position=vectors, rpy=turns, anchor=vectors, axis=axes, ref=angles,
        mass=st.floats(0.1, 20), com=vectors, inertia_rpy=turns, moments=moments, has_frame=st.booleans(),
    )  # fmt: skip


arms = st.lists(bodies(st.sampled_from(["hinge", "hinge", "slide", None])), min_size=1, max_size=7).filter(
    lambda arm: any(body.joint for body in arm)
)
"""Chains of bodies, some of them welded; at least one joint."""


def mjcf(arm):
    """MJCF of a chain of bodies, in radians, with joints anywhere and any reference."""
    head = "<mujoco><compiler angle='radian' eulerseq='XYZ'/><worldbody>"
    return head + "".join(_mjcf_body(i, body) for i, body in enumerate(arm)) + "</body>" * len(arm) + _TAIL


_TAIL = "</worldbody></mujoco>"


def _mjcf_body(i, body):
    joint = (
        f"<joint name='j{i}' type='{body.joint}' axis='{_text(body.axis)}' pos='{_text(body.anchor)}' "
        f"ref='{body.ref!r}' range='-3 3'/>"
    )
    site = f"<site name='s{i}' pos='{_text(body.com)}' euler='{_text(body.inertia_rpy)}'/>"
    return (
        f"<body name='b{i}' pos='{_text(body.position)}' euler='{_text(body.rpy)}'>"
        f"<inertial mass='{body.mass!r}' pos='{_text(body.com)}' euler='{_text(body.inertia_rpy)}' "
        f"diaginertia='{_text(body.moments)}'/>{joint if body.joint else ''}{site if body.has_frame else ''}"
    )


def urdf(arm):
    """URDF of a chain of links; joints are at the origins of links, and zero where the file draws them."""
    kinds = {"hinge": "revolute", "slide": "prismatic", None: "fixed"}
    parts = ["<robot name='random'><link name='root'/>"]
    for i, body in enumerate(arm):
        parent = "root" if i == 0 else f"b{i - 1}"
        tensor = _turned(body.inertia_rpy, body.moments)
        values = zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), tensor, strict=True)
        parts += [
            f"<link name='b{i}'><inertial><origin xyz='{_text(body.com)}' rpy='0 0 0'/><mass value='{body.mass!r}'/>",
            f"<inertia {' '.join(f'{name}={str(float(x))!r}' for name, x in values)}/></inertial></link>",
            f"<joint name='j{i}' type='{kinds[body.joint]}'><parent link='{parent}'/><child link='b{i}'/>",
            f"<origin xyz='{_text(body.position)}' rpy='{_text(body.rpy)}'/><axis xyz='{_text(body.axis)}'/>",
            "<limit lower='-3' upper='3' effort='1' velocity='2'/></joint>",
        ]
    return "".join(parts) + "</robot>"


def _turned(rpy, moments):
    """Principal moments in turned axes: xx, yy, zz, xy, xz, yz."""
    turn = Rotation.from_euler("xyz", rpy).as_matrix()
    return (turn @ np.diag(moments) @ turn.T)[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]


def _text(values):
    return " ".join(map(repr, values))
