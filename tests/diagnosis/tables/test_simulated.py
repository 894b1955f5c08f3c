"""Errors of the rows of a table are those of the circle test with the same laws, as a tracker sees them."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from ffgym.control import NoCompensation
from ffgym.core.errors import FFGymError
from ffgym.diagnosis.tables.error_table import ErrorTable, MotionKey, TableRow
from ffgym.diagnosis.tables.parts import find_structure
from ffgym.diagnosis.tables.published import thesis_table
from ffgym.diagnosis.tables.simulated import SEEN_MAX, TableSimulator
from ffgym.studies import circle_study

ROW = TableRow(
    table="",
    use="fitted",
    motion=MotionKey(position="p1", speed_mm_s=100.0),
    radius_mm=3.0,
    law="none",
    statistic="rms",
    value_mm=0.1,
)


def table_of(rows):
    return ErrorTable(title="rows", source="", robot="irb4600_60_205", rows=tuple(rows))


def as_described(robot):
    return find_structure("description").candidate(robot, np.zeros(0))


def test_errors_are_those_of_the_circle_test_with_the_noise_of_the_tracker(irb4600):
    laws = ("none", "lugre_static", "lugre_dynamic")
    row = replace(ROW, motion=MotionKey(position="p1", speed_mm_s=10.0), radius_mm=1.0)
    rows = [replace(row, law=law, statistic=statistic) for law in laws for statistic in ("rms", "max")]
    study = circle_study(irb4600, positions=["p1"], speeds=[0.01], radii=[0.001])
    noise = 1e3 * irb4600.sensors.tracker_noise
    expected = []
    for law in laws:
        (cell,) = study.select(agent=law)
        expected += [np.hypot(cell.rms_mm, noise), np.hypot(cell.max_mm, SEEN_MAX * noise)]
    (found,) = TableSimulator(table_of(rows), irb4600).values([as_described(irb4600)], rows, irb4600.physics_dt)
    np.testing.assert_allclose(found, expected, rtol=0.02)  # of a recording at every control step, not every ms
    for a, b in combinations(range(3), 2):  # laws differ by more
        assert abs(np.log(expected[2 * a] / expected[2 * b])) > 0.03


def test_laws_learn_once_at_the_first_position_at_the_speed_of_their_rows(irb4600):
    motions = [("p1", 40.0), ("p2", 100.0), ("p3", 100.0)]
    rows = [replace(ROW, law="mine", motion=MotionKey(position=p, speed_mm_s=v)) for p, v in motions]
    learned = []

    def learn(name, machine, arm, references):
        learned.append((name, [reference.name for reference in references]))
        return NoCompensation()

    TableSimulator(table_of(rows), irb4600).values([as_described(irb4600)], rows, 0.001, learn)
    assert sorted(learned) == [("mine", ["p1, 40 mm/s"]), ("mine", ["p2, 100 mm/s"])]


def test_a_law_that_learns_is_refused_without_a_function_that_makes_it(irb4600):
    rows = [replace(ROW, law="mine")]
    simulator = TableSimulator(table_of(rows), irb4600)
    with pytest.raises(FFGymError, match="'mine' learns on the machine"):
        simulator._simulate([as_described(irb4600)], rows, 0.001, None)


@pytest.mark.parametrize(("position", "twin"), [("p1", "p1"), ("p2", "p2"), ("p3", "p2"), ("p4", "p1")])
def test_a_search_simulates_the_first_of_positions_that_are_alike(position, twin):
    row, expected = (replace(ROW, motion=MotionKey(position=p, speed_mm_s=40.0)) for p in (position, twin))
    assert thesis_table().twin(row) == expected
