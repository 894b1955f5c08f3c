"""The thesis' circle program in RAPID gives the path of the built-in circle test with the leads of the thesis."""

from importlib import resources

import numpy as np
import pytest

from ffgym.paths import RADII, circle_test
from ffgym.paths.motions import Motion, compose, load_motion
from ffgym.paths.rapid import on_branches, parse_program

SPEED = 0.010
"""Programmed speed [m/s]."""
CLOSE = 1e-9
"""How near two paths must be to be the same [m]: what inverse kinematics leave is ten times less."""

EXAMPLE = resources.files("ffgym.paths.rapid") / "examples" / "thesis_circles.mod"


@pytest.fixture(scope="module")
def motion(arm) -> Motion:
    with resources.as_file(EXAMPLE) as path:
        return load_motion(arm, path)


@pytest.fixture(scope="module")
def built_in(irb4600):
    return circle_test(irb4600.position("p1"), SPEED, lead="half_circle")


def swept(points, phase, t, centre):
    """Distance from an axis [m] and angle about it [rad], unwrapped, on the samples of a phase."""
    rows = (t > phase.start) & (t < phase.end)
    arms = points[rows] - centre
    assert np.abs(arms[:, 2]).max() < CLOSE
    return np.linalg.norm(arms, axis=1), np.unwrap(np.arctan2(arms[:, 1], arms[:, 0]))


def legs(phases):
    """Lead-in, circle and lead-out of each circle: all that is no rest."""
    moving = [phase for phase in phases if phase.kind != "standstill"]
    return list(zip(moving[::3], moving[1::3], moving[2::3], strict=True))


def test_it_runs_on_the_robot_as_it_is_without_a_note(arm, motion):
    assert motion.notes == ()
    assert motion.reference.robot is arm.robot


def test_both_run_through_the_same_rests_leads_and_circles_in_the_same_order(motion, built_in):
    for phases in (motion.reference.phases, built_in.phases):
        assert [p.kind == "standstill" for p in phases] == [True, *[False, False, False, True] * 3]
        assert [p.kind for p in phases].count("circle") == 3
        rests = [p.end - p.start for p in phases if p.kind == "standstill"]
        np.testing.assert_allclose(rests, 0.3, atol=1e-9)


def test_each_path_lies_on_the_other_on_leads_and_circles(arm, irb4600, motion, built_in):
    """Every leg is an arc about the same axis with the same radius, from the same angle to the same angle."""
    reference = motion.reference
    tcp, centre = arm.tcp_position(reference.q), irb4600.position("p1")
    for radius, ours, theirs in zip(RADII, legs(reference.phases), legs(built_in.phases), strict=True):
        middles = [np.array([0, -radius / 2, 0]), np.zeros(3), np.array([0, -radius / 2, 0])]
        for middle, one, other in zip(middles, ours, theirs, strict=True):
            size = radius if not middle.any() else radius / 2
            r1, a1 = swept(tcp, one, reference.t, centre + middle)
            r2, a2 = swept(built_in.position, other, built_in.t, centre + middle)
            np.testing.assert_allclose(r1, size, rtol=0, atol=CLOSE)
            np.testing.assert_allclose(r2, size, rtol=0, atol=1e-12)
            step = 1.01 * SPEED * reference.t[1] / size  # the ends lie between two samples
            assert np.all(np.diff(a1) * np.sign(a1[-1] - a1[0]) >= -CLOSE / size)
            turns = 2 * np.pi * np.round((a2[0] - a1[0]) / (2 * np.pi))
            np.testing.assert_allclose(a2[[0, -1]] - turns, a1[[0, -1]], atol=step)
            np.testing.assert_allclose([np.ptp(a1), np.ptp(a2)], 2 * np.pi if size == radius else np.pi, atol=2 * step)


def test_the_tool_rests_in_the_centre_between_circles(arm, irb4600, motion):
    reference = motion.reference
    tcp = arm.tcp_position(reference.q)
    for phase in reference.phases:
        if phase.kind == "standstill":
            rows = (reference.t >= phase.start) & (reference.t <= phase.end)
            np.testing.assert_allclose(tcp[rows], np.tile(irb4600.position("p1"), (rows.sum(), 1)), atol=CLOSE)
            np.testing.assert_array_equal(reference.dq[rows], 0)


@pytest.mark.parametrize(("speed", "zone"), [(10, 0.003), (40, 0.01)])
def test_on_the_circles_the_speed_is_the_programmed_one(arm, speed, zone):
    """At 40 mm/s the leads join over 0.01 mm, or the joints would have to jerk more than they may."""
    text = EXAMPLE.read_text(encoding="utf-8")
    text = text.replace("[10, 500", f"[{speed}, 500").replace("[FALSE, 0.003", f"[FALSE, {zone}")
    execution = parse_program(text).execute(arm.robot)
    reference = compose(arm, on_branches(arm, execution)[0]).reference
    rate = np.linalg.norm(np.einsum("tij,tj->ti", arm.jacobian(reference.q), reference.dq)[:, :3], axis=1)
    circles = [phase for phase in reference.phases if phase.kind == "circle"]
    for i, phase in enumerate(circles):
        rows = (reference.t >= phase.start) & (reference.t <= phase.end)
        if speed == 40 and i == 0:
            assert rate[rows].min() > 0.035  # it slows down where the smallest circle is joined
            rows = (reference.t >= phase.start + 0.05) & (reference.t <= phase.end - 0.05)
        np.testing.assert_allclose(rate[rows], speed * 1e-3, rtol=1e-9)


def test_the_orientation_is_that_of_the_work_area(arm, irb4600, motion):
    _, rotation = arm.tcp_pose(motion.reference.q[::50])
    np.testing.assert_allclose(rotation, np.broadcast_to(irb4600.work_area.tool_rotation, rotation.shape), atol=1e-9)
