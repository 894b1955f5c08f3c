"""The loop behind all fits goes down as far as it is told, and stays where no step leads down."""

import numpy as np
import pytest

from ffgym.diagnosis.fit.descent import Slope, Steps, descend


class Valley(Slope):
    """Energy of one number: its distance from 10, as `bend` makes slopes too steep or too flat; steps are counted."""

    def __init__(self, bend=1.0, wall=np.inf, flat=False, without_slopes_at=(), hopeless_beyond=np.inf):
        self.bend, self.wall, self.flat = bend, wall, flat
        self.without_slopes_at, self.hopeless_beyond = without_slopes_at, hopeless_beyond
        self.reaches, self.renewed = [], []

    def cost(self, point):
        return 1.0 if self.flat else (point - 10.0) ** 2

    def step(self, point, reach):
        self.reaches.append(reach)
        return np.clip([self.bend * (10.0 - point)], -reach, reach)

    def move(self, point, step):
        there = point + float(step[0])
        return there if there <= self.wall else None

    def renew(self, point, *, is_last):
        self.renewed.append((point, is_last))
        return None if len(self.renewed) in self.without_slopes_at else point

    def is_hopeless(self, point):
        return point > self.hopeless_beyond


def steps(most, least_reach=1e-3, **bounds):
    """Bounds on the steps of a fit."""
    return Steps(most=most, least_reach=least_reach, **bounds)


def test_a_step_that_slopes_tell_exactly_is_taken_and_the_next_is_not():
    valley = Valley()
    assert descend(valley, 0.0, steps(most=5)) == 10.0
    assert valley.renewed == [(10.0, False)]  # from there no step leads further down


def test_no_more_steps_are_taken_than_asked_for_and_the_last_is_told():
    valley = Valley(bend=0.5)
    assert descend(valley, 0.0, steps(most=3)) == pytest.approx(8.75)
    assert valley.renewed == [(5.0, False), (7.5, False), (8.75, True)]


def test_without_steps_it_stays():
    assert descend(Valley(), 3.0, steps(most=0)) == 3.0


def test_a_step_goes_no_further_than_its_reach_which_doubles_up_to_the_longest():
    valley = Valley()
    descend(valley, 0.0, steps(most=4, reach=1.0))
    assert valley.reaches == [1.0, 1.0, 1.0, 1.0]


def test_a_step_that_is_too_long_becomes_a_third_of_itself():
    valley = Valley(bend=6.0)  # to 60, then a third of that: 20, no better; a ninth is 20 / 3
    assert descend(valley, 0.0, steps(most=1)) == pytest.approx(20 / 3)
    assert valley.reaches == pytest.approx([np.inf, 20.0, 20 / 3])


def test_after_a_step_that_was_shortened_the_reach_is_twice_its_own():
    valley = Valley(bend=6.0)
    descend(valley, 0.0, steps(most=2))
    assert valley.reaches[3] == pytest.approx(2 * 20 / 3)


def test_a_place_where_no_machine_can_be_is_gone_around():
    assert descend(Valley(wall=4.0), 0.0, steps(most=1)) == pytest.approx(10 / 3)


def test_it_rests_where_steps_become_shorter_than_the_least():
    valley = Valley(bend=6.0)
    assert descend(valley, 0.0, steps(most=3, least_reach=30.0)) == 0.0
    assert valley.renewed == []
    assert descend(Valley(flat=True), 0.0, steps(most=3, least_reach=1e-3)) == 0.0
    assert descend(Valley(), 0.0, steps(most=1, reach=1.0, least_reach=1.0)) == 1.0  # the least one is tried


def test_a_short_step_of_little_gain_is_the_last():
    # each goes half of what is left, and leaves a quarter of the energy
    wanting = Valley(bend=0.5)
    descend(wanting, 0.0, steps(most=9, gain=0.8, rest=3.0))
    assert wanting.renewed == [(5.0, False), (7.5, True)]
    for gain in (0.7, 0.75):
        patient = Valley(bend=0.5)
        descend(patient, 0.0, steps(most=3, gain=gain, rest=3.0))
        assert [last for _, last in patient.renewed] == [False, False, True]


def test_a_step_of_little_gain_that_is_not_shorter_than_where_it_rests_is_not_the_last():
    valley = Valley(bend=0.5)
    descend(valley, 0.0, steps(most=9, gain=0.8, rest=2.5))
    assert valley.renewed == [(5.0, False), (7.5, False), (8.75, True)]


def test_a_step_that_its_reach_held_back_is_not_the_last_however_little_it_gains():
    valley = Valley()
    descend(valley, 0.0, steps(most=3, reach=0.1, gain=0.9))
    assert [last for _, last in valley.renewed] == [False, False, True]


def test_where_there_are_no_slopes_the_point_before_is_the_last():
    valley = Valley(bend=0.5, without_slopes_at=(2,))
    assert descend(valley, 0.0, steps(most=5)) == 5.0
    assert len(valley.renewed) == 2


def test_what_is_hopeless_is_given_up():
    assert descend(Valley(bend=0.5, hopeless_beyond=7.0), 0.0, steps(most=5)) is None
    assert descend(Valley(bend=0.5, hopeless_beyond=9.0), 0.0, steps(most=3)) == pytest.approx(8.75)


def test_a_slope_that_does_not_say_so_is_not_hopeless():
    class Hopeful(Valley):
        is_hopeless = Slope.is_hopeless

    assert descend(Hopeful(hopeless_beyond=0.0), 0.0, steps(most=5)) == 10.0


def test_the_length_of_a_step_is_its_largest_change():
    assert Valley().length(np.array([0.5, -2.0, 1.0])) == 2.0
    assert Valley().length(np.array([])) == 0.0
