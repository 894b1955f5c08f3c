"""Time laws: within the limits of every stretch, from rest to rest, and as fast as that allows."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from path_samples import magnitudes

from ffgym.core.errors import FFGymError
from ffgym.paths.timing import PathStretch, _profile, _reachable, junction_speeds, time_law

many = settings(max_examples=100)
pieces = st.builds(
    PathStretch,
    length=magnitudes(1e-5, 10.0),
    speed=magnitudes(1e-3, 10.0),
    acceleration=magnitudes(0.1, 30.0),
    jerk=magnitudes(1.0, 3000.0),
)
paths = st.lists(pieces, min_size=1, max_size=12)


@many
@given(path=paths)
def test_a_time_law_is_smooth_and_keeps_every_limit_of_every_stretch(path):
    law = time_law(path)
    ends = np.append(law.start, law.duration)
    tau = np.diff(ends)
    s, v, a, j = law.state.T
    after = (s + tau * (v + tau * (a / 2 + tau * j / 6)), v + tau * (a + tau * j / 2), a + tau * j)
    fastest, steepest = max(p.speed for p in path), max(p.acceleration for p in path)
    for end, begin, last, size in zip(
        after, (s, v, a), (law.length, 0, 0), (law.length, fastest, steepest), strict=True
    ):
        np.testing.assert_allclose(end, np.append(begin[1:], last), atol=1e-7 * size)
    knots = np.cumsum([p.length for p in path])
    middle = law.at(law.start + tau / 2)[0]
    near = [
        np.minimum(np.searchsorted(knots, middle + x), len(path) - 1) for x in (-1e-7 * law.length, 1e-7 * law.length)
    ]
    limit = {
        name: np.max([np.array([getattr(p, name) for p in path])[which] for which in near], axis=0)
        for name in ("speed", "acceleration", "jerk")
    }
    assert np.all(v <= limit["speed"] * (1 + 1e-9))
    assert np.all(v >= -1e-9 * fastest)
    assert np.all(np.abs(a) <= limit["acceleration"] * (1 + 1e-6))
    assert np.all(np.abs(j) <= limit["jerk"] * (1 + 1e-9))


@many
@given(path=paths)
def test_sampled_values_are_derivatives_of_each_other(path):
    law = time_law(path)
    t = np.linspace(-0.1, law.duration + 0.1, 5001)
    s, v, a = law.at(t)
    jerk, step = max(p.jerk for p in path), t[1] - t[0]
    np.testing.assert_allclose((s[2:] - s[:-2]) / (2 * step), v[1:-1], atol=jerk * step**2 + 1e-9 * law.length / step)
    np.testing.assert_allclose((v[2:] - v[:-2]) / (2 * step), a[1:-1], atol=jerk * step + 1e-9)
    assert np.all(np.diff(s) >= -1e-12 * law.length)
    assert (s[0], v[0], s[-1], v[-1]) == (0, 0, law.length, 0)


@many
@given(path=paths, share=st.floats(0, 1))
def test_the_time_of_a_length_is_when_it_has_been_travelled(path, share):
    law = time_law(path)
    length = share * law.length
    assert law.at(np.array([law.time_of(length)]))[0][0] == pytest.approx(length, abs=1e-7 * law.length)
    assert law.time_of(law.length) == law.duration


@pytest.mark.parametrize(
    ("length", "duration"),
    [
        (1.0, 1.0 / 0.5 + 0.5 / 2.0 + 2.0 / 40.0),  # seven phases: L / v + v / a + a / j
        (0.001, 4 * (0.001 / (2 * 40.0)) ** (1 / 3)),  # neither speed nor acceleration reached: 4 (L / 2 j)^(1/3)
    ],
)
def test_a_single_line_takes_the_time_of_the_textbook(length, duration):
    law = time_law([PathStretch(length=length, speed=0.5, acceleration=2.0, jerk=40.0)])
    assert law.duration == pytest.approx(duration, rel=1e-12)


def test_the_programmed_speed_is_held_exactly():
    law = time_law([PathStretch(length=1.0, speed=0.04, acceleration=2.0, jerk=40.0)])
    speed = law.at(np.linspace(0.2, law.duration - 0.2, 1000))[1]
    np.testing.assert_array_equal(speed, 0.04)


@many
@given(path=pieces, before=st.floats(0, 1), after=st.floats(0, 1))
def test_one_stretch_between_two_speeds_is_as_fast_as_ruckig_makes_it(path, before, after):
    ruckig = pytest.importorskip("ruckig")
    shorter = replace(path, length=0.9 * path.length)  # where the length is just enough, ruckig may run backwards
    first = before * path.speed
    last = _reachable(shorter, first, after * path.speed)
    first = _reachable(shorter, last, first)
    wish = ruckig.InputParameter(1)
    wish.current_position, wish.target_position = [0.0], [path.length]
    wish.current_velocity, wish.target_velocity = [first], [last]
    wish.max_velocity, wish.max_acceleration, wish.max_jerk = [path.speed], [path.acceleration], [path.jerk]
    found = ruckig.Trajectory(1)
    ruckig.Ruckig(1).calculate(wish, found)
    assert _profile(path, first, last)[0] == pytest.approx(found.duration, rel=1e-6)


@many
@given(path=paths)
def test_junctions_are_as_fast_as_their_neighbours_can_reach(path):
    speeds = np.array(junction_speeds(path))
    caps = np.minimum([p.speed for p in path[:-1]], [p.speed for p in path[1:]])
    assert speeds[0] == speeds[-1] == 0
    assert np.all(speeds[1:-1] <= caps)
    for i, stretch in enumerate(path):  # a little more speed at either end is beyond the limit, or out of reach
        for end in (i, i + 1):
            faster = replace(stretch, length=1.01 * stretch.length)
            longer = [*path[:i], faster, *path[i + 1 :]]
            assert junction_speeds(longer)[end] >= speeds[end] * (1 - 1e-9)


def test_a_faster_limit_never_takes_longer():
    slow = PathStretch(length=0.3, speed=0.2, acceleration=1.0, jerk=20.0)
    for change in ({"speed": 0.4}, {"acceleration": 2.0}, {"jerk": 40.0}):
        fast = replace(slow, **change)
        assert time_law([fast, slow]).duration < time_law([slow, slow]).duration


@pytest.mark.parametrize("name", ["length", "speed", "acceleration", "jerk"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_a_stretch_needs_positive_numbers(name, value):
    with pytest.raises(FFGymError, match=name):
        PathStretch(**{"length": 1.0, "speed": 1.0, "acceleration": 1.0, "jerk": 1.0} | {name: value})
