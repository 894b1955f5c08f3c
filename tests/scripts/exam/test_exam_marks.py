"""Marks: what an answer is worth beside what is hidden, and the figures that marks come to."""

from dataclasses import replace

import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.result import Cause, Diagnosis, Pattern, Rival, Size
from ffgym.effects import EFFECTS
from scripts.exam.draw import draw_case
from scripts.exam.equations import Clue
from scripts.exam.equations.joints import two_wave_cogging
from scripts.exam.equations.outsiders import floor_vibration, rubbing_hose
from scripts.exam.exams import EXAMS
from scripts.exam.gain import gain_of
from scripts.exam.hidden import Hidden
from scripts.exam.marks import Gain, finds, mark_of, read_marks, write_marks
from scripts.exam.report import figures_text, misses_text, outcomes_text
from scripts.exam.tables import table
from scripts.exam.tasks import Task


def cause(effect, joint, *sizes, **fixed):
    return Cause(effect=effect, code="", title="", joint=joint, parameters=sizes, fixed=fixed, held_out_gain=0.9)


def rival(effect, joint, tied=True):
    return Rival(effect=effect, joint=joint, held_out_gain=0.9, tied=tied, against="", reason="")


def pattern(variable, kind="function", frequency=None, component="j2"):
    return Pattern(
        channel="torque",
        component=component,
        variable=variable,
        kind=kind,
        frequency=frequency,
        amplitude=1.0,
        share=0.5,
        message=f"{variable} {frequency}",
    )


def says(verdict, *causes, **more):
    return Diagnosis(verdict=verdict, sentence="", robot="", motions=(), causes=causes, **more)


@pytest.fixture
def task(irb4600):
    """A function that hands out a question with some effects in it, nothing recorded."""

    def make(*hidden, loudness=20.0, row="single", number=0):
        return Task(
            row=row,
            number=number,
            robot=irb4600,
            log=(),
            truth=tuple(one.truth(irb4600, loudness) for one in hidden),
            clue=hidden[0].clue(irb4600) if hidden else None,
        )

    return make


@pytest.fixture
def load(irb4600):
    return Hidden(effect=EFFECTS["load_friction"].on(irb4600, "j2", share=0.05), joint="j2")


@pytest.fixture
def cogging(irb4600):
    effect = EFFECTS["cogging"].on(irb4600, "j3", amplitude=0.1, cycles=12.0, phase=1.0)
    return Hidden(effect=effect, joint="j3")


RIGHT, OTHER = cause("load_friction", "j2"), cause("payload", "")


@pytest.mark.parametrize(
    ("answer", "outcome", "first", "wrongly"),
    [
        (says("named", RIGHT), "right", True, False),
        (says("partly", RIGHT), "right", True, False),
        (says("named", RIGHT, OTHER), "surplus", True, True),
        (says("named", OTHER, RIGHT), "wrong", False, True),
        (says("named", OTHER), "wrong", False, True),
        (says("named", cause("load_friction", "j3")), "wrong", False, True),
        (says("partly", OTHER), "wrong_partly", False, False),
        (says("ambiguous", OTHER, rivals=(rival("load_friction", "j2"),)), "tie", False, False),
        (says("ambiguous", RIGHT, rivals=(rival("payload", ""),)), "tie", True, False),
        (says("ambiguous", OTHER, rivals=(rival("load_friction", "j2", tied=False),)), "wrong_tie", False, False),
        (says("none"), "none", False, False),
        (says("unknown", OTHER), "unknown", False, False),
        (says("insufficient"), "insufficient", False, False),
    ],
    ids=lambda x: x.verdict if isinstance(x, Diagnosis) else str(x),
)
def test_an_answer_to_one_hidden_effect_is_mark_of(task, load, answer, outcome, first, wrongly):
    mark = mark_of(task(load), answer)
    assert (mark.outcome, mark.first_is_right, mark.names_wrongly) == (outcome, first, wrongly)


@pytest.mark.parametrize(
    ("causes", "outcome"),
    [
        ((RIGHT, cause("cogging", "j3")), "right"),
        ((RIGHT,), "part"),
        ((RIGHT, OTHER), "wrong"),
        ((RIGHT, cause("cogging", "j3"), OTHER), "surplus"),
    ],
    ids=["both", "one", "one and another", "both and another"],
)
def test_of_a_pair_both_must_be_named(task, load, cogging, causes, outcome):
    assert mark_of(task(load, cogging, row="pair"), says("named", *causes)).outcome == outcome


