"""Energies of residuals, what numbers of the calibration leave of them, and the components that a cause touches."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.fit import fit as module
from ffgym.diagnosis.fit.fit import Fit
from ffgym.diagnosis.settings import settings

ONE, OTHER, TOOL = ("torque", 0), ("torque", 1), ("tool", 0)


def test_the_energy_of_rows_is_that_of_each_row_that_counts():
    rows = np.array([[3.0, 4.0], [5.0, 6.0]])
    assert module.compute_row_energy(rows, np.array([2.0, 0.0])) == (36.0 + 100.0) / 2
    assert module.compute_row_energy(rows, np.array([[1.0, 0.0], [0.0, 0.5]])) == (9.0 + 9.0) / 2
    assert module.compute_row_energy(rows, np.zeros(2)) == 0.0


def test_loudness_is_energy_over_that_of_noise_by_component(monkeypatch):
    valid = np.array([[True, True], [True, False]])
    monkeypatch.setattr(module, "find_valid_rows", lambda log: valid)
    problem = SimpleNamespace(log=None, weights={ONE: np.array([1.0, 2.0]), OTHER: np.array([0.5, 0.5])})
    rest = {"torque": np.stack([np.array([[3.0, 1.0], [0.0, 9.0]]), np.full((2, 2), 4.0)], axis=2)}
    assert module.loudness(problem, rest) == {ONE: (9.0 + 4.0 + 0.0) / 3, OTHER: 4.0}


def test_the_excess_is_that_of_the_loudest_component_above_noise(monkeypatch):
    monkeypatch.setattr(module, "subtract_nuisances", lambda problem, fit: fit)
    monkeypatch.setattr(module, "loudness", lambda problem, rest: {ONE: 1.25, OTHER: 3.5, TOOL: 0.5})
    assert module.compute_excess(None, None) == 2.5


def test_what_no_machine_can_be_leaves_more_than_anything(monkeypatch):
    found = {"some": SimpleNamespace(left=7.0), "none": None}
    monkeypatch.setattr(module, "replay_hypotheses", lambda problem, name: found[name])
    assert module.compute_rss(None, "some") == 7.0
    assert module.compute_rss(None, "none") == np.inf
    monkeypatch.setattr(module, "replay_hypotheses", lambda problem, hypotheses: None)
    with pytest.raises(FFGymError, match="No machine can have a, b with these values"):
        module.evaluate(None, [SimpleNamespace(label="a"), SimpleNamespace(label="b")])


def test_a_cause_touches_components_with_a_notable_share_of_its_energy():
    share = settings().search.touched
    weights = {key: np.array(1.0) for key in (ONE, OTHER, TOOL)}
    problem = SimpleNamespace(weights=weights)

    def touched(one, other, tool, **how):
        energies = {ONE: one, OTHER: other, TOOL: tool}
        half = {key: np.full((4, 1), np.sqrt(value / 2)) for key, value in energies.items()}
        return module.find_touched(problem, [half, half], **how)  # of both columns together

    assert touched(1.0, 1.1 * share, 0.5 * share) == {ONE, OTHER}
    assert touched(1.0, 0.0, 1.0) == {ONE, TOOL}
    quiet = {"one": 1.0, "other": 1.1 * share / (1 - share), "tool": 1e-6}
    assert touched(**quiet) == {ONE, OTHER}
    assert touched(**quiet, by_channel=True) == {ONE, OTHER, TOOL}
    assert touched(1.0, 0.5 * share, 1.0, by_channel=True) == {ONE, TOOL}


@pytest.mark.parametrize("weight", [(1.0, 1.0), (1.0, 0.01)])
def test_weights_decide_what_a_cause_touches(weight):
    problem = SimpleNamespace(weights={ONE: np.array(weight[0]), OTHER: np.array(weight[1])})
    column = {ONE: np.ones((4, 1)), OTHER: np.ones((4, 1))}
    assert module.find_touched(problem, [column]) == ({ONE, OTHER} if weight[1] == 1.0 else {ONE})


def test_durations_of_a_session_are_not_fitted_anew_in_each_fold():
    flags = [(False, False), (True,), (False,)]  # of the free numbers of three hypotheses
    free = [
        SimpleNamespace(list_free=lambda own=own: [SimpleNamespace(of_session=one) for one in own]) for own in flags
    ]
    priors = SimpleNamespace(low=np.zeros(6))
    found = SimpleNamespace(hypotheses=free, columns=(None,) * 4, priors=priors)
    found.n_nuisances = Fit.n_nuisances.fget(found)
    assert found.n_nuisances == 2
    assert Fit.fold_columns.fget(found).tolist() == [0, 1, 2, 3, 5]
