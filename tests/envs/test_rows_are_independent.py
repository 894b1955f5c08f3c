"""What is summed within a row does not depend on how many rows there are, so that bits do not depend on the batch."""

import numpy as np
import pytest

from ffgym.envs.bank import path_error
from ffgym.envs.motion import MotionColumns
from ffgym.envs.rewards import mean_square


def of_any_size(rng, *shape):
    return rng.normal(size=shape) * 10.0 ** rng.integers(-8, 8, size=shape)


@pytest.mark.parametrize("joints", [1, 2, 3, 6, 7, 9, 12])
def test_mean_squares_of_a_batch_are_those_of_its_rows(joints):
    values = of_any_size(np.random.default_rng(joints), 300, joints)
    alone = np.concatenate([mean_square(values[i : i + 1]) for i in range(300)])
    for size in (2, 3, 7, 8, 16, 64, 65, 255, 300):
        np.testing.assert_array_equal(mean_square(values[:size]), alone[:size])


def test_path_errors_of_a_batch_are_those_of_its_rows():
    rng, columns = np.random.default_rng(0), MotionColumns(n_joints=6, has_tcp=True)
    rows, tcp = of_any_size(rng, 300, columns.width), of_any_size(rng, 300, 3)
    rows[::2, columns.radius] = 0.0
    alone = np.concatenate([path_error(tcp[i : i + 1], rows[i : i + 1], columns) for i in range(300)])
    for size in (2, 3, 7, 8, 16, 64, 65, 255, 300):
        s = slice(0, size)
        np.testing.assert_array_equal(path_error(tcp[s], rows[s], columns), alone[s])