@pytest.mark.parametrize(
    ("listed", "outcome"), [((("cogging", "j3"),), "tie"), ((("payload", ""),), "part"), ((), "part")]
)
def test_of_a_pair_both_must_be_in_a_tie(task, load, cogging, listed, outcome):
    answer = says("ambiguous", RIGHT, rivals=tuple(rival(*one) for one in listed))
    assert mark_of(task(load, cogging, row="pair"), answer).outcome == outcome


def test_a_variant_is_named_by_the_effect_that_it_is_of(task, irb4600):
    hidden = Hidden(effect=two_wave_cogging.on(irb4600, "j1", amplitude=0.1, cycles=6.0, phase=0.0), joint="j1")
    mark = mark_of(task(hidden), says("named", cause("cogging", "j1", cycles=6.04)))
    assert mark.outcome == "right"
    assert mark.cycles_off == pytest.approx(0.04)
    assert mark.sizes == ()  # sizes of two equations are not the same


def test_of_two_waves_that_are_named_the_main_one_counts_whichever_comes_first(task, irb4600):
    hidden = Hidden(effect=two_wave_cogging.on(irb4600, "j1", amplitude=0.1, cycles=6.0, phase=0.0), joint="j1")
    waves = [
        cause("cogging", "j1", cycles=12.01),
        cause("cogging", "j1", cycles=5.97),
        cause("cogging", "j2", cycles=6),
    ]
    mark = mark_of(task(hidden), says("named", *waves))
    assert mark.cycles_off == pytest.approx(-0.03)


def test_an_effect_outside_the_library_has_no_right_name(task, irb4600):
    effect = floor_vibration.on(irb4600, "j2", share=0.1, frequency=17.0, phase=0.0)
    hidden = Hidden(effect=effect, joint="j2")
    named = mark_of(task(hidden, row="outside"), says("named", OTHER))
    unknown = mark_of(task(hidden, row="outside"), says("unknown", patterns=(pattern("time", "line", 17.1),)))
    assert named.names_wrongly
    assert not named.clue_found
    assert unknown.clue_found


@pytest.mark.parametrize(
    ("clue", "patterns", "found"),
    [
        (Clue(words=("time",), frequency=17.0), [pattern("time", "line", 17.2)], True),
        (Clue(words=("time",), frequency=17.0), [pattern("time", "line", 19.0)], False),
        (Clue(words=("time",), frequency=2.0), [pattern("time", "line", 6.0)], True),  # a switch has odd multiples
        (
            Clue(words=("time",), frequency=2.0),
            [pattern("time", "function")],
            True,
        ),  # the variable, if not the frequency
        (Clue(words=("time",)), [pattern("time", "function")], True),
        (Clue(words=("time",)), [pattern("time at rest before the move", "function")], False),
        (Clue(words=("angle",), joint="j5"), [pattern("motor angle of j5")], True),
        (Clue(words=("angle",), joint="j5"), [pattern("motor angle")], False),
        (Clue(words=("angle",), joint="j5"), [pattern("motor speed of j5")], False),
        (Clue(words=("angle",), joint="j2"), [pattern("motor angle", "sign-locked function")], True),
        (Clue(words=("angle",), joint="j2"), [pattern("motor angle", component="j1")], False),
        (Clue(words=("angle",), joint="j2"), [pattern("load"), pattern("motor angle")], False),
        (Clue(words=("angle",), joint="j2"), [], False),
        (Clue(words=("speed",), joint="j2"), [pattern("size of the motor speed")], True),
        (Clue(words=("speed",), joint="j5"), [pattern("size of the motor speed of j5")], True),
        (Clue(words=("time",)), [pattern("time", "line", 3.0)], False),
    ],
)
def test_the_strongest_pattern_of_the_joint_must_be_the_one(clue, patterns, found):
    assert finds(clue, patterns, "j2", ("j1", "j2", "j5")) is found


def test_sizes_stand_beside_the_true_ones(task, load):
    size = Size(name="share", value=0.053, unit="1", interval=(0.045, 0.06))
    (mark,) = mark_of(task(load), says("named", cause("load_friction", "j2", size))).sizes
    assert mark.error == pytest.approx(0.06)
    assert mark.is_covered


