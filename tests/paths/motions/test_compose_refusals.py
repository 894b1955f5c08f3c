"""Moves that cannot be made are one error with their place."""

import numpy as np
import pytest
from programs import POINT, line, pose
from reference_checks import check_reference

from ffgym.core.errors import FFGymError
from ffgym.paths.motions import compose
from ffgym.paths.moves import MoveArc, MoveJoint, MoveSpline, Speed, Wait, Zone
from ffgym.robot import RigidArm

FAR = line(5, 0, 0, where="prog:7", label="far")


@pytest.mark.parametrize(
    ("moves", "message"),
    [
        ([line(0, 0, 0), FAR], "prog:7: .*cannot be reached|prog:7: .*not reachable"),
        ([line(0, 0, 0), line(0.1, 0, 0, zone=0.01), FAR], "prog:7: .*reach"),
        ([FAR], "prog:7: .*reach"),
        ([MoveJoint(to=np.zeros(5), where="prog:7")], "prog:7: 5 joint positions for the 6 joints"),
        ([MoveJoint(to=np.full(6, 9.0), where="prog:7")], "prog:7: Joint .* = 9 rad is out of range"),
        ([Wait(duration=1.0, where="prog:7")], "prog:7: An arc or a wait cannot come first"),
        (
            [
                line(0, 0, 0),
                MoveArc(via=POINT + np.array([0.1, 0, 0]), to=pose(0.2, 0, 0), speed=Speed(tcp=1), where="prog:7"),
            ],
            "prog:7: The points .* lie on a line",
        ),
        (
            [
                line(0, 0, 0),
                MoveArc(via=POINT + np.array([0.1, 0.1, 0]), to=pose(0, 0, 0), speed=Speed(tcp=1), where="prog:7"),
            ],
            "prog:7: The points .* coincide, .* make a circle of two arcs",
        ),
        (
            [
                line(0, 0, 0),
                MoveSpline(through=(pose(1e-9, 0, 0), pose(1e-9, 0, 0)), speed=Speed(tcp=1), where="prog:7"),
            ],
            "prog:7: The points of a spline must be",
        ),
        ([], "has no moves"),
    ],
)
def test_a_move_that_cannot_be_made_is_one_error_with_its_place(arm, moves, message):
    with pytest.raises(FFGymError, match=message) as caught:
        compose(arm, moves)
    assert "\n" not in str(caught.value)


def test_robots_without_a_tool_move_their_joints_only(one_axis):
    arm = RigidArm(one_axis)
    there, back = MoveJoint(to=np.array([0.5])), MoveJoint(to=np.zeros(1))
    check_reference(compose(arm, [back, there, back]).reference)
    with pytest.raises(FFGymError, match="has no tool"):
        compose(arm, [line(0.1, 0, 0)], start=np.zeros(1))
    with pytest.raises(FFGymError, match="zone is a distance of the TCP"):
        compose(arm, [back, MoveJoint(to=np.array([0.5]), zone=Zone(radius=0.1)), MoveJoint(to=np.ones(1))])
