"""Patterns lead to the effects that have their form, with the reason why each is no cause."""

from dataclasses import replace
from typing import get_args

import pytest

from ffgym.diagnosis.excitation import add_leads, find_effects_of_form
from ffgym.diagnosis.result import Pattern, PatternKind, UnjudgedEffect
from ffgym.effects import EFFECTS
from tests.diagnosis.result_samples import full_diagnosis

PATTERN = Pattern(
    channel="torque",
    component="j2",
    variable="load",
    kind="sign-locked function",
    frequency=None,
    amplitude=0.1,
    share=0.4,
    message="torque of j2: a function of the load, times the sign of the motor speed",
)


def leads(pattern, causes=(), rivals=(), not_excited=(), not_judgeable=()):
    (found,) = add_leads([pattern], causes, rivals, not_excited, not_judgeable)
    return " ".join(found.leads)


def test_every_form_of_an_effect_is_one_that_patterns_have():
    assert {kind for effect in EFFECTS.values() for kind, _ in effect.patterns} <= set(get_args(PatternKind))


@pytest.mark.parametrize(
    ("kind", "variable", "effects"),
    [
        ("function", "motor speed", ["viscous_level", "nonlinear_viscous", "asymmetry"]),
        ("function", "load", ["torque_constant", "payload"]),
        ("periodic", "motor angle", ["cogging", "torque_ripple", "kinematic_error", "resolver_ripple"]),
        ("line", "time", []),
    ],
)
def test_the_effect_whose_form_is_nearest_comes_first(kind, variable, effects):
    found = find_effects_of_form(replace(PATTERN, kind=kind, variable=variable))
    assert [effect.name for effect in found] == effects


def test_a_pattern_with_the_form_of_an_effect_says_why_that_was_not_judged():
    reason = "the joints are described as rigid"
    said = leads(PATTERN, not_judgeable=[UnjudgedEffect(effect="load_friction", joint="", reason=reason)])
    assert said == f"load-dependent friction: {reason}"
    elsewhere = leads(PATTERN, not_excited=[UnjudgedEffect(effect="load_friction", joint="j5", reason="quiet")])
    assert "chance" in elsewhere


def test_a_cause_and_a_rival_of_that_form_say_so():
    full = full_diagnosis()
    cause = replace(full.causes[0], effect="load_friction", joint="j2")
    assert "it is a cause" in leads(PATTERN, causes=[cause])
    rival = replace(full.rivals[0], effect="load_friction", joint="j2", reason="leaves 3 times the energy")
    assert "leaves 3 times the energy" in leads(PATTERN, rivals=[rival])


def test_what_depends_on_another_joint_leads_to_no_effect_of_its_own():
    assert leads(replace(PATTERN, variable="load of j3")) == ""
