"""Moves as references: continuous, within every limit, at the programmed speed, with what was asked for named."""

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from programs import DT, POINT, line, pose, programs
from reference_checks import check_reference, rows_of, tool_speed
from scipy.spatial.transform import Rotation

from ffgym.core.errors import FFGymError
from ffgym.paths.limits import MotionLimits
from ffgym.paths.motions import compose
from ffgym.paths.moves import Move, MoveArc, MoveJoint, MoveJointSpline, MoveLinear, MoveSpline, Pose, Speed, Wait, Zone
from ffgym.robot import RigidArm, load_robot, solve_pose


def check_program(arm, moves):
    """A program that can be carried out is, within all limits; what cannot be is one clear error."""
    moves = [_labelled(move, i) for i, move in enumerate(moves)]
    reference, refusal = attempt(arm, moves)
    if reference is None:
        assert re.fullmatch(r"prog:\d+: .*", refusal)
        return
    check_reference(reference)
    speed, turning = tool_speed(arm, reference)
    programmed = {m.label: m.speed for m in moves if not isinstance(m, Wait) and m.speed}
    fastest = max((s.tcp for s in programmed.values()), default=np.inf)
    if all(isinstance(m, Wait) or m.speed for m in moves[1:]):
        assert speed.max(initial=0) <= fastest * (1 + 1e-6)
        assert turning.max(initial=0) <= max((s.turn for s in programmed.values()), default=np.inf)
    where = {phase.label: phase for phase in reference.phases}
    tcp = arm.tcp_position(reference.q)
    for before, move in pairwise(moves):
        if isinstance(move, MoveLinear | MoveArc) and move.zone.stops and move.label in where:
            phase = where[move.label]
            row = min(round(phase.end / DT), len(tcp) - 1)
            np.testing.assert_allclose(tcp[row], move.to.position, atol=1e-6)
            np.testing.assert_allclose(reference.dq[row], 0, atol=1e-6)
        assert before.label != move.label


def attempt(arm, moves):
    """The reference of a program, or why there is none."""
    try:
        return compose(arm, moves).reference, ""
    except FFGymError as error:
        return None, str(error)


def _labelled(move: Move, i: int) -> Move:
    return replace(move, label=f"p{i}", where=f"prog:{i}")


@settings(max_examples=6)
@given(data=programs(np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])))
def test_every_program_gives_a_continuous_reference_within_all_limits(arm, data):
    check_program(arm, data)


@pytest.mark.slow
@settings(max_examples=300)
@given(data=programs(np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])))
def test_a_great_many_programs_give_continuous_references_within_all_limits(arm, data):
    check_program(arm, data)


@pytest.mark.parametrize("speed", [0.01, 0.04, 0.1])
def test_a_circle_runs_at_exactly_its_speed_once_it_has_it(arm, speed):
    centre, r = POINT, 0.003
    points = [centre + r * np.array([np.cos(a), np.sin(a), 0]) for a in np.arange(8) * np.pi / 2]
    start = MoveLinear(to=pose(*(points[0] - POINT)), speed=Speed(tcp=speed))
    arcs = [
        MoveArc(via=points[i], to=pose(*(points[i + 1] - POINT)), speed=Speed(tcp=speed), zone=Zone(radius=1e-3))
        for i in (1, 3, 5)
    ]
    reference = compose(arm, [start, *arcs]).reference
    tcp = tool_speed(arm, reference)[0]
    circle = next(p for p in reference.phases if p.kind == "circle")
    steady = rows_of(reference, circle) & (reference.t > 0.5 * (circle.start + circle.end))
    np.testing.assert_allclose(tcp[steady], speed, rtol=1e-9)
    away = np.linalg.norm(arm.tcp_position(reference.q) - centre, axis=1)
    np.testing.assert_allclose(away, r, atol=1e-9)


def test_the_fastest_circle_of_the_thesis_is_within_the_default_limits_everywhere(arm, irb4600):
    for point in irb4600.work_area.positions.values():
        corners = [point + 0.001 * np.array([np.cos(a), np.sin(a), 0]) for a in np.arange(20) * np.pi / 2]
        arcs = [
            MoveArc(via=a, to=pose(*(b - POINT)), speed=Speed(tcp=0.1), zone=Zone(radius=1e-3))
            for a, b in zip(corners[1::2], corners[2::2], strict=False)
        ]
        reference = compose(arm, [MoveLinear(to=pose(*(corners[0] - POINT)), speed=Speed(tcp=0.1)), *arcs]).reference
        assert tool_speed(arm, reference)[0].max() == pytest.approx(0.1, rel=1e-9)