def test_a_size_means_nothing_beside_another_shape(task, irb4600):
    effect = EFFECTS["dwell_stiction"].on(irb4600, "j2", share=0.3, time=2.0, slip=0.02)
    size = Size(name="share", value=0.3, unit="1", interval=(0.2, 0.4))
    hidden = task(Hidden(effect=effect, joint="j2"))
    near = mark_of(hidden, says("named", cause("dwell_stiction", "j2", size, time=2.1, slip=0.02)))
    far = mark_of(hidden, says("named", cause("dwell_stiction", "j2", size, time=0.3, slip=0.02)))
    assert len(near.sizes) == 1
    assert far.sizes == ()


def test_marks_are_a_file_that_an_interrupted_exam_goes_on_with(task, load, tmp_path):
    place = tmp_path / "marks.jsonl"
    assert read_marks(place, EXAMS["own"].head(5)) == []
    gain = Gain(leftover=1.2, before=9e-6, after=2e-6)
    first = mark_of(task(load, number=1), says("named", RIGHT), seconds=3.0, same_bytes=True, gain=gain)
    second = mark_of(task(row="clean"), says("none"))
    write_marks(place, EXAMS["own"].head(5), [first, second])
    assert read_marks(place, EXAMS["own"].head(5)) == [second, first]
    with pytest.raises(FFGymError, match="another seed"):
        read_marks(place, EXAMS["own"].head(6))
    place.write_text(place.read_text()[:-20])
    with pytest.raises(FFGymError, match="damaged"):
        read_marks(place, EXAMS["own"].head(5))


def got(marks, number, words):
    (line,) = [line for line in table(marks) if line.number == number and words in line.figure]
    return line


def test_figures_are_counted_in_their_bands(task, load):
    right = mark_of(task(load, loudness=50.0), says("named", RIGHT))
    tie = mark_of(task(load, loudness=1.5), says("ambiguous", OTHER, rivals=(rival("load_friction", "j2"),)))
    wrong = mark_of(task(load, loudness=5.0), says("named", OTHER))
    buried = mark_of(task(load, loudness=1.1), says("none"))
    marks = [right, right, tie, wrong, buried]
    assert got(marks, 2, "first").got == "100.0%"
    assert got(marks, 2, "wrong").is_met
    assert got(marks, 3, "first").got == "0.0%"
    assert not got(marks, 3, "wrong").is_met
    assert got(marks, 4, "tie").is_met
    assert got(marks, 5, "other equation").is_met is None
    assert "NO" in figures_text(table(marks))
    assert "wrong" in outcomes_text(marks)
    assert misses_text(marks).count("\n") == 2


def test_a_clean_log_must_not_be_named(task):
    marks = [mark_of(task(row="clean"), says("none")), mark_of(task(row="clean", number=1), says("partly", OTHER))]
    line = got(marks, 1, "clean")
    assert (line.got, line.of, line.is_met) == ("1", 2, False)


def test_a_poor_log_may_be_a_tie_that_a_proposed_motion_resolves(task, load):
    tie = says("ambiguous", OTHER, rivals=(rival("load_friction", "j2"),))
    marks = [mark_of(task(load, row="poor"), tie, then="right"), mark_of(task(load, row="poor"), says("none"))]
    assert got(marks, 9, "wrong").is_met
    assert got(marks, 9, "tie").is_met
    assert got(marks, 9, "resolves").is_met


def test_the_clue_of_a_cross_axis_effect_is_the_other_joint(irb4600):
    share = [[0.0] * 6 for _ in range(6)]
    share[1][4] = 0.2
    hidden = Hidden(effect=rubbing_hose.on(irb4600, share=share, phase=0.3), joint="j2")
    assert hidden.clue(irb4600).joint == "j5"


@pytest.mark.slow
def test_the_true_causes_leave_what_noise_and_calibration_leave(arm, irb4600):
    effect = EFFECTS["coulomb_level"].on(irb4600, "j2", change=0.2)
    case = replace(draw_case("single", 0, seed=1011, arm=arm), hidden=(Hidden(effect=effect, joint="j2"),))
    size = Size(name="change", value=0.2, unit="1", interval=(0.1, 0.3))
    gain = gain_of(case, [cause("coulomb_level", "j2", size)])
    assert gain.leftover == pytest.approx(1.0, abs=0.3)
    assert gain_of(case, []).leftover > 5
    assert gain.after < gain.before
