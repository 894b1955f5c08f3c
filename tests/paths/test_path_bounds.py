"""Bounds on path speed: whatever they allow keeps every axis within its limits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from path_samples import magnitudes

from ffgym.core.errors import FFGymError
from ffgym.paths.curves import Arc, Line, Still
from ffgym.paths.limits import (
    CURVE_SHARE,
    JOINT_ACCELERATION,
    JOINT_JERK,
    MARGIN,
    SIMILAR,
    VARIATION,
    Bounds,
    MotionLimits,
    axis_bounds,
    stretches,
    tool_bounds,
)
from ffgym.paths.moves import Speed
from ffgym.paths.route import Leg, even_turn

many = settings(max_examples=100)
slopes = st.lists(st.floats(-50, 50).map(lambda x: round(x, 6)), min_size=2, max_size=2)


def wide(count):
    return Bounds(speed=np.full(count, np.inf), acceleration=np.full(count, np.inf), jerk=np.full(count, np.inf))


@many
@given(
    first=slopes.filter(any),
    second=slopes,
    third=slopes,
    top=st.tuples(magnitudes(0.1, 10), magnitudes(0.1, 100), magnitudes(1, 1e4)),
    part=st.tuples(st.floats(0, 1), st.floats(-1, 1), st.floats(-1, 1)),
)
def test_any_speed_acceleration_and_jerk_within_the_bounds_keeps_the_axes_within_theirs(
    first, second, third, top, part
):
    limits = Bounds(speed=np.full(2, top[0]), acceleration=np.full(2, top[1]), jerk=np.full(2, top[2]))
    d1, d2, d3 = (np.array([x]) for x in (first, second, third))
    bounds = axis_bounds((d1, d2, d3), limits, wide(1))
    v, a, j = (
        share * float(x[0]) for share, x in zip(part, (bounds.speed, bounds.acceleration, bounds.jerk), strict=True)
    )
    assert np.all(np.abs(d1 * v) <= MARGIN * limits.speed * (1 + 1e-9))
    assert np.all(np.abs(d1 * a + d2 * v**2) <= MARGIN * limits.acceleration * (1 + 1e-9))
    assert np.all(np.abs(d1 * j + 3 * d2 * v * a + d3 * v**3) <= MARGIN * limits.jerk * (1 + 1e-9))
    assert min(bounds.acceleration[0], bounds.jerk[0]) > 0


def test_straight_axes_may_use_all_of_their_limits():
    limits = Bounds(speed=np.array([2.0]), acceleration=np.array([5.0]), jerk=np.array([50.0]))
    still = np.zeros((1, 1))
    bounds = axis_bounds((still + 1, still, still), limits, wide(1))
    values = (bounds.speed[0], bounds.acceleration[0], bounds.jerk[0])
    np.testing.assert_allclose(values, MARGIN * np.array([2.0, 5.0, 50.0]))


def test_a_curve_at_constant_speed_may_use_its_share():
    limits = Bounds(speed=np.array([np.inf]), acceleration=np.array([5.0]), jerk=np.array([1e9]))
    bend = np.full((1, 1), 100.0)
    bounds = axis_bounds((0 * bend, bend, 0 * bend), limits, wide(1))
    assert 100 * bounds.speed[0] ** 2 == pytest.approx(MARGIN * CURVE_SHARE * 5.0)


def test_a_circle_runs_at_its_programmed_speed_up_to_its_normal_acceleration():
    arc = Arc(centre=np.zeros(3), first=np.array([1.0, 0, 0]), second=np.array([0, 1.0, 0]), radius=0.001, angle=6.0)
    s = np.linspace(0, arc.length, 33)
    for speed, wanted in ((0.1, 0.1), (0.2, np.sqrt(12.5 * 0.001))):
        leg = Leg(curve=arc, speed=Speed(tcp=speed))
        np.testing.assert_allclose(tool_bounds(leg.speed, s, leg.at(s), MotionLimits()).speed, wanted, rtol=1e-12)


def test_a_turning_tool_keeps_its_turning_speed_on_a_line_and_on_the_spot():
    turn = even_turn(np.eye(3), np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]), 1.0)
    for curve, rate in ((Line(start=np.zeros(3), end=np.array([0.1, 0, 0])), 5 * np.pi), (None, 1.0)):
        curve = curve or Still(point=np.zeros(3), angle=np.pi / 2)
        turning = even_turn(turn.start, turn.at(np.ones(1))[0][0], curve.length)
        leg = Leg(curve=curve, speed=Speed(tcp=10.0, turn=0.3), turning=turning)
        s = leg.grid()
        bounds = tool_bounds(leg.speed, s, leg.at(s), MotionLimits())
        np.testing.assert_allclose(bounds.speed * rate, MARGIN * 0.3)
        assert np.all(bounds.acceleration * rate <= MotionLimits().turn_acceleration)


def test_stretches_are_cut_where_the_speed_bound_varies_and_joined_where_it_does_not():
    s = [np.linspace(0, 1, 65), np.linspace(0, 1, 65)]
    even = Bounds(speed=np.full(65, 0.1), acceleration=np.full(65, 1.0), jerk=np.full(65, 10.0))
    softer = Bounds(speed=even.speed, acceleration=even.acceleration / SIMILAR, jerk=even.jerk)
    weak = Bounds(speed=even.speed, acceleration=even.acceleration / SIMILAR / 1.1, jerk=even.jerk)
    slow = Bounds(speed=even.speed / 2, acceleration=even.acceleration, jerk=even.jerk)
    assert [p.length for p in stretches(s, [even, even])] == [2.0]
    assert [p.acceleration for p in stretches(s, [even, softer])] == [1 / SIMILAR]
    assert [p.acceleration for p in stretches(s, [even, weak])] == [1.0, 1 / SIMILAR / 1.1]
    assert [p.speed for p in stretches(s, [even, slow])] == [0.1, 0.05]
    steep = Bounds(speed=np.linspace(0.1, 1.0, 65), acceleration=even.acceleration, jerk=even.jerk)
    parts = stretches(s[:1], [steep])
    assert len(parts) > 3
    assert sum(p.length for p in parts) == pytest.approx(1.0)
    starts = np.cumsum([0.0, *(p.length for p in parts)])
    for part, a, b in zip(parts, starts, starts[1:], strict=False):
        inside = steep.speed[(s[0] >= a - 1e-12) & (s[0] <= b + 1e-12)]
        assert part.speed == inside.min()
        assert inside.max() <= VARIATION * inside.min() or len(inside) <= 9


def test_joint_limits_are_by_default_in_units_of_the_largest_speeds():
    axes = MotionLimits(joint_speed=0.5).of_joints(np.array([2.0, 4.0]))
    np.testing.assert_array_equal(axes.speed, [1, 2])
    np.testing.assert_array_equal(axes.acceleration, JOINT_ACCELERATION * np.array([2.0, 4.0]))
    np.testing.assert_array_equal(axes.jerk, JOINT_JERK * np.array([2.0, 4.0]))
    given = MotionLimits(joint_acceleration=[1.0, 2.0], joint_jerk=[3.0, 4.0]).of_joints(np.array([2.0, 4.0]))
    np.testing.assert_array_equal([given.acceleration, given.jerk], [[1, 2], [3, 4]])


@pytest.mark.parametrize(
    "name",
    ["acceleration", "jerk", "normal_acceleration", "turn_acceleration", "turn_jerk", "joint_rise", "joint_rise_jerk"],
)
def test_limits_are_positive(name):
    for value in (0.0, -1.0, np.nan, "fast"):
        with pytest.raises(FFGymError, match=name):
            MotionLimits(**{name: value})


def test_joint_limits_that_make_no_sense_are_refused():
    with pytest.raises(FFGymError, match="joint_speed"):
        MotionLimits(joint_speed=1.1)
    with pytest.raises(FFGymError, match="for every joint"):
        MotionLimits(joint_jerk=[1.0, 0.0])
    with pytest.raises(FFGymError, match="has 1 entries"):
        MotionLimits(joint_acceleration=[1.0]).of_joints(np.ones(2))
