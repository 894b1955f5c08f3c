"""An effect is hidden in a machine, and the diagnosis of its log must find it: six axes, errors of calibration, noise.

The same on hundreds of logs, by any seed, is `python -m scripts.exam`.
"""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis import DiagnosisCache, diagnose
from ffgym.effects import EFFECTS
from scripts.exam.draw import draw_case
from scripts.exam.equations import OUTSIDERS, VARIANTS
from scripts.exam.hidden import Hidden
from scripts.exam.loudness import record_case
from scripts.exam.marks import finds, outcome

SEED = 2026
"""Of the errors of calibration and the noise."""


def hidden(robot, name, joint="", **values):
    """An effect on a joint, or on the machine."""
    kind = {**EFFECTS, **VARIANTS, **OUTSIDERS}[name]
    return Hidden(effect=kind.on(robot, joint or None, **values), joint=joint)


def pair(robot, joint, other, size):
    """A number per pair of joints that is null but for one."""
    matrix = np.zeros((robot.n_joints, robot.n_joints))
    matrix[robot.joints.index(joint), robot.joints.index(other)] = size
    return matrix


@pytest.fixture(scope="module")
def question(arm):
    """A function of effects that gives a question with these hidden in a machine."""

    def make(number, *effects, row="single", lacks=()):
        case = draw_case("poor_clean" if row == "poor" else "clean", number, seed=SEED, arm=arm)
        return replace(case, row=row, hidden=effects, bench=replace(case.bench, lacks=lacks))

    return make


@pytest.fixture(scope="module")
def answer(irb4600):
    """A function that diagnoses the log of a question."""
    memory = DiagnosisCache()
    return lambda case: diagnose(irb4600, record_case(case), cache=memory)


@pytest.mark.parametrize("number", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_nothing_is_found_where_nothing_is_hidden(number, question, answer):
    assert answer(question(number)).verdict == "none"


NAMED = {
    "load friction": ("load_friction", "j2", {"share": 0.06}),
    "stiffness": ("joint_stiffness", "j3", {"change": -0.15}),
    "cogging": ("cogging", "j1", {"amplitude": 0.06, "cycles": 12.0, "phase": 1.0}),
    "payload": ("payload", "", {"mass": 3.0}),
    "gear error": ("kinematic_error", "j6", {"amplitude": 3e-4, "cycles": 2.0, "phase": 1.3}),
    "position": ("position_friction", "j3", {"share": 0.15, "cycles": 12.0, "phase": 1.0}),
    "hysteresis": ("torsional_hysteresis", "j1", {"lost_motion": 8e-5, "width": 3e-4}),
    "warm-up": ("temperature_friction", "j2", {"viscous": 0.6, "coulomb": 0.0, "breakaway": 0.0, "scale": 25.0}),
    "shear thinning, another equation": ("vogel_oil", "j3", {"share": 0.5, "vogel": 900.0}),
    "slip elements, another equation": ("maxwell_slip", "j6", {"share": 0.8, "travel": 0.03}),
    "efficiency, another equation": ("directional_efficiency", "j2", {"share": 0.05, "ratio": 1.4, "slow": 0.3}),
}


@pytest.mark.slow
@pytest.mark.parametrize("what", NAMED)
def test_what_is_hidden_is_named_with_its_joint(what, question, answer, irb4600):
    name, joint, values = NAMED[what]
    one = hidden(irb4600, name, joint, **values)
    found = answer(question(2 + list(NAMED).index(what), one))
    wanted = ("right", "tie") if "another equation" in what else ("right",)
    assert outcome(found, [one]) in wanted, found.sentence


@pytest.mark.slow
@pytest.mark.parametrize("number", [13, 30])
def test_a_link_that_bends_is_named_unless_the_spring_of_its_joint_would_do_as_well(number, question, answer, irb4600):
    """A tracker tells them apart by where the tool turns, as far as calibration leaves that open."""
    one = hidden(irb4600, "link_flexibility", "j2", compliance=5e-7)
    found = answer(question(number, one))
    assert outcome(found, [one]) in ("right", "tie"), found.sentence
    assert [(cause.effect, cause.joint) for cause in found.causes] == [("link_flexibility", "j2")]
    assert {(rival.effect, rival.joint) for rival in found.rivals if rival.tied} <= {("joint_stiffness", "j2")}


@pytest.mark.slow
def test_both_of_a_pair_are_named(question, answer, irb4600):
    both = (hidden(irb4600, "load_friction", "j2", share=0.06), hidden(irb4600, "coulomb_level", "j5", change=0.2))
    assert outcome(answer(question(20, *both)), both) == "right"


@pytest.mark.slow
def test_a_quiet_cause_beside_a_loud_one_that_ties_is_named_and_no_pattern_is_left_of_either(question, answer, irb4600):
    """A tool that sits deeper is a longer last link; what either explains is not unknown."""
    both = (
        hidden(irb4600, "tool_frame", offset=[-1e-4, 3e-5, 3e-4]),
        hidden(irb4600, "flexible_load", "j3", inertia=2.0, frequency=31.5, damping=0.15),
    )
    found = answer(question(25, *both, row="pair"))
    assert found.verdict == "partly", found.sentence
    assert [(cause.effect, cause.joint) for cause in found.causes] == [("flexible_load", "j3")]
    assert "tool_frame" in {rival.effect for rival in found.rivals if rival.tied}
    assert not [pattern for pattern in found.patterns if pattern.channel == "tool"], found.sentence


def outsiders(robot):
    """Effects that the library cannot express."""
    return {
        "vibration": hidden(robot, "floor_vibration", "j3", share=0.12, frequency=17.0, phase=0.5),
        "other joint": hidden(robot, "rubbing_hose", "j2", share=pair(robot, "j2", "j4", 0.25), phase=0.7),
        "oil": hidden(robot, "stirred_oil", "j2", share=pair(robot, "j2", "j1", 0.08), speed=13.0),
    }


@pytest.mark.slow
@pytest.mark.parametrize("what", ["vibration", "oil", "other joint"])
def test_what_no_effect_explains_is_unknown_and_described(what, question, answer, irb4600):
    one = outsiders(irb4600)[what]
    found = answer(question(21, one))
    assert found.verdict in ("unknown", "partly"), found.sentence
    assert finds(one.clue(irb4600), found.patterns, one.joint, irb4600.joints), [
        pattern.message for pattern in found.patterns
    ]


@pytest.mark.slow
def test_small_circles_alone_name_nothing_that_is_not_there(question, answer, irb4600):
    one = hidden(irb4600, "backlash", "j2", half_gap=5e-5)
    found = answer(question(22, one, row="poor"))
    assert outcome(found, [one]) not in ("wrong", "surplus"), found.sentence


@pytest.mark.slow
def test_small_circles_of_a_faultless_machine_name_nothing(question, answer):
    assert answer(question(24, row="poor")).verdict == "none"


@pytest.mark.slow
def test_without_a_tracker_causes_that_only_it_shows_are_not_judged(question, answer, irb4600):
    one = hidden(irb4600, "tool_frame", offset=[1e-3, 0.0, 5e-4])
    found = answer(question(23, one, row="no_tracker", lacks=("tcp",)))
    assert found.verdict == "none", found.sentence
    assert "tool_frame" in {unjudged.effect for unjudged in found.not_judgeable}
