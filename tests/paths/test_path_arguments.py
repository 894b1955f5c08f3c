"""Every argument of a motion that makes no sense is refused in one line that names it."""

import re

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.paths import circle_test, constant_velocity, joint_sine

NAN, INF = np.nan, np.inf
NOT_POSITIVE = (NAN, INF, -INF, 0, -1, "fast", None, [1, 2], 10**400)
NOT_NUMBERS = (NAN, INF, "left", None, {})
NOT_POINTS = ((1, 2), (1, 2, NAN), (1, 2, INF), "abc", None, 3.0, [[1, 2, 3]], (1, 2, "z"))
NOT_JOINTS = ([NAN], [INF, 1], "ab", None, 1.0, [[1.0]], [1, [2]])

CIRCLE = {
    "centre": NOT_POINTS,
    "speed": NOT_POSITIVE,
    "radii": ((), 0.001, None, (0.0,), (-1e-3,), (NAN,), (0.001, INF), ("big",), [[0.001]]),
    "normal": (*NOT_POINTS, (0, 0, 0), (1e-300, 0, 0)),
    "start_angle": NOT_NUMBERS,
    "dwell": NOT_POSITIVE,
    "dt": (*NOT_POSITIVE, 100.0, 1e-12),
}
SINE = {
    "amplitude": (*NOT_JOINTS, []),
    "frequency": NOT_POSITIVE,
    "duration": (*NOT_POSITIVE, 1e12),
    "centre": ([1.0], [1, 2, 3], [NAN, 0], "ab", 1.0),
    "dt": (*NOT_POSITIVE, 100.0, 1e-12),
}
CONSTANT = {
    "velocity": (*NOT_JOINTS, [], [0.0, 0.0]),
    "duration": (*NOT_POSITIVE, 1e12),
    "start": ([1.0], [1, 2, 3], [NAN, 0], "ab", 1.0),
    "ramp": NOT_POSITIVE,
    "dwell": NOT_POSITIVE,
    "dt": (*NOT_POSITIVE, 100.0, 1e-12),
}


def cases(table):
    return [pytest.param(name, value, id=f"{name}-{i}") for name, bad in table.items() for i, value in enumerate(bad)]


def assert_refused(function, arguments, name, value):
    with pytest.raises(FFGymError) as caught:
        function(**arguments | {name: value})
    message = str(caught.value)
    # a motion that is too long is the joint fault of its duration and its step
    wanted = (
        "radi" if name == "radii" else "motion lasts|too fast" if value in (100.0, 1e-12, 1e12) else re.escape(name)
    )
    assert re.search(wanted, message)
    assert "\n" not in message


@pytest.mark.parametrize(("name", "value"), cases(CIRCLE))
def test_circle_test_names_the_bad_argument(name, value):
    assert_refused(circle_test, {"centre": (1, 0, 0.5), "speed": 0.1, "radii": (0.001,)}, name, value)


@pytest.mark.parametrize(("name", "value"), cases(SINE))
def test_joint_sine_names_the_bad_argument(name, value):
    assert_refused(joint_sine, {"amplitude": [1.0, 2.0], "frequency": 1.0, "duration": 1.0}, name, value)


@pytest.mark.parametrize(("name", "value"), cases(CONSTANT))
def test_constant_velocity_names_the_bad_argument(name, value):
    assert_refused(constant_velocity, {"velocity": [1.0, 2.0], "duration": 1.0}, name, value)


def test_radii_may_be_an_array_and_the_normal_of_any_length():
    plain = circle_test((1, 0, 0.5), 0.1, radii=(0.001, 0.002))
    same = circle_test((1, 0, 0.5), 0.1, radii=np.array([0.001, 0.002]), normal=(0, 0, 1e250))
    np.testing.assert_array_equal(plain.position, same.position)


def test_a_path_lasts_at_least_one_step():
    assert len(joint_sine([1.0], 1.0, 0.004).t) == 2
    with pytest.raises(FFGymError, match="one step"):
        joint_sine([1.0], 1.0, 0.0039)


def test_arguments_are_not_changed():
    centre, normal, radii = np.array([1.0, 0, 0.5]), np.array([0, 0, 2.0]), np.array([0.001])
    path = circle_test(centre, 0.1, normal=normal, radii=radii)
    path.position[:] = 0
    np.testing.assert_array_equal(centre, [1, 0, 0.5])
    np.testing.assert_array_equal(normal, [0, 0, 2])
    np.testing.assert_array_equal(radii, [0.001])
