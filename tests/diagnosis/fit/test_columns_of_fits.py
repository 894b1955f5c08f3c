"""Columns of a fit are found again by their cause, and what is sought along a line acts on springs."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.fit import refine as module
from ffgym.diagnosis.fit.fit import Fit
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.refine import _on_springs, refine
from ffgym.diagnosis.settings import settings
from ffgym.effects import EFFECTS


def cause(name, joint="j1", null=()):
    values = {p.name: np.array(p.high) for p in EFFECTS[name].parameters().values()}
    return Hypothesis(kind=EFFECTS[name], joint=joint, source=None, values=values, null=frozenset(null))


def test_tangents_of_a_cause_are_found_whatever_its_place():
    causes = cause("cogging"), cause("load_friction"), cause("cogging", "j2")
    counts = [len(one.list_free()) for one in causes]
    columns = tuple(range(sum(counts)))
    found = SimpleNamespace(hypotheses=causes, columns=columns)
    ends = np.cumsum([0, *counts])
    for k, one in enumerate(causes):
        assert Fit.find_tangents(found, one.scale(0.5)) == columns[ends[k] : ends[k + 1]]
    assert Fit.find_tangents(found, cause("cogging", "j3")) == ()
    assert Fit.find_tangents(found, causes[0].fix_at_null("amplitude")) == ()


@pytest.mark.parametrize(
    ("name", "acts"),
    [
        ("joint_stiffness", True),
        ("backlash", True),
        ("cogging", False),  # a torque of the motor
        ("payload", False),  # a load, whatever the springs
        ("coulomb_level", False),
    ],
)
def test_effects_on_springs_are_sought_along_a_line(name, acts):
    assert _on_springs(cause(name)) is acts


def test_friction_behind_springs_is_not_sought_along_a_line():
    behind = [kind for kind in EFFECTS.values() if kind.needs_elasticity and kind.needs_friction]
    assert behind
    assert not any(_on_springs(cause(kind.name)) for kind in behind)


@pytest.mark.parametrize(("how", "rest"), [({}, settings().estimator.rest), ({"roughly": True}, np.inf)])
def test_a_fit_goes_on_until_its_numbers_rest_unless_only_its_energy_is_wanted(monkeypatch, how, rest):
    begun, asked = Fit.__new__(Fit), []
    object.__setattr__(begun, "hypotheses", (cause("cogging"),))
    monkeypatch.setattr(module, "descend", lambda slope, start, steps: asked.append(steps) or start)
    assert refine(None, begun, **how) is begun
    (steps,) = asked
    assert steps.rest == rest
    limits = settings().estimator
    wanted = (limits.steps, limits.reach, limits.least_reach, limits.gain)
    assert (steps.most, steps.reach, steps.least_reach, steps.gain) == wanted
