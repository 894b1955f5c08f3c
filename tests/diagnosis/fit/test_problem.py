"""A number that is a cause is no calibration error beside it: a fit would trade one for the other."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.problem import HELD, FitProblem, is_parameter_of, split_components
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


@pytest.mark.parametrize(("energy", "left"), [(None, 0.0), (0.6, 0.0), (1.0, 0.0), (1.5, 0.005), (201.0, 2.0)])
def test_a_model_with_other_numbers_may_leave_a_hundredth_of_what_they_explain(energy, left):
    described = {} if energy is None else {("torque", 0): energy}
    setting = SimpleNamespace(described=described)
    assert FitProblem.inexact(setting, ("torque", 0)) == pytest.approx(left)
    assert FitProblem.inexact(setting, ("torque", 1)) == 0.0


def test_what_is_held_is_far_within_the_errors_that_numbers_have():
    assert 0.0 < HELD < 1e-3


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


def cause(name, joint="j1", null=(), **values):
    values = {key: np.array(value) for key, value in values.items()}
    return Hypothesis(kind=EFFECTS[name], joint=joint, source=None, values=values, null=frozenset(null))


def doubt(name, parameter, joint="j1", part=None, **places):
    column = Sensitivity(effect=EFFECTS[name], joint=joint, parameter=parameter, part=part, parts={})
    return NuisanceParameter(column=column, **places)


def test_a_doubt_is_a_number_of_a_cause_of_its_effect_on_its_joint():
    one = doubt("coulomb_level", "change", sigma=0.05)
    assert is_parameter_of(one, cause("coulomb_level", change=0.1), 6)
    assert not is_parameter_of(one, cause("coulomb_level", "j2", change=0.1), 6)
    assert not is_parameter_of(one, cause("viscous_level", change=0.1), 6)
    assert not is_parameter_of(one, cause("coulomb_level", null=["change"], change=0.0), 6)  # it stays, so the doubt is


def test_only_a_doubt_that_is_a_number_of_a_cause_is_held():
    doubts = doubt("coulomb_level", "change", sigma=0.05), doubt("coulomb_level", "change", "j2", sigma=0.05, at=1.0)
    setting = SimpleNamespace(nuisances=doubts, log=SimpleNamespace(robot=SimpleNamespace(n_joints=6)))
    priors = FitProblem.nuisance_priors(
        setting, [cause("load_friction", share=0.1), cause("coulomb_level", change=0.1)]
    )
    bound = settings().prior.bound
    np.testing.assert_allclose(priors.low, [-HELD, -bound - 1.0])
    np.testing.assert_allclose(priors.high, [HELD, bound - 1.0])
    np.testing.assert_array_equal(priors.precision, [1.0, 1.0])
    free = FitProblem.nuisance_priors(setting)
    np.testing.assert_allclose(free.low, [-bound, -bound - 1.0])


def test_causes_are_told_of_the_machine_as_it_is_described():
    """Shares are of shares: 10 % more of 5 % more is 15.5 % more. Numbers with units add up."""
    doubts = (
        doubt("coulomb_level", "change", sigma=0.02, at=2.5),
        doubt("torque_offset", "offset", sigma=0.5, at=-0.2),
        doubt("tool_frame", "offset", "", part=1, sigma=1e-3, at=3.0),
    )
    setting = SimpleNamespace(nuisances=doubts, log=SimpleNamespace(robot=SimpleNamespace(n_joints=6)))
    given = (
        cause("coulomb_level", change=0.1),
        cause("torque_offset", offset=0.3),
        cause("coulomb_level", "j2", change=0.1),
        cause("tool_frame", "", offset=np.full(3, 1e-3)),
        cause("torque_offset", null=["offset"], offset=0.0),
    )
    found = FitProblem.as_described(setting, given)
    assert [one.key for one in found] == [one.key for one in given]
    values = [next(iter(one.values.values())) for one in found]
    np.testing.assert_allclose(values[:3], [1.1 * 1.05 - 1, 0.3 - 0.1, 0.1])
    np.testing.assert_allclose(values[3], 1e-3)
    assert values[4] == 0.0
    assert float(given[0].values["change"]) == 0.1


def test_residuals_are_split_by_component():
    torque, tool = np.arange(24.0).reshape(4, 3, 2), np.arange(36.0).reshape(4, 3, 3)
    found = split_components({"torque": torque, "tool": tool})
    assert list(found) == [("torque", 0), ("torque", 1), ("tool", 0), ("tool", 1), ("tool", 2)]
    for (channel, c), rows in found.items():
        np.testing.assert_array_equal(rows, {"torque": torque, "tool": tool}[channel][:, :, [c]])