def test_a_line_alone_takes_the_time_of_its_profile(arm):
    reference = compose(arm, [line(0, 0, 0), line(0.1, 0, 0)], dwell=0.0).reference
    limits = MotionLimits()
    wanted = 0.1 / 0.1 + 2 * np.sqrt(0.1 / limits.jerk)  # the largest acceleration is not reached
    assert wanted <= reference.duration < wanted + DT
    speed = tool_speed(arm, reference)[0]
    assert np.sum(speed > 0.1 * (1 - 1e-9)) * DT > 0.85


def test_corners_are_rounded_within_their_zones_at_speed_and_fine_points_are_rests(arm):
    square = [(0, 0, 0), (0.1, 0, 0), (0.1, 0.1, 0), (0, 0.1, 0)]
    motion = compose(arm, [line(*p, zone=0.02) for p in square] + [line(0, 0, 0)])
    reference = motion.reference
    assert motion.notes == ()
    tcp, speed = arm.tcp_position(reference.q) - POINT, tool_speed(arm, reference)[0]
    inside = (reference.t > 0.6) & (reference.t < reference.t[-1] - 0.6)
    np.testing.assert_allclose(speed[inside], 0.1, rtol=1e-9)
    for corner in square[1:]:
        nearest = np.linalg.norm(tcp - corner, axis=1).min()
        assert 0 < nearest < 0.02
    stopped = compose(arm, [line(*p) for p in square]).reference
    for phase in stopped.phases[:-1]:
        row = round(phase.end / DT)
        np.testing.assert_allclose(stopped.dq[row], 0, atol=1e-12)


def test_a_rounded_corner_turns_the_tool_smoothly(arm, irb4600):
    home = irb4600.work_area.tool_rotation
    turns = [Rotation.from_rotvec(v).as_matrix() @ home for v in ([0.3, 0, 0], [0, 0.4, 0.1])]
    moves = [
        line(0, 0, 0),
        MoveLinear(to=pose(0.1, 0, 0, turned=turns[0]), speed=Speed(tcp=0.1), zone=Zone(radius=0.03)),
        MoveLinear(to=pose(0.1, 0.1, 0, turned=turns[1]), speed=Speed(tcp=0.1)),
    ]
    reference = compose(arm, moves).reference
    check_reference(reference)
    np.testing.assert_allclose(arm.tcp_pose(reference.q[-1:])[1][0], turns[1], atol=1e-9)


def test_turning_on_the_spot_takes_the_turning_speed(arm, irb4600):
    turned = Rotation.from_rotvec([0.0, 0, 1.0]).as_matrix() @ irb4600.work_area.tool_rotation
    slow = MoveLinear(to=pose(0, 0, 0, turned=turned), speed=Speed(tcp=1.0, turn=0.5))
    reference = compose(arm, [line(0, 0, 0), slow]).reference
    check_reference(reference)
    speed, turning = tool_speed(arm, reference)
    assert speed.max() < 1e-8
    assert turning.max() == pytest.approx(0.49, rel=1e-6)
    np.testing.assert_allclose(arm.tcp_pose(reference.q[-1:])[1][0], turned, atol=1e-9)


def test_joint_moves_are_straight_in_joint_space_and_round_their_corners_near_the_target(arm, corners):
    a, b = corners["p1"], corners["p2"]
    reference = compose(arm, [MoveJoint(to=a), MoveJoint(to=b)]).reference
    check_reference(reference)
    share = (reference.q - a) @ (b - a) / ((b - a) @ (b - a))
    np.testing.assert_allclose(reference.q, a + np.outer(share, b - a), atol=1e-9)
    middle = solve_pose(arm, POINT + np.array([0.0, 0.2, 0.2]), arm.robot.work_area.tool_rotation, a)
    blended = compose(arm, [MoveJoint(to=a), MoveJoint(to=middle, zone=Zone(radius=0.05)), MoveJoint(to=b)]).reference
    check_reference(blended)
    away = np.linalg.norm(arm.tcp_position(blended.q) - arm.tcp_position(middle[None]), axis=1)
    assert 1e-3 < away.min() < 0.05
    small = [MoveJoint(to=a), MoveJoint(to=middle, zone=Zone(radius=0.001)), MoveJoint(to=b)]
    nearest = arm.tcp_position(compose(arm, small).reference.q) - arm.tcp_position(middle[None])
    assert 1e-6 < np.linalg.norm(nearest, axis=1).min() < 0.001
    assert np.abs(blended.dq[np.argmin(away)]).max() > 0.1


def test_a_programmed_speed_holds_for_joint_moves_too(arm, corners):
    reference = compose(arm, [MoveJoint(to=corners["p1"]), MoveJoint(to=corners["p3"], speed=Speed(tcp=0.2))]).reference
    speed = tool_speed(arm, reference)[0]
    assert 0.15 < speed.max() <= 0.2


