"""What replayed hypotheses leave beside calibration, and which replays are made anew."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.fit import fit as module
from ffgym.diagnosis.fit.fit import (
    Fit,
    Trial,
    add_tangents,
    build_priors,
    compute_rss,
    evaluate,
    keep_replay,
    renew_tangents,
    replay_hypotheses,
)
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.normal_equations import build_design_matrix
from ffgym.diagnosis.resampling import cut_blocks
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.solving import Priors
from ffgym.effects import EFFECTS

ROWS, DT = 600, 0.01
TIME = DT * np.arange(ROWS)[:, None]
ONE, OTHER = ("torque", 0), ("torque", 1)


def cause(name="load_friction", joint="j1", **values):
    return Hypothesis(kind=EFFECTS[name], joint=joint, source=None, values={k: np.array(v) for k, v in values.items()})


@dataclass(frozen=True)
class Robot:
    """Numbers of a machine, told apart by what they are."""


@dataclass(frozen=True)
class Toy:
    """A machine with effects in place."""

    robot: Robot
    effects: tuple = ()


class Setting:
    """A problem of two joints with two columns of calibration, whose replays are known and counted."""

    def __init__(self, monkeypatch, bound=9.0):
        self.nominal, self.log, self.like = Toy(Robot()), None, "nominal replay"
        self.last_replays, self.replayed = {}, []
        self.columns = [{ONE: np.sin(TIME)}, {ONE: 0.5 * np.cos(3 * TIME), OTHER: np.cos(TIME)}]
        self.weights = {ONE: np.full(1, 2.0), OTHER: np.full(1, 0.5)}
        self.precision, self.bound = np.array([40.0, 9.0]), bound
        blocks = cut_blocks(np.ones((ROWS, 1), dtype=bool), DT)
        assert len(blocks) > 2
        self.design = build_design_matrix(blocks, self.columns, self.weights)
        self.bias = {"torque": np.full((ROWS, 1, 2), 0.25)}
        self.rows = {"torque": np.stack([np.sin(TIME) + 0.3 * TIME, np.cos(TIME) - TIME], axis=2)}
        monkeypatch.setattr(module, "build_machine", lambda numbers, causes: Toy(numbers.robot, tuple(causes)))
        monkeypatch.setattr(module, "replay", self.replay)
        monkeypatch.setattr(module, "predict", lambda run: run)
        monkeypatch.setattr(module, "compute_residuals", lambda log, run: self.rows)
        monkeypatch.setattr(module, "lends_deflection", lambda run, log, machine: False)

    def replay(self, log, machine, like, beside=None):
        self.replayed.append((machine.effects, like, beside))
        return SimpleNamespace(machine=machine, number=len(self.replayed))

    def nuisance_priors(self, causes=()):
        return Priors(precision=self.precision, low=np.full(2, -self.bound), high=np.full(2, self.bound))

    def weighted(self, channels):
        """Rows of both joints times their weights, one after the other."""
        return np.concatenate([channels.get(key, np.zeros((ROWS, 1))) * w for key, w in self.weights.items()])[:, 0]


@pytest.fixture
def setting(monkeypatch):
    return Setting(monkeypatch)


def test_what_is_left_is_the_energy_beside_calibration_with_what_its_prior_says_of_it(setting):
    """The same as of a ridge regression; the bias of replaying is taken off."""
    tried = replay_hypotheses(setting, [cause(share=0.1)])
    rest = {key: setting.rows["torque"][..., key[1]] - 0.25 for key in setting.weights}
    np.testing.assert_allclose(tried.residual["torque"], np.stack([rest[ONE], rest[OTHER]], axis=2))
    matrix = np.stack([setting.weighted(column) for column in setting.columns], axis=1)
    matrix, measured = np.vstack([matrix, np.diag(setting.precision**0.5)]), np.append(setting.weighted(rest), [0, 0])
    _, (left,), *_ = np.linalg.lstsq(matrix, measured, rcond=None)
    assert tried.left == pytest.approx(left)
    assert tried.machine.effects == tried.hypotheses
    assert (tried.numbers, tried.hypotheses[0].joint) == (setting.nominal, "j1")


def test_calibration_explains_no_more_than_its_bounds_let_it(monkeypatch):
    """Both numbers at a bound: energy of what is then left, with their squares times precisions."""
    setting = Setting(monkeypatch, bound=1e-3)
    tried = replay_hypotheses(setting, [])
    rest = setting.weighted({key: tried.residual["torque"][..., key[1]] for key in setting.weights})
    columns = [setting.weighted(column) for column in setting.columns]
    signs = [np.sign(column @ rest) for column in columns]
    rest = rest - sum(1e-3 * sign * column for sign, column in zip(signs, columns, strict=True))
    assert tried.left == pytest.approx(rest @ rest + 1e-6 * setting.precision.sum(), rel=1e-12)


def test_where_a_machine_cannot_be_or_move_there_is_no_trial(setting, monkeypatch):
    assert np.isfinite(compute_rss(setting, []))
    assert compute_rss(setting, []) == replay_hypotheses(setting, []).left
    with monkeypatch.context() as patch:
        patch.setattr(module, "build_machine", lambda numbers, causes: None)
        assert replay_hypotheses(setting, []) is None
        assert compute_rss(setting, []) == np.inf
        with pytest.raises(FFGymError, match="load_friction on j1"):
            evaluate(setting, [cause(share=0.1)])
    for wrong in (np.nan, np.inf, 1e200):  # the energy of the last is none
        setting.rows = {"torque": np.full((ROWS, 1, 2), wrong)}
        assert replay_hypotheses(setting, []) is None

    def unstable(run):
        raise FloatingPointError

    monkeypatch.setattr(module, "predict", unstable)
    assert replay_hypotheses(setting, []) is None


def test_the_last_replays_of_the_nominal_machine_are_not_made_again(setting):
    causes = [[cause(share=0.1 * k)] for k in range(1, 6)]
    runs = [replay_hypotheses(setting, each).run for each in causes]
    assert len(setting.replayed) == len(setting.last_replays) + len(causes) - module._KEPT == len(causes)
    for each, run in zip(causes[-module._KEPT :], runs[-module._KEPT :], strict=True):
        assert replay_hypotheses(setting, each).run is run
    assert len(setting.replayed) == len(causes)
    assert replay_hypotheses(setting, causes[0]).run is not runs[0]
    assert replay_hypotheses(setting, [cause(joint="j2", share=0.5)]).run is not runs[4]
    assert len(setting.last_replays) == module._KEPT >= 2  # a search asks for many of them twice


def test_a_replay_with_other_numbers_or_beside_another_is_made_anew_and_not_kept(setting):
    other, causes = Toy(Robot()), [cause(share=0.1)]
    tried = replay_hypotheses(setting, causes, other)
    assert tried.numbers is other
    replay_hypotheses(setting, causes, None, "beside")
    replay_hypotheses(setting, causes, other, "beside")
    assert [beside for _, _, beside in setting.replayed] == [None, "beside", "beside"]
    assert setting.last_replays == {}
    kept = replay_hypotheses(setting, causes).run
    assert replay_hypotheses(setting, causes, other).run is not kept
    assert replay_hypotheses(setting, causes, None, "beside").run is not kept
    keep_replay(setting, tried)
    assert replay_hypotheses(setting, causes).run is kept


def test_the_replay_of_a_fit_is_kept_as_the_newest(setting):
    first, *others = ([cause(share=0.1 * k)] for k in range(1, module._KEPT + 2))
    found = replay_hypotheses(setting, first)
    for each in others[:-1]:
        replay_hypotheses(setting, each)
    keep_replay(setting, found)
    replay_hypotheses(setting, others[-1])
    assert replay_hypotheses(setting, first).run is found.run


def test_a_replay_that_is_kept_may_tell_how_joints_bend_in_another(setting, monkeypatch):
    one, other, third = ([cause(share=0.1 * k)] for k in range(1, 4))
    run = replay_hypotheses(setting, one).run
    replay_hypotheses(setting, other)
    monkeypatch.setattr(module, "lends_deflection", lambda known, log, machine: known is run)
    replay_hypotheses(setting, third)
    assert [like for _, like, _ in setting.replayed] == ["nominal replay", "nominal replay", run]


@pytest.fixture
def tangents(monkeypatch):
    """Columns of all free numbers, the k-th of cause i as `10 i + k`; columns that are known stand as they are."""

    def compute(run, before, causes, known=None):
        known, found = known or {}, []
        for i, one in enumerate(causes):
            own = [{ONE: np.full((ROWS, 1), 10.0 * i + k)} for k in range(len(one.list_free()))]
            found += known.get(i, own)
        return found

    monkeypatch.setattr(module, "compute_tangents", compute)
    return compute


def test_a_fit_has_columns_of_calibration_first_and_then_of_all_free_numbers(setting, tangents):
    causes = [cause("cogging", amplitude=0.02, cycles=6.0, phase=0.5), cause(share=0.1)]
    found = evaluate(setting, causes)
    assert len(found.columns) == 4
    assert found.n_nuisances == 2
    values = [0.0, 1.0, 2.0, 10.0]
    matrix = [setting.weighted(column) for column in (*setting.columns, *found.columns)]
    np.testing.assert_allclose(found.equations.gram.sum(axis=0), np.array(matrix) @ np.array(matrix).T)
    assert [float(column[ONE][0, 0]) for column in found.columns] == values
    rest = setting.weighted({key: found.residual["torque"][..., key[1]] for key in setting.weights})
    np.testing.assert_allclose(found.equations.moment.sum(axis=0)[:, 0], np.array(matrix) @ rest)
    assert found.left == replay_hypotheses(setting, causes).left
    assert evaluate(setting, []).columns == ()


def test_tangents_of_all_but_the_newest_hypothesis_are_those_of_a_fit_like_it(setting, tangents):
    """Its replay is kept, too."""
    first, second, third = cause(share=0.1), cause(joint="j2", share=0.2), cause(joint="j3", share=0.3)
    like = evaluate(setting, [third, second])
    assert [float(c[ONE][0, 0]) for c in like.columns] == [0.0, 10.0]
    setting.last_replays.clear()
    found = evaluate(setting, [first, second, third], like)
    # the second one stood second there, and the third, which stood first, is the newest here
    assert found.columns[1] is like.columns[1]
    assert [float(c[ONE][0, 0]) for c in found.columns] == [0.0, 10.0, 20.0]
    found = evaluate(setting, [third, first], like)
    assert found.columns[0] is like.columns[0]
    assert like.run in setting.last_replays.values()
    anew = renew_tangents(setting, found)
    assert anew.columns[0] is not like.columns[0]
    assert (anew.run, anew.left, anew.hypotheses) == (found.run, found.left, found.hypotheses)


def test_slopes_beyond_all_numbers_are_an_error(setting, monkeypatch):
    tried = replay_hypotheses(setting, [cause(share=0.1)])
    monkeypatch.setattr(module, "compute_tangents", lambda *_: [{ONE: np.full((ROWS, 1), np.inf)}])
    with pytest.raises(FFGymError, match="load_friction on j1"):
        add_tangents(setting, tried, None)


def test_free_numbers_are_bounded_in_practical_steps_by_their_reach_and_by_what_they_may_be(setting):
    """A stiffness near its least may go down a little, and a frequency to those near it."""
    known = EFFECTS["joint_stiffness"].parameters()["change"]
    near = cause("joint_stiffness", change=known.minimum + 0.01)
    free = near.list_free()[0]
    middle = cause("cogging", amplitude=0.02, cycles=6.0, phase=0.5)
    frequency = middle.list_free()[1]
    reach = settings().estimator.reach
    priors = build_priors(setting, [near, middle])
    assert priors.low[2] == pytest.approx(-0.01 / free.step)
    np.testing.assert_allclose(priors.high[[0, 1, 2]], [setting.bound, setting.bound, reach])
    np.testing.assert_allclose(priors.low[[3, 5]], [-0.02 / middle.list_free()[0].step, -reach])
    np.testing.assert_allclose(priors.high[[3, 5]], reach)
    np.testing.assert_allclose(
        [priors.low[4], priors.high[4]],
        [(frequency.low - 6.0) / frequency.step, (frequency.high - 6.0) / frequency.step],
    )
    np.testing.assert_allclose(priors.precision[:2], setting.precision)
    np.testing.assert_allclose(priors.precision[2:], 1 / settings().screening.width ** 2)


def test_a_number_beyond_a_bound_stays_or_comes_back(setting):
    known = EFFECTS["joint_stiffness"].parameters()["change"]
    priors = build_priors(setting, [cause("joint_stiffness", change=known.minimum - 0.01)])
    assert priors.low[2] == 0.0
    assert priors.high[2] > 0.0
    known = EFFECTS["load_friction"].parameters()["share"]
    for share in (known.maximum, known.maximum + 0.01):
        priors = build_priors(setting, [cause(share=share)])
        assert priors.low[2] < 0.0
        assert priors.high[2] == 0.0


def test_trials_are_of_the_machine_that_was_replayed():
    run = SimpleNamespace(machine="a machine")
    assert Trial(numbers=None, hypotheses=(), run=run, residual={}, left=0.0).machine == "a machine"
    assert issubclass(Fit, Trial)
