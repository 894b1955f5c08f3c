"""Programs around the first point of the built-in robot's work area, for tests that run them."""

from typing import Any

import numpy as np
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from ffgym.paths.moves import Move, MoveArc, MoveJoint, MoveLinear, MoveSpline, Pose, Speed, Wait, Zone

POINT = np.array([1.3, -0.2, 0.6])
"""First point of the built-in robot's work area [m]."""
DT = 0.004
"""Its control step [s]."""


def pose(*offset: float, turned: np.ndarray | None = None) -> Pose:
    return Pose(position=POINT + np.array(offset), rotation=turned)


def line(*offset: float, speed: float = 0.1, zone: float = 0.0, **more: Any) -> MoveLinear:
    return MoveLinear(to=pose(*offset), speed=Speed(tcp=speed), zone=Zone(radius=zone), **more)


def near(home: np.ndarray) -> st.SearchStrategy[Pose]:
    """Poses within 15 cm and 20 degrees."""
    offset = st.tuples(*[st.floats(-0.15, 0.15)] * 3)
    turn = st.tuples(*[st.floats(-0.2, 0.2)] * 3)
    return st.builds(
        lambda x, r: Pose(position=POINT + np.array(x), rotation=Rotation.from_rotvec(r).as_matrix() @ home),
        offset,
        turn,
    )


def programs(home: np.ndarray) -> st.SearchStrategy[list[Move]]:
    """Lines, arcs, splines and joint moves with any zones and speeds, and waits."""
    speed = st.sampled_from([0.01, 0.1, 0.5, 2.0]).map(lambda v: Speed(tcp=v))
    zone = st.sampled_from([0.0, 0.001, 0.01, 0.1]).map(lambda r: Zone(radius=r))
    target = near(home)
    lines = st.builds(MoveLinear, to=target, speed=speed, zone=zone)
    arcs = st.builds(MoveArc, via=target.map(lambda p: p.position), to=target, speed=speed, zone=zone)
    joints = st.builds(MoveJoint, to=target, speed=st.none() | speed, zone=zone)
    splines = st.builds(MoveSpline, through=st.lists(target, min_size=2, max_size=4).map(tuple), speed=speed, zone=zone)
    waits = st.builds(Wait, duration=st.floats(0.001, 0.1))
    first = st.builds(MoveJoint, to=target)
    return st.lists(st.one_of(lines, lines, arcs, joints, splines, waits), min_size=1, max_size=6).flatmap(
        lambda rest: first.map(lambda one: [one, *rest])
    )
