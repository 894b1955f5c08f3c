"""A model that is written pays for the numbers that it moves, and for none that only say how rows were written."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.fit import written as module
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.problem import HELD
from ffgym.diagnosis.fit.written import _Extension, _Model
from ffgym.effects import EFFECTS

ENERGY = np.array([3.0, 5.0, 7.0])
"""Energy that is left in three blocks, the last of which is not fitted to."""


@pytest.fixture
def extension(monkeypatch):
    """An extension of two numbers of the machine and one of the clock, with a cause; replays leave `ENERGY`."""
    cause = Hypothesis(kind=EFFECTS["load_friction"], joint="j1", source=None, values={"share": np.array(0.1)})
    of = [EFFECTS["torque_constant"], EFFECTS["coulomb_level"], EFFECTS["torque_clock"]]
    problem = SimpleNamespace(
        nuisances=[SimpleNamespace(column=SimpleNamespace(effect=effect)) for effect in of],
        design=SimpleNamespace(form_equations=lambda residual: SimpleNamespace(energy=ENERGY)),
    )
    fit = SimpleNamespace(n_nuisances=3, run=None, hypotheses=(cause,))
    monkeypatch.setattr(module, "split_components", lambda residual: residual)
    monkeypatch.setattr(module, "possible_numbers", lambda problem, sizes: None if sizes[0] > 5 else sizes)
    monkeypatch.setattr(
        module, "replay_hypotheses", lambda problem, hypotheses, numbers, run: SimpleNamespace(residual={})
    )
    chosen = np.array([True, True, False])
    begun = _Model(sizes=np.zeros(3), hypotheses=(cause,), cost=np.inf, compute_equations=lambda: None)
    return _Extension(problem=problem, fit=fit, chosen=chosen), begun


def test_a_model_costs_what_it_leaves_and_what_its_numbers_moved_by(extension):
    slope, begun = extension
    there = slope.move(begun, np.array([0.5, -2.0, 3.0, 1.0]))
    np.testing.assert_array_equal(there.sizes, [0.5, -2.0, 0.0])  # a clock is how rows were written
    assert slope.cost(there) == pytest.approx(8.0 + 0.25 + 4.0)
    (free,) = begun.hypotheses[0].list_free()
    assert float(there.hypotheses[0].values["share"]) == pytest.approx(0.1 + free.step)


def test_a_number_that_hardly_moved_stays(extension):
    slope, begun = extension
    there = slope.move(begun, np.array([0.5 * HELD, -2.0 * HELD, 0.0, 0.0]))
    assert (there.sizes[0], there.sizes[1]) == (0.0, -2.0 * HELD)


def test_where_no_machine_can_be_there_is_no_model(extension):
    slope, begun = extension
    assert slope.move(begun, np.array([6.0, 0.0, 0.0, 0.0])) is None
