"""Where a composed motion starts, rests and stops, what it says of stops that nobody asked for, and how phases join."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from programs import POINT, line, pose

from ffgym.paths.motions import compose
from ffgym.paths.motions.rows import join_pieces, rest
from ffgym.paths.moves import MoveJoint, MoveSpline, Speed, Wait, Zone


def test_the_motion_starts_at_the_first_target_or_where_it_is_told(arm, corners):
    first = compose(arm, [line(0, 0, 0), line(0.1, 0, 0)]).reference
    np.testing.assert_allclose(first.q[0], corners["p1"], atol=1e-9)
    told = compose(arm, [line(0.1, 0, 0)], start=corners["p1"]).reference
    np.testing.assert_array_equal(told.q, first.q)


def test_one_target_alone_is_a_rest_there(arm, corners):
    reference = compose(arm, [MoveJoint(to=corners["p1"])], dwell=0.1).reference
    assert [p.kind for p in reference.phases] == ["standstill"]
    np.testing.assert_array_equal(reference.q, np.tile(corners["p1"], (26, 1)))


def test_a_target_that_is_reached_already_takes_no_time(arm):
    once = compose(arm, [line(0, 0, 0), line(0.1, 0, 0)]).reference
    twice = compose(arm, [line(0, 0, 0), line(0, 0, 0), line(0.1, 0, 0), line(0.1, 0, 0)]).reference
    np.testing.assert_allclose(once.q, twice.q, atol=1e-9)


def test_a_stop_holds_at_a_target_that_is_reached_already(arm, corners):
    round_it = [line(0, 0, 0), line(0.1, 0, 0, zone=0.01), line(0.1, 0, 0), line(0.1, 0.1, 0)]
    tcp = arm.tcp_position(compose(arm, round_it).reference.q)
    assert np.linalg.norm(tcp - POINT - [0.1, 0, 0], axis=1).min() < 1e-9
    a, b, c = (MoveJoint(to=corners[name], zone=Zone(radius=0.01)) for name in ("p1", "p2", "p3"))
    q = compose(arm, [a, b, MoveJoint(to=corners["p2"]), c]).reference.q
    assert np.abs(q - corners["p2"]).max(axis=1).min() < 1e-12


def test_a_wait_rests_up_to_the_next_sample(arm):
    reference = compose(arm, [line(0, 0, 0), Wait(duration=0.05), line(0.1, 0, 0)], dwell=0.0).reference
    assert [(p.kind, round(p.end - p.start, 6)) for p in reference.phases[:1]] == [("standstill", 0.052)]


@pytest.mark.parametrize(
    ("moves", "note"),
    [
        ([line(0.1, 0, 0, zone=0.01), line(0, 0, 0)], "prog:2: the robot stops at 'b', because the path turns back"),
        (
            [line(0.1, 0, 0, zone=0.01), MoveSpline(through=(pose(0.1, 0.1, 0),), speed=Speed(tcp=0.1))],
            "because a spline starts and ends at rest",
        ),
        ([line(0.1, 0, 0, zone=0.01), MoveJoint(to=pose(0, 0, 0))], "because a corner joins moves of one kind only"),
        ([line(0.1, 0, 0, zone=0.01), Wait(duration=0.1)], "because a corner joins moves of one kind only"),
        (
            [MoveJoint(to=pose(0.1, 0, 0), zone=Zone(radius=0.01)), MoveJoint(to=pose(0, 0, 0))],
            "because the joints turn back there",
        ),
    ],
)
def test_a_stop_that_was_not_asked_for_is_noted(arm, moves, note):
    first = replace(moves[0], label="b", where="prog:2")
    motion = compose(arm, [line(0, 0, 0), first, *moves[1:]])
    assert len(motion.notes) == 1
    assert note in motion.notes[0]


@given(st.lists(st.integers(1, 2000), min_size=2, max_size=6))
def test_phases_of_joined_pieces_tile_the_motion(irb4600, counts):
    dt, home = irb4600.servo.control_dt, irb4600.work_area.home
    pieces = [rest(home, count * dt, dt, f"rest {k}") for k, count in enumerate(counts)]
    motion = join_pieces("rests", irb4600, pieces)
    ends = np.cumsum(counts) * dt
    np.testing.assert_allclose([phase.end for phase in motion.phases], ends, atol=1e-9)
    for before, after in itertools.pairwise(motion.phases):
        assert before.end <= after.start <= before.end + 1e-9
