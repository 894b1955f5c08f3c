"""Phases of joined pieces follow each other, however their times are rounded."""

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ffgym.paths.motions.rows import joined, rest


@given(st.lists(st.integers(1, 2000), min_size=2, max_size=6))
def test_phases_of_joined_pieces_tile_the_motion(irb4600, counts):
    dt, home = irb4600.servo.control_dt, irb4600.work_area.home
    pieces = [rest(home, count * dt, dt, f"rest {k}") for k, count in enumerate(counts)]
    motion = joined("rests", irb4600, pieces)
    ends = np.cumsum(counts) * dt
    np.testing.assert_allclose([phase.end for phase in motion.phases], ends, atol=1e-9)
    for before, after in itertools.pairwise(motion.phases):
        assert before.end <= after.start <= before.end + 1e-9
