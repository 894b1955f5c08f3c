"""Causes that numbers of the machine make up for, once they are fitted beside the other causes."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from ffgym.diagnosis import passes
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.passes import Examination, PassResult
from ffgym.effects import EFFECTS
from tests.diagnosis.result_samples import full_diagnosis


def hypothesis(effect, joint):
    return Hypothesis(kind=EFFECTS[effect], joint=joint, source=None, values={"share": np.array(0.1)})


@dataclass
class OnePass:
    """Pass whose next search is known."""

    ready: str = "as before"
    rng: None = None
    then: PassResult | None = None

    def report(self, what, share):
        """Tell nothing."""

    def search(self):
        """Return what is known, above the louder floor."""
        assert self.ready == "louder"
        return self.then


def pass_result(diagnosis, causes):
    examination = Examination(diagnosis=diagnosis, before=None, after=None, machine=None, nominal=None)
    return PassResult(of=OnePass(), model=None, examination=examination, causes=causes)


BEFORE = (hypothesis("arm_friction", "j2"), hypothesis("load_friction", "j3"))


@pytest.mark.parametrize(
    ("verdict", "named", "is_fewer", "is_explained"),
    [
        ("named", [("arm_friction", "j2")], True, True),
        ("partly", [("arm_friction", "j2")], False, False),
        ("named", [("arm_friction", "j2"), ("load_friction", "j3")], False, True),
        ("named", [("arm_friction", "j3")], False, False),
        ("named", [("backlash", "j2")], False, False),
    ],
)
def test_another_pass_replaces_one_if_it_names_some_of_its_causes(monkeypatch, verdict, named, is_fewer, is_explained):
    """Numbers beside causes must make one needless; noise beside them must leave nothing."""
    sample = full_diagnosis()
    causes = tuple(replace(sample.causes[0], effect=effect, joint=joint) for effect, joint in named)
    before = pass_result(replace(sample, verdict="partly"), BEFORE)
    after = pass_result(replace(sample, verdict=verdict, causes=causes), ())
    assert (before.replace_by_fewer(after) is after) is is_fewer
    monkeypatch.setattr(passes, "renew_floor", lambda ready, model, rng: "louder")
    before.of.then = after
    assert (before.search_above_noise() is after) is is_explained


@pytest.mark.parametrize(("verdict", "floor"), [("named", "louder"), ("none", "louder"), ("partly", None)])
def test_nothing_is_searched_again_without_a_louder_floor_and_something_left(monkeypatch, verdict, floor):
    before = pass_result(replace(full_diagnosis(), verdict=verdict), BEFORE)
    monkeypatch.setattr(passes, "renew_floor", lambda ready, model, rng: floor)
    assert before.search_above_noise() is before
