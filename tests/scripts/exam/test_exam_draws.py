"""Exams by seed: a question depends on its seed, row and number alone, and is what its row promises."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.effects import EFFECTS
from scripts.exam.draw import COUNTS, LOUDEST, QUIETEST, SPREAD, draw_case, errors_beside, miscalibrate
from scripts.exam.equations import OUTSIDERS, VARIANTS
from scripts.exam.hidden import Hidden, drawn


def numbers(case):
    """All that a question hides, as plain numbers."""
    robot = case.machine.robot
    hidden = [(one.effect.name, one.joint, one.numbers(robot)) for one in case.hidden]
    return hidden, case.loudness, robot.friction.coulomb.tolist(), robot.drive.joint_stiffness.tolist(), case.noise


@pytest.mark.parametrize("row", COUNTS)
def test_a_question_is_the_same_again_and_another_one_by_another_seed(row, arm):
    assert numbers(draw_case(row, 2, seed=1001, arm=arm)) == numbers(draw_case(row, 2, seed=1001, arm=arm))
    assert numbers(draw_case(row, 2, seed=1001, arm=arm)) != numbers(draw_case(row, 2, seed=1002, arm=arm))
    assert numbers(draw_case(row, 2, seed=1001, arm=arm)) != numbers(draw_case(row, 3, seed=1001, arm=arm))


@pytest.mark.parametrize(
    ("row", "kinds"), [("single", EFFECTS), ("foreign", VARIANTS), ("outside", OUTSIDERS)], ids=lambda x: str(x)[:8]
)
def test_every_kind_comes_once_before_any_comes_again(row, kinds, arm):
    kinds = set(kinds) - {"link_clock"}  # the robot has no such encoders
    names = [draw_case(row, k, seed=1003, arm=arm).hidden[0].effect.name for k in range(2 * len(kinds))]
    assert set(names[: len(kinds)]) == set(names[len(kinds) :]) == kinds
    assert names[: len(kinds)] != names[len(kinds) :]


def test_at_least_half_of_what_is_hidden_has_another_equation_or_is_outside():
    named = {"single": COUNTS["single"], "foreign": COUNTS["foreign"], "outside": COUNTS["outside"]}
    assert named["foreign"] + named["outside"] >= named["single"]
    assert len(EFFECTS) >= 20
    assert len(OUTSIDERS) >= 6


def test_a_pair_is_two_effects_with_two_names(arm):
    for k in range(8):
        one, two = draw_case("pair", k, seed=1004, arm=arm).hidden
        assert one.answer != two.answer


def test_nothing_is_hidden_in_a_clean_machine_but_errors_of_calibration(arm, irb4600):
    case = draw_case("clean", 0, seed=1005, arm=arm)
    assert case.hidden == () == case.loudness
    for part, name in (("friction", "coulomb"), ("drive", "rotor_inertia"), ("bodies", "mass")):
        off = getattr(getattr(case.machine.robot, part), name) / getattr(getattr(irb4600, part), name) - 1
        assert np.all(off != 0)
        assert np.abs(off).max() < 6 * SPREAD


def test_errors_of_calibration_have_the_spread_that_is_said(irb4600):
    rng = np.random.default_rng(1)
    robots = [miscalibrate(irb4600, rng) for _ in range(100)]
    for part, name in (("friction", "viscous"), ("drive", "joint_stiffness"), ("bodies", "mass")):
        nominal = getattr(getattr(irb4600, part), name)
        off = np.array([getattr(getattr(robot, part), name) / nominal - 1 for robot in robots])
        assert off.std() == pytest.approx(SPREAD, rel=0.1)


def test_loudness_is_spread_evenly_in_its_logarithm(arm):
    loud = np.log([draw_case("single", k, seed=1006, arm=arm).loudness[0] - 1 for k in range(200)])
    assert np.log(QUIETEST) <= loud.min() < loud.max() <= np.log(LOUDEST)
    assert np.median(loud) == pytest.approx(np.log(np.sqrt(QUIETEST * LOUDEST)), abs=0.8)


def test_a_drawn_effect_acts_on_its_joint_alone(irb4600):
    rng = np.random.default_rng(2)
    for kind in (*EFFECTS.values(), *VARIANTS.values()):
        one = drawn(kind, irb4600, rng)
        for name, known in kind.parameters().items():
            if known.null is None or known.per not in ("joint", "pair"):
                continue
            value = getattr(one.effect, name)
            others = np.arange(6) != irb4600.joints.index(one.joint)
            assert np.all(value[others] == known.null), kind.name
        assert not one.effect.is_null
        assert (one.joint == "") == (one.effect.n_joints is None)


def test_half_the_size_is_half_way_to_null(irb4600):
    rng = np.random.default_rng(2)
    for kind in (*EFFECTS.values(), *VARIANTS.values(), *OUTSIDERS.values()):
        one = drawn(kind, irb4600, rng)
        half = one.times(0.5)
        for name, known in kind.parameters().items():
            value, smaller = getattr(one.effect, name), getattr(half.effect, name)
            if known.null is None:
                np.testing.assert_array_equal(smaller, value)
            else:
                np.testing.assert_allclose(smaller - known.null, 0.5 * (value - known.null))
        assert one.times(0.0).effect.is_null


def test_cycles_per_turn_are_whole(irb4600):
    rng = np.random.default_rng(2)
    for _ in range(20):
        cycles = drawn(EFFECTS["cogging"], irb4600, rng, "j2").numbers(irb4600)["cycles"]
        assert cycles == round(cycles) >= 1


def test_a_row_or_number_that_there_is_not_is_refused(arm):
    with pytest.raises(FFGymError, match="row of the exam"):
        draw_case("easy", 0, seed=1, arm=arm)
    with pytest.raises(FFGymError, match="number"):
        draw_case("clean", -1, seed=1, arm=arm)


@pytest.mark.parametrize(
    ("effect", "parameter", "part", "number"),
    [
        ("coulomb_level", "change", "friction", "coulomb"),
        ("viscous_level", "change", "friction", "viscous"),
        ("presliding", "stiffness", "friction", "bristle_stiffness"),
        ("joint_stiffness", "change", "drive", "joint_stiffness"),
        ("rotor_inertia", "change", "drive", "rotor_inertia"),
    ],
)
def test_the_true_size_of_a_number_is_by_how_much_the_machine_differs(effect, parameter, part, number, arm, irb4600):
    """By the effect and by the error of the description, which nobody can tell apart."""
    case = draw_case("clean", 1, seed=1012, arm=arm)
    none = dict.fromkeys(EFFECTS[effect].parameters(), 0.0)  # of two numbers, the other is as described
    hidden = Hidden(effect=EFFECTS[effect].on(irb4600, "j2", **none | {parameter: 0.1}), joint="j2")
    told = replace(hidden, beside=errors_beside(hidden, irb4600, case.machine, case.current_offset)).numbers(irb4600)
    true = hidden.effect.in_description(case.machine.robot)
    off = getattr(getattr(true, part), number)[1] / getattr(getattr(irb4600, part), number)[1] - 1
    assert told == none | {parameter: pytest.approx(off)}
    assert abs(off - 0.1) > 1e-4


def test_currents_and_the_reflector_are_off_beside_what_is_hidden(arm, irb4600):
    case = draw_case("clean", 1, seed=1012, arm=arm)
    for effect, values in (("torque_offset", {"offset": 0.05}), ("tool_frame", {"offset": np.array([0.0, 1e-3, 0.0])})):
        joint = "j2" if effect == "torque_offset" else ""
        hidden = Hidden(effect=EFFECTS[effect].on(irb4600, joint or None, **values), joint=joint)
        found = errors_beside(hidden, irb4600, case.machine, case.current_offset)
        if joint:
            assert found == {"offset": -case.current_offset[1]}
        else:
            assert list(found.values()) == case.machine.effects[0].offset.tolist()
