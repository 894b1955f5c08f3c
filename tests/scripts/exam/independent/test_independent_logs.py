"""Logs of the independent plant through the diagnosis: clean ones are clean, and effects are named."""

from dataclasses import replace

import pytest

from scripts.exam import exams
from scripts.exam.exams import IndependentExam, examine
from scripts.exam.independent import question, robots
from scripts.exam.independent.question import draw_task
from scripts.exam.independent.sensors import Columns
from scripts.exam.marks import mark_of

PLAIN = Columns(tracker=False, set_points=True, feedback=False, speed=False, temperature=False)
SHORT = {"count": 4, "duration": 2.4}
TIDY = {"control": "documented", "columns": PLAIN, "noise": "white", "row_dt": 0.004, "share": 0.005}


@pytest.fixture
def gears_that_keep_the_sign(monkeypatch):
    """Gearboxes whose motors turn as the joints do."""
    drawn = robots._motors

    def motors(*arguments):
        drive, friction = drawn(*arguments)
        return replace(drive, gear_ratio=abs(drive.gear_ratio)), friction

    monkeypatch.setattr(robots, "_motors", motors)


@pytest.fixture
def hiding(monkeypatch):
    """A function that has one kind of effect hidden at full size, on whichever joint."""

    def hide(name):
        monkeypatch.setattr(question, "KINDS", {name: question.KINDS[name]})
        monkeypatch.setattr(question, "_SMALLEST", 0.999)

    return hide


@pytest.mark.parametrize(("n", "elastic"), [(1, False), pytest.param(2, True, marks=pytest.mark.slow)])
def test_a_clean_log_is_clean(n, elastic, gears_that_keep_the_sign):
    task = draw_task("clean", 0, seed=3, n=n, elastic=elastic, **TIDY, **SHORT)
    assert IndependentExam().answer(task).verdict == "none"


@pytest.mark.parametrize(
    "conditions",
    [
        pytest.param({"n": 1, "elastic": True, "row_dt": 0.008, "control": "cascade"}, marks=pytest.mark.slow),
        pytest.param({"n": 1, "elastic": False, "row_dt": 0.005, "noise": "coloured"}, marks=pytest.mark.slow),
        {"n": 2, "elastic": False, "row_dt": 0.008, "control": "cascade", "columns": "feedback"},
        pytest.param({"n": 4, "elastic": True, "row_dt": 0.002, "share": 0.05}, marks=pytest.mark.slow),
    ],
    ids=["rare samples", "noise with memory", "feedback without set-points", "loose numbers"],
)
def test_what_sensors_and_numbers_leave_open_is_no_fault(conditions):
    if conditions.get("columns") == "feedback":
        conditions = conditions | {"columns": replace(PLAIN, set_points=False, feedback=True)}
    task = draw_task("clean", 0, seed=5, **(TIDY | conditions))
    assert IndependentExam().answer(task).verdict == "none"


@pytest.mark.slow
def test_coriolis_torques_of_links_that_swing_are_no_fault():
    """Three fast elastic axes, whose quiet sensors hear a tenth of what their swinging takes."""
    assert IndependentExam().answer(draw_task("clean", 7, seed=101)).verdict == "none"


@pytest.mark.slow
def test_numbers_that_are_off_by_more_than_slopes_tell_are_no_fault():
    """Two elastic axes that are known to 5 %, and swing: slopes leave forty times the noise, and two wrong springs."""
    assert IndependentExam().answer(draw_task("clean", 6, seed=1601)).verdict == "none"


@pytest.mark.slow
def test_an_effect_below_a_noise_floor_that_allows_for_too_much_is_named():
    """Sensors that are quieter than models foretell: a tenth of the floor is there, and load friction beside it."""
    task = draw_task("single", 3, seed=1601)
    mark = mark_of(task, IndependentExam().answer(task))
    assert mark.outcome == "right"
    assert all(size.is_covered for size in mark.sizes)


@pytest.mark.parametrize(
    ("name", "n"),
    [
        ("load_share", 2),
        pytest.param("coulomb", 1, marks=pytest.mark.slow),
        pytest.param("rotor", 1, marks=pytest.mark.slow),
        pytest.param("waves", 1, marks=pytest.mark.slow),
        pytest.param("cogging", 1, marks=pytest.mark.slow),
    ],
)
def test_a_loud_effect_is_named(name, n, gears_that_keep_the_sign, hiding):
    hiding(name)
    task = draw_task("single", 0, seed=3, n=n, elastic=True, **TIDY, **SHORT)
    assert task.truth[0].loudness > 10
    mark = mark_of(task, IndependentExam().answer(task))
    assert mark.outcome in ("right", "tie"), (mark.outcome, mark.sentence)
    assert not mark.names_wrongly


def test_a_diagnosis_that_ends_in_an_error_is_an_answer(monkeypatch):
    small = draw_task("clean", 1, seed=3, n=1, count=1, duration=0.8)
    monkeypatch.setattr(question, "draw_task", lambda row, number, seed: small)
    monkeypatch.setattr(exams, "diagnose", lambda *log, **more: (1,).index(2))
    mark = examine(("clean", 1), exam=IndependentExam(), seed=3)
    assert mark.outcome == "insufficient"
    assert mark.sentence.startswith("ValueError")
    assert mark.conditions == small.setup.label


@pytest.mark.slow
@pytest.mark.parametrize("n", [1, 2])
def test_friction_behind_a_spring_is_named_alone_where_a_tracker_sees_the_arm(n, gears_that_keep_the_sign, hiding):
    hiding("behind")
    task = draw_task("arm", 0, seed=4, n=n, **TIDY, **SHORT)
    assert task.truth[0].loudness > 10
    answer = IndependentExam().answer(task)
    assert answer.verdict == "named", answer.sentence
    assert mark_of(task, answer).outcome == "right"


@pytest.mark.slow
@pytest.mark.parametrize("n", [1, 2])
def test_friction_behind_a_spring_is_no_other_cause_where_no_tracker_sees_the_arm(n, gears_that_keep_the_sign, hiding):
    hiding("behind")
    answer = IndependentExam().answer(draw_task("arm_blind", 0, seed=4, n=n, **TIDY, **SHORT))
    assert answer.verdict in ("ambiguous", "unknown"), answer.sentence
