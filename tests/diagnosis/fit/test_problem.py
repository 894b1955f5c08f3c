"""A number that is a cause is no calibration error beside it: a fit would trade one for the other."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.problem import HELD, FitProblem
from ffgym.diagnosis.nuisance import NuisanceParameter, RowOffset
from ffgym.diagnosis.sensitivity import Sensitivity
from ffgym.diagnosis.settings import settings
from ffgym.effects import EFFECTS


@pytest.mark.parametrize(
    ("effect", "n_joints", "is_held"),
    [("torque_delay", 1, True), ("torque_delay", 6, False), ("torque_clock", 6, True), ("asymmetry", 1, False)],
)
def test_the_instant_of_torque_in_a_row_is_held_where_a_cause_makes_all_torque_late(effect, n_joints, is_held):
    kind = EFFECTS[effect]
    values = {p.name: np.array(p.high) for p in kind.parameters().values()}
    cause = Hypothesis(kind=kind, joint="j1", source=None, values=values)
    column = Sensitivity(effect=RowOffset, parameter="latency", parts={})
    setting = SimpleNamespace(
        nuisances=(NuisanceParameter(column=column, sigma=5e-5),),
        log=SimpleNamespace(robot=SimpleNamespace(n_joints=n_joints)),
    )
    priors = FitProblem.nuisance_priors(setting, [cause])
    assert bool(priors.low == -HELD and priors.high == HELD) == is_held


@pytest.mark.parametrize(("energy", "left"), [(None, 0.0), (0.6, 0.0), (1.0, 0.0), (201.0, 2.0)])
def test_a_model_with_other_numbers_may_leave_a_hundredth_of_what_they_explain(energy, left):
    described = {} if energy is None else {("torque", 0): energy}
    setting = SimpleNamespace(described=described)
    assert FitProblem.inexact(setting, ("torque", 0)) == pytest.approx(left)
    assert FitProblem.inexact(setting, ("torque", 1)) == 0.0


def test_certain_is_what_is_left_of_noise_without_uncertainty_of_single_rows():
    """Rows that do not count, as of no block or no weight, do not count here either."""
    weights = np.array([[0.5, 2.0, 0.0, 4.0, 4.0]])
    setting = SimpleNamespace(
        floor={"torque": np.array([[2.0, 0.4], [0.25, 0.4], [9.0, 0.4], [0.125, 0.4], [9.0, 0.4]])},
        weights={("torque", 0): weights, ("torque", 1): np.zeros((1, 5)), ("tool", 0): weights},
        blocks=SimpleNamespace(of_row=np.array([[0, 0, 1, 1, -1]])),
    )
    assert FitProblem.certain(setting, ("torque", 0)) == pytest.approx((1.0 + 0.25 + 0.25) / 3)
    assert FitProblem.certain(setting, ("torque", 1)) == 0.0
    assert FitProblem.certain(setting, ("tool", 0)) == 1.0  # nothing is known of single rows


def test_columns_without_parameters_are_bounded_as_all_priors_are():
    setting = SimpleNamespace(nuisances=(), nuisance_columns=({}, {}))
    priors = FitProblem.nuisance_priors(setting)
    bound = settings().prior.bound
    np.testing.assert_array_equal(priors.low, [-bound, -bound])
    np.testing.assert_array_equal(priors.high, [bound, bound])
    np.testing.assert_array_equal(priors.precision, [1.0, 1.0])
