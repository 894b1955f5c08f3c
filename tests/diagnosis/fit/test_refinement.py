"""Steps of a fit within its bounds, sizes that are sought along a line, and fits that stay as they are."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.fit import refine as module
from ffgym.diagnosis.fit.fit import Fit
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.refine import correct_bias, polish
from ffgym.diagnosis.solving import Priors
from ffgym.effects import EFFECTS


def cause(name, joint="j1", share=1.0):
    values = {p.name: np.array(share * p.high) for p in EFFECTS[name].parameters().values()}
    return Hypothesis(kind=EFFECTS[name], joint=joint, source=None, values=values)


def a_fit(**of):
    """A fit with these fields alone."""
    found = Fit.__new__(Fit)
    for name, value in of.items():
        object.__setattr__(found, name, value)
    return found


def test_a_step_goes_no_further_than_its_reach_and_leaves_the_calibration_free(monkeypatch):
    priors = Priors(
        precision=np.array([1.0, 1.0, 0.5, 0.5]),
        low=np.array([-9.0, -8.0, -0.2, -5.0]),
        high=np.array([9.0, 7.0, 6.0, 0.1]),
    )
    asked = []

    def solve(equations, places, bounded):
        asked.append((equations, places.tolist(), bounded))
        return np.array([1.0, 2.0, 3.0, 4.0])

    monkeypatch.setattr(module, "solve", solve)
    point = a_fit(priors=priors, columns=(None, None), equations="equations")
    step = module._Hypotheses(problem=None, like=None).step(point, 0.5)
    assert step.tolist() == [3.0, 4.0]
    ((equations, places, bounded),) = asked
    assert (equations, places) == ("equations", [0, 1, 2, 3])
    assert bounded.low.tolist() == [-9.0, -8.0, -0.2, -0.5]
    assert bounded.high.tolist() == [9.0, 7.0, 0.5, 0.1]
    assert bounded.precision is priors.precision


@pytest.fixture
def sought(monkeypatch):
    """Polish of a fit whose newest size leaves least at `best` times itself; tells what was fitted again."""
    again = []

    def polished(hypotheses, best, left=1.0, fails=False):
        def rss(problem, tried):
            assert tried[:-1] == list(hypotheses[:-1])
            sizes = [float(one[-1].values["growth"]) for one in (tried, hypotheses)]
            return 0.5 + abs(np.log(sizes[0] / sizes[1] / best))

        def fit(problem, tried, *, begun):
            again.append((tried, begun))
            if fails:
                raise FFGymError("no such machine")
            return "again"

        monkeypatch.setattr(module, "compute_rss", rss)
        monkeypatch.setattr(module, "fit", fit)
        found = SimpleNamespace(hypotheses=tuple(hypotheses), left=left)
        result = polish(None, found)
        return "as it was" if result is found else result

    return polished, again


def test_the_size_of_an_effect_on_springs_is_sought_along_a_line_and_all_is_fitted_again(sought):
    polished, again = sought
    beside, spring = cause("cogging", "j2"), cause("hardening", share=0.2)
    assert polished([beside, spring], 1.2) == "again"
    ((tried, begun),) = again
    assert begun
    assert tried[0] is beside
    assert float(tried[1].values["growth"]) == pytest.approx(1.2 * float(spring.values["growth"]), rel=0.02)


def test_a_fit_stays_as_it_is_where_no_size_leaves_less_or_none_acts_on_springs(sought):
    polished, again = sought
    spring = cause("hardening", share=0.2)
    assert polished([spring], 1.2, left=0.4) == "as it was"
    assert polished([spring, cause("cogging", "j2")], 1.2) == "as it was"
    assert not again
    assert polished([spring], 1.2, fails=True) == "as it was"
    assert polish(None, nothing := SimpleNamespace(hypotheses=())) is nothing


def test_a_fit_begins_at_the_best_of_several_sizes_only_if_the_newest_acts_on_springs(monkeypatch):
    beside, spring = cause("cogging", "j2"), cause("hardening", share=0.01)
    growth = float(spring.values["growth"])
    monkeypatch.setattr(
        module, "compute_rss", lambda problem, tried: abs(float(tried[-1].values["growth"]) / growth - 1.5)
    )
    kept, begun = module._choose_start(None, [beside, spring])
    assert kept is beside
    assert float(begun.values["growth"]) == pytest.approx(1.5 * growth)
    assert module._choose_start(None, [spring, beside]) == [spring, beside]
    assert module._choose_start(None, []) == []


def test_a_fit_begins_where_its_hypotheses_are_if_it_has_begun(monkeypatch):
    monkeypatch.setattr(module, "_choose_start", lambda problem, hypotheses: "chosen")
    monkeypatch.setattr(module, "evaluate", lambda problem, hypotheses, like: (hypotheses, like))
    monkeypatch.setattr(module, "refine", lambda problem, begun, like: (*begun, like))
    assert module.fit(None, "given", like="like") == ("chosen", "like", "like")
    assert module.fit(None, "given", begun=True) == ("given", None, None)


@pytest.mark.parametrize(
    ("simulated", "left", "better"), [(True, 0.9, True), (True, 1.0, False), (True, None, False), (False, 0.9, False)]
)
def test_a_fit_without_the_bias_of_its_replay_takes_its_place_if_it_leaves_less(monkeypatch, simulated, left, better):
    """None is a fit that fails."""
    kept = []

    def fit(problem, hypotheses, *, begun):
        assert (problem, hypotheses, begun) == ("bias of replayed clean log", found.hypotheses, True)
        if left is None:
            raise FFGymError("no such machine")
        return SimpleNamespace(left=left)

    clean = SimpleNamespace(simulated=simulated, recordings="recordings")
    monkeypatch.setattr(module, "make_clean_recordings", lambda log, run: clean)
    monkeypatch.setattr(module, "assemble_log", lambda robot, recordings, like: "clean log")
    monkeypatch.setattr(module, "replay", lambda log, machine: f"replayed {log}")
    monkeypatch.setattr(module, "predict", lambda run: run)
    monkeypatch.setattr(module, "compute_residuals", lambda log, predicted: f"bias of {predicted}")
    monkeypatch.setattr(module, "keep_replay", lambda problem, fit: kept.append(fit))
    monkeypatch.setattr(module, "fit", fit)
    problem = SimpleNamespace(log=SimpleNamespace(robot=None), with_bias=lambda bias: bias)
    found = SimpleNamespace(hypotheses=(cause("cogging"),), run=SimpleNamespace(machine=None), left=1.0)
    again = correct_bias(problem, found)
    assert (again is not found) == better
    assert kept == [found] * simulated
