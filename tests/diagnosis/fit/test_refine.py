"""Fits begin and are refined where they should: at good values, along lines where effects act on springs."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.fit import refine as module
from ffgym.diagnosis.fit.fit import Fit, Trial
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.refine import _choose_start, _Hypotheses, correct_bias, fit, polish
from ffgym.diagnosis.solving import Priors
from ffgym.effects import EFFECTS


def cause(name, joint="j1", **values):
    return Hypothesis(kind=EFFECTS[name], joint=joint, source=None, values={k: np.array(v) for k, v in values.items()})


SPRING, FRICTION = cause("joint_stiffness", change=-0.2), cause("load_friction", share=0.1)


def fit_of(*hypotheses, left=1.0, run=None, **more):
    known = {"columns": (), "equations": None, "priors": None, "numbers": None, "residual": {}} | more
    return Fit(hypotheses=hypotheses, left=left, run=run, **known)


def test_a_step_of_free_numbers_ends_at_its_reach_or_at_their_bounds():
    """One calibration error, then two free numbers; sums over two blocks."""
    gram, moment = np.stack([np.eye(3), np.eye(3)]), np.array([[2.0, 5.0, -5.0], [8.0, 5.0, -5.0]])[..., None]
    priors = Priors(precision=np.zeros(3), low=np.array([-9.0, -9.0, -3.0]), high=np.array([9.0, 4.0, 9.0]))
    point = fit_of(columns=({}, {}), equations=SimpleNamespace(gram=gram, moment=moment), priors=priors)
    slope = _Hypotheses(problem=None, like=None)
    np.testing.assert_allclose(slope.step(point, np.inf), [4.0, -3.0])
    np.testing.assert_allclose(slope.step(point, 2.0), [2.0, -2.0])
    np.testing.assert_allclose(slope.step(point, 3.5), [3.5, -3.0])
    assert slope.cost(point) == point.left


def test_where_slopes_cannot_be_computed_there_are_none(monkeypatch):
    slope, asked = _Hypotheses(problem="problem", like="like"), []
    monkeypatch.setattr(module, "add_tangents", lambda *given: asked.append(given) or "slopes")
    assert slope.renew("point", is_last=False) == "slopes"
    assert asked == [("problem", "point", "like")]

    def fail(*_):
        raise FFGymError("no")

    monkeypatch.setattr(module, "add_tangents", fail)
    assert slope.renew("point", is_last=False) is None


@pytest.mark.parametrize("begun", [False, True])
def test_the_newest_hypothesis_begins_at_the_best_of_several_sizes_unless_it_is_good_already(monkeypatch, begun):
    monkeypatch.setattr(module, "_choose_start", lambda problem, given: ["chosen", *given])
    monkeypatch.setattr(module, "evaluate", lambda problem, given, like: (problem, given, like))
    monkeypatch.setattr(module, "refine", lambda problem, at, like: at)
    given = ["given"] if begun else ["chosen", "given"]
    assert fit("problem", ["given"], begun=begun, like="like") == ("problem", given, "like")


def test_a_fit_does_not_count_as_begun_unless_it_is_said(monkeypatch):
    monkeypatch.setattr(module, "_choose_start", lambda problem, given: "chosen")
    monkeypatch.setattr(module, "evaluate", lambda problem, given, like: given)
    monkeypatch.setattr(module, "refine", lambda problem, at, like: at)
    assert fit(None, []) == "chosen"


def test_only_the_newest_hypothesis_is_tried_at_several_sizes(monkeypatch):
    """What is left is least with half of the change."""
    tried = []

    def left(problem, hypotheses):
        tried.append(hypotheses)
        return (float(hypotheses[-1].values["change"]) + 0.12) ** 2

    monkeypatch.setattr(module, "compute_rss", left)
    other = cause("joint_stiffness", "j2", change=0.3)
    begun = _choose_start(None, [other, FRICTION, SPRING])
    assert begun[:2] == [other, FRICTION]
    assert len(begun) == 3
    assert float(begun[2].values["change"]) == pytest.approx(-0.12)
    assert all(each[:2] == [other, FRICTION] and len(each) == 3 for each in tried)


def test_hypotheses_that_are_not_on_springs_begin_as_they_are(monkeypatch):
    monkeypatch.setattr(module, "compute_rss", None)  # nothing is replayed
    assert _choose_start(None, [SPRING, FRICTION]) == [SPRING, FRICTION]
    assert _choose_start(None, []) == []


@pytest.mark.parametrize("best", [0.8, 1.0, 1.25])
def test_a_size_near_the_best_is_found_along_a_line(monkeypatch, best):
    tried = []

    def left(problem, hypotheses):
        assert hypotheses[:-1] == [FRICTION]
        tried.append(float(hypotheses[-1].values["change"]) / -0.2)
        return 1e-3 + np.log(tried[-1] / best) ** 2

    monkeypatch.setattr(module, "compute_rss", left)
    monkeypatch.setattr(module, "fit", lambda problem, hypotheses, begun: (hypotheses, begun))
    hypotheses, begun = polish(None, fit_of(FRICTION, SPRING))
    assert begun is True
    assert hypotheses[0] is FRICTION
    assert float(hypotheses[1].values["change"]) == pytest.approx(-0.2 * best, rel=0.01)
    assert len(tried) < 30  # each takes a replay


@pytest.mark.parametrize("best", [0.4, 2.5])
def test_a_size_is_sought_nearby_only(monkeypatch, best):
    """One that is far off is another minimum, of an arm that swings with another phase."""
    tried = []

    def left(problem, hypotheses):
        tried.append(float(hypotheses[-1].values["change"]) / -0.2)
        return np.log(tried[-1] / best) ** 2

    monkeypatch.setattr(module, "compute_rss", left)
    polish(None, fit_of(SPRING, left=0.0))
    assert 0.7 < min(tried) < max(tried) < 1.4


def test_a_fit_stays_where_a_line_leads_no_further_down_or_to_no_fit(monkeypatch):
    monkeypatch.setattr(module, "compute_rss", lambda problem, hypotheses: 1.0)

    def fail(problem, hypotheses, begun):
        raise FFGymError("no")

    monkeypatch.setattr(module, "fit", fail)
    for found in (fit_of(SPRING, left=1.0), fit_of(SPRING, left=0.5), fit_of(SPRING, left=2.0)):
        assert polish(None, found) is found
    monkeypatch.setattr(module, "fit", lambda problem, hypotheses, begun: "another")
    for left in (0.5, 1.0):
        found = fit_of(SPRING, left=left)
        assert polish(None, found) is found
    assert polish(None, fit_of(SPRING, left=1.1)) == "another"
    for hypotheses in ((), (SPRING, FRICTION)):
        found = fit_of(*hypotheses, left=2.0)
        assert polish(None, found) is found


class Biased:
    """A problem that tells the bias that it is given."""

    log = SimpleNamespace(robot=None)

    def with_bias(self, bias):
        return "with", bias


@pytest.fixture
def corrected(monkeypatch):
    """A function that corrects a fit that leaves 1, by another that leaves so much; True if that one counts."""

    def correct(left, simulated=True):
        asked = []
        exact = SimpleNamespace(simulated=simulated, recordings="clean")
        monkeypatch.setattr(module, "make_clean_recordings", lambda log, run: exact)
        monkeypatch.setattr(module, "assemble_log", lambda robot, recordings, like: recordings)
        monkeypatch.setattr(module, "replay", lambda log, machine: machine)
        monkeypatch.setattr(module, "predict", lambda run: run)
        monkeypatch.setattr(module, "compute_residuals", lambda log, predicted: (log, predicted))
        monkeypatch.setattr(module, "keep_replay", lambda problem, found: asked.append(found))
        again = fit_of(SPRING, left=left)

        def fit_again(problem, hypotheses, begun):
            assert problem == ("with", ("clean", "machine"))
            assert (hypotheses, begun) == ((SPRING,), True)
            return again

        monkeypatch.setattr(module, "fit", fit_again)
        found = fit_of(SPRING, run=SimpleNamespace(machine="machine"))
        then = correct_bias(Biased(), found)
        assert then in (found, again)
        assert asked == ([found] if simulated else [])
        return then is again

    return correct


def test_a_fit_without_bias_counts_if_less_is_left(corrected):
    assert corrected(left=0.9)
    assert not corrected(left=1.0)
    assert not corrected(left=1.1)
    assert not corrected(left=0.9, simulated=False)


def test_nothing_is_simulated_of_a_fit_without_hypotheses(monkeypatch):
    monkeypatch.setattr(module, "make_clean_recordings", None)
    found = fit_of(run=SimpleNamespace(machine="machine"))
    assert correct_bias(Biased(), found) is found


def test_a_move_replays_hypotheses_by_practical_steps(monkeypatch):
    monkeypatch.setattr(module, "replay_hypotheses", lambda problem, hypotheses: hypotheses)
    point = Trial(numbers=None, hypotheses=(FRICTION,), run=None, residual={}, left=1.0)
    (moved,) = _Hypotheses(problem=None, like=None).move(point, np.array([0.5]))
    (free,) = FRICTION.list_free()
    assert float(moved.values["share"]) == pytest.approx(0.1 + 0.5 * free.step)
