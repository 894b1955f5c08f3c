"""Causes that numbers of the machine make up for, once they are fitted beside the other causes."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.procedure import names_fewer
from ffgym.effects import EFFECTS
from tests.diagnosis.result_samples import full_diagnosis


def hypothesis(effect, joint):
    return Hypothesis(kind=EFFECTS[effect], joint=joint, source=None, values={"share": np.array(0.1)})


BEFORE = (hypothesis("arm_friction", "j2"), hypothesis("load_friction", "j3"))


@pytest.mark.parametrize(
    ("verdict", "named", "is_fewer"),
    [
        ("named", [("arm_friction", "j2")], True),
        ("partly", [("arm_friction", "j2")], False),
        ("named", [("arm_friction", "j2"), ("load_friction", "j3")], False),
        ("named", [("arm_friction", "j3")], False),
        ("named", [("backlash", "j2")], False),
    ],
)
def test_a_diagnosis_about_other_numbers_replaces_one_with_more_causes_if_it_names_some_of_them(
    verdict, named, is_fewer
):
    found = full_diagnosis()
    causes = tuple(replace(found.causes[0], effect=effect, joint=joint) for effect, joint in named)
    assert names_fewer(replace(found, verdict=verdict, causes=causes), BEFORE) is is_fewer