def test_a_spline_passes_its_points_and_stops_at_its_ends(arm):
    through = [pose(0.05, 0, 0.05), pose(0.1, 0.1, 0), pose(0, 0.1, 0)]
    reference = compose(arm, [line(0, 0, 0), MoveSpline(through=tuple(through), speed=Speed(tcp=0.1))]).reference
    check_reference(reference)
    tcp = arm.tcp_position(reference.q)
    for point in through:
        assert np.linalg.norm(tcp - point.position, axis=1).min() < 0.1 * DT
    np.testing.assert_allclose(tcp[-1], through[-1].position, atol=1e-9)


def test_a_closed_spline_comes_back(arm):
    through = (pose(0.1, 0, 0), pose(0.1, 0.1, 0.02), pose(0, 0.1, 0), pose(0, 0, 0))
    spline = MoveSpline(through=through, speed=Speed(tcp=0.1), closed=True)
    reference = compose(arm, [line(0, 0, 0), spline]).reference
    np.testing.assert_allclose(reference.q[-1], reference.q[0], atol=1e-8)


def test_a_joint_spline_passes_its_rows(one_axis, arm, corners):
    rows = np.stack([corners[name] for name in ("p1", "p2", "p3")])
    reference = compose(arm, [MoveJointSpline(through=rows)]).reference
    check_reference(reference)
    for row in rows:
        assert np.abs(reference.q - row).max(axis=1).min() < 0.02


@pytest.mark.parametrize("j5", [0.006, 0.01])
@pytest.mark.parametrize("way", [0.1, 0.3])
def test_the_wrist_may_turn_far_within_millimetres_if_it_stays_on_its_branch(arm, irb4600, j5, way):
    """Beside the singularity of the wrist, j5 = 0, joints turn by more than a jump between points 5 mm apart."""
    start = irb4600.work_area.home + np.array([0, 0, 0, 0.3, 0, 0])
    start[4] = j5
    position, rotation = (part[0] for part in arm.tcp_pose(start[None]))
    there = Pose(position=position + np.array([0, way, 0]), rotation=rotation)
    reference = compose(arm, [MoveJoint(to=start), MoveLinear(to=there, speed=Speed(tcp=0.2))]).reference
    check_reference(reference)
    assert np.abs(reference.dq / irb4600.kinematics.max_speed).max() > 0.9  # as fast as the wrist may


def test_a_path_through_a_singularity_is_refused(arm, irb4600):
    start = irb4600.work_area.home.copy()
    start[4] = 0.0
    position, rotation = (part[0] for part in arm.tcp_pose(start[None]))
    there = Pose(position=position + np.array([0, 0.1, 0]), rotation=rotation)
    moves = [MoveJoint(to=start), MoveLinear(to=there, speed=Speed(tcp=0.2), where="prog:7")]
    assert re.match(r"prog:7: The path (jumps|comes too near a singularity)", attempt(arm, moves)[1])


@pytest.mark.parametrize("speed", [0.05, 0.1, 0.2])
def test_bends_of_a_tenth_of_a_millimetre_behind_a_long_way_are_within_the_limits(two_link_arm, speed):
    """A spline is examined on each of its pieces: one grid over the whole found these bends by chance."""
    ends = [(-792.94858, 2624.08824), (-792.91891, 2624.02909), (-792.84513, 2624.12727), (-792.73732, 2623.9772)]
    through = tuple(Pose(position=np.array([x, 0, z]) * 1e-3) for x, z in ends)
    start = MoveJoint(to=np.array([1.6218399, 1.70115448]))
    check_reference(compose(two_link_arm, [start, MoveSpline(through=through, speed=Speed(tcp=speed))]).reference)


def test_planar_arms_keep_their_orientation_free(two_link_arm):
    target = two_link_arm.tcp_position(np.array([[0.3, 0.5]]))[0]
    start = two_link_arm.tcp_position(np.array([[0.2, 0.8]]))[0]
    moves = [MoveLinear(to=Pose(position=p), speed=Speed(tcp=0.2)) for p in (start, target)]
    reference = compose(two_link_arm, moves).reference
    np.testing.assert_allclose(two_link_arm.tcp_position(reference.q[-1:])[0], target, atol=1e-8)


@pytest.fixture(scope="module")
def two_link_arm():
    return RigidArm(load_robot("two_link"))


def test_limits_slow_a_motion_down(arm):
    moves = [line(0, 0, 0), line(0.1, 0, 0, speed=0.5)]
    plain = compose(arm, moves).reference
    for limits in (
        MotionLimits(acceleration=0.5),
        MotionLimits(jerk=5.0),
        MotionLimits(joint_speed=0.05),
        MotionLimits(joint_acceleration=np.full(6, 0.3)),
        MotionLimits(joint_jerk=np.full(6, 5.0)),
    ):
        slow = compose(arm, moves, limits=limits).reference
        assert slow.duration > plain.duration
        check_reference(slow, limits)
