"""Readings of resolvers by hand: when they are taken, what they are, and what servos know beyond the truth."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.effects import ResolverError
from ffgym.simulation.plant.resolvers import Resolvers, count_step, look_again, read_beyond, sum_errors

DT = 0.001
STEP = 2 * np.pi / 2**8


@pytest.fixture
def robots(one_axis):
    """One that reads every third physics step in 256 steps a turn, and one that reads nothing."""
    reads = replace(
        one_axis,
        drive=replace(one_axis.drive, resolver_period=3 * DT),
        sensors=replace(one_axis.sensors, encoder_bits=8),
    )
    return [reads, one_axis]


@pytest.fixture
def resolvers(robots):
    made = Resolvers(robots, DT)
    made.begin(slice(None), np.array([[10.2 * STEP], [0.0]]), np.array([[0.0], [0.0]]))
    return made


def test_only_machines_with_a_period_are_touched(robots, resolvers):
    assert resolvers.present.tolist() == [[True], [False]]
    assert not resolvers.all_present
    assert Resolvers(robots[:1], DT).all_present
    numbers = resolvers.numbers
    assert [numbers[name][0, 0] for name in ("every", "period", "step")] == [3.0, 3 * DT, STEP]
    assert numbers["present"] is resolvers.present
    every_step = replace(robots[0], drive=replace(robots[0].drive, resolver_period=DT))
    assert Resolvers([every_step], DT).numbers["every"].tolist() == [[1.0]]


def test_a_reading_holds_for_its_period_and_gives_the_mean_speed_since_the_last_one(resolvers):
    rows, every = slice(None), []
    for k in range(1, 7):
        due = resolvers.count(rows)
        if due is not None and due[0, 0]:
            resolvers.look(rows, due, np.array([[(10 + 2 * k) * STEP + 0.3 * STEP], [0.0]]))
        angle, speed = resolvers.read(rows)
        every.append((angle[0, 0] / STEP, speed[0, 0] * 3 * DT / STEP))
    np.testing.assert_allclose(every, [(10, 0), (10, 0), (16, 6), (16, 6), (16, 6), (22, 6)])


def test_steps_are_counted_until_it_is_time():
    count, due = count_step(np.array([[0.0, 1.0, 2.0]]), np.array([[3.0]]))
    assert count.tolist() == [[1.0, 2.0, 0.0]]
    assert due.tolist() == [[False, False, True]]


def test_where_none_has_to_read_nothing_is_told(robots):
    alone = Resolvers(robots[:1], DT)
    told = [alone.count(slice(None)) for _ in range(6)]
    assert [due is None for due in told] == [True, True, False, True, True, False]


def test_some_begin_anew_while_others_go_on(robots):
    both = Resolvers([robots[0], robots[0]], DT)
    both.begin(slice(None), np.zeros((2, 1)), np.zeros((2, 1)))
    both.count(slice(None))
    # a motor that moves has been two steps of the resolver before, a period ago
    both.begin(np.array([1]), np.array([[5.4 * STEP]]), np.array([[2 * STEP / (3 * DT)]]))
    angle, speed, count = both.memory
    np.testing.assert_allclose(angle[:, 0], [0.0, 5 * STEP])
    np.testing.assert_allclose(speed[:, 0], [0.0, 2 * STEP / (3 * DT)])
    assert count[:, 0].tolist() == [1.0, 0.0]
    assert both.read(np.array([1]))[0].tolist() == [[5 * STEP]]


def test_machines_that_are_not_due_keep_what_they_read():
    before = np.array([[1.0], [1.0]]), np.array([[0.5], [0.5]])
    due, angle = np.array([[True], [False]]), np.array([[3.1], [3.1]])
    now, speed = look_again(before, due, angle, np.array([[0.5]]), np.array([[4.0]]))
    assert now.tolist() == [[3.0], [1.0]]
    assert speed.tolist() == [[0.5], [0.5]]
    assert look_again(before, due, angle + 1, np.array([[0.5]]), np.array([[4.0]]))[1].tolist() == [[0.75], [0.5]]


@dataclass(frozen=True)
class Growing:
    """An error that grows with the angle and the speed that are read so far."""

    share: float

    def error(self, angle, speed):
        return ResolverError(angle=self.share * angle, speed=self.share * speed + 1.0)


def test_an_error_is_of_what_the_ones_before_it_leave():
    angle, speed = np.array([[2.0]]), np.array([[10.0]])
    total = sum_errors([Growing(0.5), Growing(1.0)], angle, speed)
    assert total.angle.tolist() == [[1.0 + 3.0]]
    assert total.speed.tolist() == [[(5.0 + 1.0) + (16.0 + 1.0)]]
    none = sum_errors([], angle, speed)
    assert none.angle.tolist() == none.speed.tolist() == [[0.0]]


def test_what_servos_know_beyond_the_truth_is_the_reading_or_the_error():
    read, error = (
        (np.array([[5.0]]), np.array([[7.0]])),
        ResolverError(angle=np.array([[0.1]]), speed=np.array([[0.2]])),
    )
    known = read_beyond(read, np.array([[2.0]]), np.array([[3.0]]), error, np.array([[True], [False]]))
    assert known.angle.tolist() == [[3.0], [0.1]]
    assert known.speed.tolist() == [[4.0], [0.2]]


def test_a_period_off_the_grid_is_named_with_its_machine(robots, one_axis):
    off, later = (replace(robots[0], drive=replace(robots[0].drive, resolver_period=k * DT)) for k in (2.5, 4.5))
    with pytest.raises(
        FFGymError, match=r"resolver_period = 0\.0025 s must be a whole multiple of physics_dt = 0\.001 s"
    ):
        Resolvers([one_axis, robots[0], off, later], DT)
    short = replace(robots[0], drive=replace(robots[0].drive, resolver_period=0.25 * DT))
    with pytest.raises(FFGymError, match=r"resolver_period = 0\.00025 s"):
        Resolvers([short], DT)
