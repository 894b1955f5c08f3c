"""Points of a path are few, and lines between them stay near the plan."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ffgym.core.errors import FFGymError
from ffgym.deployment import choose_points
from ffgym.deployment.programs.deviation import measure_deviation
from ffgym.deployment.programs.points import ZONE, _corners, count_digits, round_numbers, tool_levers

tolerances = st.floats(np.log(3e-6), np.log(3e-4)).map(lambda x: float(np.exp(x)))


def distance_by_force(arm, plan, points):
    """Largest distance of a set-point's TCP from the TCPs of many places on the lines around its time [m]."""
    share = np.linspace(0, 1, 1501)[:, None]
    paths = [arm.tcp_position(a + share * (b - a)) for a, b in zip(points.q, points.q[1:], strict=False)]
    farthest = 0.0
    for t, tcp in list(zip(plan.t, arm.tcp_position(plan.setpoints), strict=True))[::9]:
        k = min(int(np.searchsorted(points.t, t, side="right")) - 1, len(paths) - 1)
        near = np.concatenate(paths[max(k - 1, 0) : k + 2])
        farthest = max(farthest, float(np.linalg.norm(near - tcp, axis=1).min()))
    return farthest


@settings(max_examples=5, suppress_health_check=list(HealthCheck), deadline=None)
@given(tolerances)
def test_lines_between_points_stay_within_half_of_the_tolerance(arm, plan, tolerance):
    points = choose_points(plan, arm, tolerance=tolerance)
    assert distance_by_force(arm, plan, points) <= 0.5 * tolerance + 1e-6
    measured = measure_deviation(arm, plan.setpoints, plan.t, points.q, 1.0)
    assert measured.distance <= 0.5 * tolerance


def test_more_tolerance_takes_fewer_points(arm, plan):
    counts = [len(choose_points(plan, arm, tolerance=x).t) for x in (3e-6, 1e-5, 1e-4)]
    assert counts[0] > counts[1] > counts[2]
    assert counts[1] < len(plan.program) / 4


def test_points_are_set_points_of_the_plan_in_its_order(arm, plan):
    points = choose_points(plan, arm)
    rows = np.round(points.t / plan.dt).astype(int)
    assert rows[0] == 0
    assert rows[-1] == len(plan.program) - 1
    assert np.all(np.diff(rows) > 0)
    np.testing.assert_allclose(points.q, plan.setpoints[rows], rtol=0, atol=1e-6)
    np.testing.assert_allclose(points.lengths[1:], np.linalg.norm(np.diff(arm.tcp_position(points.q), axis=0), axis=1))


def test_lines_keep_the_time_of_the_plan_to_10_ms(arm, plan):
    """One joint alone, faster and slower: all lines have no deviation, and still the speed must be the plan's."""
    t = np.arange(751) * plan.dt
    swing = plan.setpoints[0] + 0.02 * np.outer(1 - np.cos(np.pi * t), np.eye(6)[0])
    still = replace(plan, program=swing, correction=0 * swing, torque=0 * swing)
    points = choose_points(still, arm, tolerance=1e-3)
    assert len(points.t) < len(t) / 4
    between = np.interp(t, points.t, points.q[:, 0])
    fastest = np.abs(np.gradient(swing[:, 0], t)).max()
    assert np.abs(between - swing[:, 0]).max() <= 0.012 * fastest


def test_a_corner_is_passed_as_a_parabola_does():
    """Legs of 10 mm at a right angle: half of the way from the corner to the middle between the ends of its zone."""
    passed = _corners(np.array([[0.0, 0, 0], [0.01, 0, 0], [0.01, 0.01, 0], [0.01, 0.02, 0]]))
    np.testing.assert_allclose(passed, [0, ZONE / np.sqrt(8), 0, 0], atol=1e-12)


def test_a_rest_is_one_wait_once_the_correction_has_settled(arm, plan):
    still = replace(plan, correction=np.zeros_like(plan.correction))
    points = choose_points(still, arm)
    (between,) = [k for k in np.flatnonzero(points.rests) if 0 < k < len(points.t) - 2]
    assert points.t[between + 1] - points.t[between] == pytest.approx(0.6, abs=0.02)
    assert points.lengths[between + 1] == 0


@settings(max_examples=10, suppress_health_check=list(HealthCheck), deadline=None)
@given(tolerances)
def test_rounding_moves_the_tool_by_a_tenth_of_the_tolerance_at_most(arm, plan, tolerance):
    levers = tool_levers(arm, plan.setpoints)
    rounded = round_numbers(plan.setpoints, plan.units, count_digits(levers, plan.units, tolerance))
    away = np.linalg.norm(arm.tcp_position(rounded) - arm.tcp_position(plan.setpoints), axis=1)
    assert away.max() <= 0.1 * tolerance + 3e-7  # numbers of 32 bits


def test_laps_that_lie_beside_each_other_are_told_apart(arm, plan):
    """A path that runs back 20 um beside itself: each set-point is on its own lap."""
    q = plan.setpoints[100:200]
    beside = q + np.array([0, 0, 0, 0, 0, 1e-4])
    path = np.concatenate([q, beside[::-1]])
    assert measure_deviation(arm, path, np.arange(len(path)), path, 1.0).distance < 1e-9
    assert measure_deviation(arm, path, np.arange(len(path)), path[: len(q)], 1.0).distance > 5e-6


def test_what_cannot_be_met_is_one_error(arm, plan):
    with pytest.raises(FFGymError, match=r"Lines over 100 ms leave the plan at .* of the tolerance\). Allow more"):
        choose_points(plan, arm, tolerance=1e-6, period=0.1)
    with pytest.raises(FFGymError, match=r"tolerance = 1\.0 m is out of range"):
        choose_points(plan, arm, tolerance=1.0)
    with pytest.raises(FFGymError, match=r"period = 0.001 s is out of range"):
        choose_points(plan, arm, period=0.001)
    with pytest.raises(FFGymError, match="finer than numbers of 32 bits"):
        count_digits(np.full((1, 3, 6), 1e4), ("rad",) * 6, 1e-6)
