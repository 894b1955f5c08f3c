"""A hypothesis becomes a cause, a document, and the effect that it was: of all effects, whatever of them is null."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.diagnosis_file import diagnosis_document, parse_diagnosis
from ffgym.diagnosis.extended import build_effect
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.nuisance import ParameterPrior
from ffgym.diagnosis.result import Diagnosis
from ffgym.diagnosis.sizes import list_causes
from ffgym.diagnosis.solving import Priors
from ffgym.effects import EFFECTS
from ffgym.robot import load_robot

ROBOT = load_robot("two_link")


def hypothesis(kind):
    """An effect on the second joint, with all its numbers a third of the way through their plausible range."""
    known = kind.parameters()
    values = {}
    for name, p in known.items():
        value = p.low + (p.high - p.low) / 3
        values[name] = np.full(3, value) if p.per == "vector" else np.array(value)
    sizes = [p for p in known.values() if p.role == "size"]
    is_whole = all(p.per in ("machine", "vector") for p in sizes)
    source = 0 if any(p.per == "pair" for p in sizes) else None
    return Hypothesis(kind=kind, joint="" if is_whole else ROBOT.joints[1], source=source, values=values)


def cause_of(one):
    """The cause that a fit of one hypothesis gives, with hardly any doubt."""
    n = len(one.list_free())
    bound = np.full(n, 1e-3)
    evidence = SimpleNamespace(gram=np.ones((1, n, n)) * np.eye(n), moment=np.zeros((1, n, 1)))
    priors = Priors(precision=np.ones(n), low=-bound, high=bound)
    run = SimpleNamespace(robot=ROBOT, log=SimpleNamespace(dt=0.001))
    fit = SimpleNamespace(hypotheses=(one,), equations=evidence, priors=priors, n_nuisances=0, run=run)
    return list_causes(fit, (0.9,), ParameterPrior(), np.random.default_rng(0))[0]


def cases():
    """All effects as they are, and with each of their sizes at null for good."""
    for kind in EFFECTS.values():
        one = hypothesis(kind)
        sizes = [p.name for p in kind.parameters().values() if p.role == "size"]
        yield pytest.param(one, id=kind.name)
        for size in sizes if len(sizes) > 1 else ():
            yield pytest.param(one.fix_at_null(size), id=f"{kind.name} without {size}")


@pytest.mark.parametrize("one", list(cases()))
def test_a_cause_is_read_back_as_the_effect_that_was_fitted(one):
    found = Diagnosis(verdict="named", sentence="", robot="two_link", motions=("a",), causes=(cause_of(one),))
    document = json.loads(json.dumps(diagnosis_document(found)))
    (cause,) = parse_diagnosis(document).causes
    again, meant = build_effect(cause, ROBOT), one.effect(ROBOT)
    for name, p in one.kind.parameters().items():
        read, fitted = getattr(again, name), getattr(meant, name)
        if p.role == "size" or p.per in ("machine", "vector"):
            np.testing.assert_array_equal(read, fitted, err_msg=name)
        else:  # shapes of joints without the effect mean nothing
            np.testing.assert_array_equal(read[1], fitted[1], err_msg=name)
