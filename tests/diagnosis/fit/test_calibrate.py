"""Numbers within their calibration are found where slopes about the described ones do not lead to them."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.fit import calibrate as module
from ffgym.diagnosis.fit.calibrate import Calibrated, _Numbers, calibrate
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.problem import HELD
from ffgym.diagnosis.normal_equations import build_design_matrix
from ffgym.diagnosis.resampling import cut_blocks
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.solving import Priors
from ffgym.effects import EFFECTS

ROWS = 400
TIME = np.linspace(0.0, 1.0, ROWS)
KEY = ("torque", 0)
BOUND = 4.0
SLOPES = _Numbers.slopes
"""Slopes as they are computed along replays, which most tests here have otherwise."""


def swing(sizes, turns):
    """Torque in units of noise: a swing whose phase two numbers turn, and an offset that is no number of a robot."""
    stiffness, mass, offset = sizes
    return 30 * np.sin(turns * (1 + 0.02 * stiffness) * TIME) * (1 + 0.05 * mass) + offset


@pytest.fixture
def put(monkeypatch):
    """A function of true numbers that gives the problem of finding them, with others about which slopes are taken."""

    def make(truth, turns=60.0, at=(0.0, 0.0, 0.0)):
        at, blocks = np.array(at), cut_blocks(np.ones((1, ROWS), dtype=bool), 0.02)
        measured = swing(truth, turns) + np.random.default_rng(0).normal(size=ROWS)
        effects = [EFFECTS["joint_stiffness"], EFFECTS["rotor_inertia"], EFFECTS["torque_clock"]]
        priors = Priors(precision=np.ones(3), low=-BOUND - at, high=BOUND - at)

        def columns(sizes):
            steps = 1e-4 * np.eye(3)
            return [{KEY: (swing(sizes + d, turns) - swing(sizes - d, turns))[None] / 2e-4} for d in steps]

        def replay(setting, causes, sizes=None):
            sizes = np.zeros(3) if sizes is None else np.array(sizes)
            residual = {"torque": (measured - swing([*sizes[:2], 0.0], turns))[None, :, None]}
            return SimpleNamespace(residual=residual, hypotheses=(), sizes=sizes)

        weights = {KEY: np.ones((1, ROWS))}
        setting = SimpleNamespace(
            nuisances=[
                SimpleNamespace(column=SimpleNamespace(effect=effect), at=x)
                for effect, x in zip(effects, at, strict=True)
            ],
            nuisance_columns=columns(np.zeros(3)),
            nuisance_priors=lambda causes: priors,
            blocks=blocks,
            weights=weights,
            design=build_design_matrix(blocks, columns(np.zeros(3)), weights),
        )
        monkeypatch.setattr(module, "replay_hypotheses", replay)
        monkeypatch.setattr(module, "possible_numbers", lambda setting, sizes: sizes)
        monkeypatch.setattr(module, "build_priors", lambda setting, causes: priors)
        monkeypatch.setattr(
            _Numbers, "slopes", lambda self, trial: build_design_matrix(blocks, columns(trial.sizes), weights)
        )
        return setting

    return make


def begin(setting):
    """The numbers as they are described, with slopes about them."""
    numbers = _Numbers(setting=setting, prior=None)
    return numbers, numbers.place(np.zeros(3), module.replay_hypotheses(setting, ()), setting.design)


def test_numbers_that_turn_the_phase_of_a_swing_are_found(put):
    found = calibrate(put([1.8, -1.2, 0.7]), None)
    np.testing.assert_allclose(found.sizes, [1.8, -1.2, 0.0], atol=0.1)  # an offset is fitted, and is no number
    assert found.cost == pytest.approx(ROWS, rel=0.2)


def test_where_slopes_tell_all_that_numbers_do_nothing_is_to_be_found(put):
    assert calibrate(put([0.05, 1.0, 0.7], turns=3.0), None) is None


def test_without_numbers_nothing_is_to_be_found(put):
    setting = put([1.8, -1.2, 0.7])
    setting.nuisances = []
    assert calibrate(setting, None) is None


def test_where_no_machine_can_be_as_described_nothing_is_found(put, monkeypatch):
    setting = put([1.8, -1.2, 0.7])
    monkeypatch.setattr(module, "replay_hypotheses", lambda *_: None)
    assert calibrate(setting, None) is None


def test_a_search_that_is_not_thorough_ends_where_slopes_promise_no_less(put, monkeypatch):
    setting = put([1.8, -1.2, 0.7])
    monkeypatch.setattr(_Numbers, "predict_energy", lambda self, now: 50.0 * ROWS)  # whatever slopes are taken
    assert calibrate(setting, None, thoroughly=False) is None
    assert calibrate(setting, None, thoroughly=True) is not None


@pytest.mark.parametrize("at", [(0.0, 0.0, 0.0), (0.3, -0.2, 0.4)])
def test_errors_that_are_no_numbers_are_fitted_in_each_place_within_their_prior(put, at):
    setting = put([0.0, 0.0, 3.0], at=at)
    numbers, now = begin(setting)
    rows = now.trial.residual["torque"][0, :, 0]
    # of one error: an offset of one unit in each row, with the prior about what is described
    size = (rows.sum() - at[2]) / (ROWS + 1)
    wanted = ((rows - size) ** 2).sum() + at[0] ** 2 + at[1] ** 2 + (at[2] + size) ** 2
    assert now.cost == pytest.approx(wanted)
    # the same residual with other numbers
    moved = numbers.place(np.array([0.5, -1.0, 0.0]), now.trial, setting.design)
    numbers_cost = [(at[0] + 0.5) ** 2 - at[0] ** 2, (at[1] - 1.0) ** 2 - at[1] ** 2]
    assert moved.cost == pytest.approx(wanted + sum(numbers_cost))


@pytest.mark.parametrize("at", [(0.0, 0.0, 0.0), (0.3, -0.2, 0.4)])
def test_the_energy_that_slopes_promise_is_that_of_a_linear_fit_with_priors(put, at):
    setting = put([0.1, 0.5, 1.0], at=at)
    numbers, now = begin(setting)
    matrix = np.stack([column[KEY][0] for column in setting.nuisance_columns], axis=1)
    rows = now.trial.residual["torque"][0, :, 0]
    step = np.linalg.solve(matrix.T @ matrix + np.eye(3), matrix.T @ rows - np.array(at))
    assert numbers.predict_energy(now) == pytest.approx(((rows - matrix @ step) ** 2).sum())
    far = numbers.step(now, np.inf)
    np.testing.assert_allclose(far, [*step[:2], 0.0], atol=1e-6)  # the offset is fitted in each place
    near = numbers.step(now, 0.01)
    assert np.abs(near).max() <= 0.01 + 1e-6


@pytest.mark.parametrize(("turns", "size", "is_bent"), [(3.0, 0.05, False), (60.0, 1.5, True)])
def test_a_replay_that_differs_from_its_slopes_is_bent(put, turns, size, is_bent):
    numbers, now = begin(put([0.0, 0.0, 0.0], turns=turns))
    step = np.array([size, 0.0, 0.0])
    assert numbers.is_bent(now, numbers.move(now, step), step) == is_bent


class Begun:
    """How a search begins where slopes promise to leave 100, and one step as far as they say leaves something else."""

    def __init__(self, monkeypatch, setting, far=None, predicted=100.0, is_bent=True):
        self.setting, self.renewed, self.begun = setting, [], None
        self.far = None if far is None else SimpleNamespace(cost=far, name="far")
        monkeypatch.setattr(_Numbers, "predict_energy", lambda numbers, now: predicted)
        monkeypatch.setattr(_Numbers, "move", lambda numbers, now, step: self.far)
        monkeypatch.setattr(_Numbers, "is_bent", lambda numbers, now, there, step: is_bent)
        monkeypatch.setattr(_Numbers, "renew", self.renew)
        monkeypatch.setattr(module, "descend", self.descend)

    def renew(self, point, *, is_last):
        assert not is_last
        self.renewed.append(point)
        return SimpleNamespace(sizes=np.ones(3), equations=SimpleNamespace(rows=np.array([300.0, 100.0])))

    def descend(self, slope, start, steps):
        self.begun = slope, start, steps
        return start

    def search(self, causes=(), **how):
        return calibrate(self.setting, None, causes, **how)


@pytest.mark.parametrize(("far", "is_there"), [(None, False), (101.0, False), (100.0, True), (99.0, True)])
def test_a_search_begins_where_slopes_lead_if_that_leaves_no_more_than_they_promise(put, monkeypatch, far, is_there):
    begun = Begun(monkeypatch, put([1.8, -1.2, 0.7]), far)
    found = begun.search()
    _, start, steps = begun.begun
    assert begun.renewed == ([begun.far] if is_there else [])
    assert start.sizes.any() == is_there
    assert is_there or start.equations.design is begun.setting.design
    assert (found is start) == is_there  # numbers as they are described are nothing that was found
    limits = settings().estimator
    wanted = (limits.number_steps, limits.number_reach, limits.number_least_reach, limits.number_gain)
    assert (steps.most, steps.reach, steps.least_reach, steps.gain) == wanted


def test_nothing_is_searched_where_a_step_does_what_slopes_say(put, monkeypatch):
    begun = Begun(monkeypatch, put([1.8, -1.2, 0.7]), 99.0, is_bent=False)
    assert begun.search() is None
    assert begun.begun is None


def test_how_little_slopes_must_promise_is_a_share_of_what_the_first_do_or_noise_alone(put, monkeypatch):
    setting, share = put([1.8, -1.2, 0.7]), settings().estimator.promises
    for predicted, most in ((1000.0, share * 1000.0), (100.0, ROWS)):
        begun = Begun(monkeypatch, setting, predicted=predicted)
        begun.search(thoroughly=False)
        assert begun.begun[0].most == pytest.approx(most)
        begun.search(thoroughly=True)
        assert begun.begun[0].most == np.inf
        begun.search()
        assert begun.begun[0].most == np.inf


def test_beside_causes_slopes_are_about_their_machine_and_no_step_is_tried_first(put, monkeypatch):
    begun = Begun(monkeypatch, put([1.8, -1.2, 0.7]), 99.0, is_bent=False)
    slopes = build_design_matrix(begun.setting.blocks, [{KEY: np.ones((1, ROWS))}] * 3, begun.setting.weights)
    monkeypatch.setattr(_Numbers, "slopes", lambda numbers, trial: slopes)
    begun.search(("a cause",))
    assert begun.begun[1].equations.design is slopes
    monkeypatch.setattr(_Numbers, "slopes", lambda numbers, trial: None)
    begun.begun = None
    assert begun.search(("a cause",)) is None
    assert begun.begun is None


def test_slopes_are_of_all_errors_and_of_causes_beside_them(put, monkeypatch):
    setting = put([0.0, 0.0, 0.0])
    numbers = _Numbers(setting=setting, prior="prior")
    rows = [np.full((1, ROWS), float(k)) for k in (1, 2, 3, 5)]
    doubts = [SimpleNamespace(per_sigma={KEY: each}) for each in rows[:3]]
    monkeypatch.setattr(module, "list_nuisance_parameters", lambda run, prior: doubts if prior == "prior" else [])
    monkeypatch.setattr(module, "compute_tangents", lambda run, before, causes: [{KEY: rows[3]}] * len(causes))

    def sizes(causes):
        trial = SimpleNamespace(run=None, numbers=None, hypotheses=causes)
        return np.diagonal(SLOPES(numbers, trial).gram.sum(axis=0)) / ROWS

    np.testing.assert_allclose(sizes(()), [1, 4, 9])
    np.testing.assert_allclose(sizes(("a cause",)), [1, 4, 9, 25])

    def fail(*_):
        raise FFGymError("no")

    monkeypatch.setattr(module, "compute_tangents", fail)
    np.testing.assert_allclose(sizes(()), [1, 4, 9])
    assert SLOPES(numbers, SimpleNamespace(run=None, numbers=None, hypotheses=("a cause",))) is None
    doubts.pop()  # a machine has other errors than the described one
    assert SLOPES(numbers, SimpleNamespace(run=None, numbers=None, hypotheses=())) is None


CAUSE = Hypothesis(kind=EFFECTS["load_friction"], joint="j1", source=None, values={"share": np.array(0.1)})


def place_beside_a_cause(setting, sizes, moment, monkeypatch, bound=BOUND):
    """A place with numbers of some sizes, columns of 2, 1, 3 and 4 that do not act on each other, and a cause."""
    priors = Priors(
        precision=np.array([1.0, 1.0, 1.0, 0.5]), low=np.full(4, -bound), high=np.array([bound, bound, bound, 1.0])
    )
    monkeypatch.setattr(module, "build_priors", lambda setting, causes: priors)
    gram, moment = np.diag([4.0, 1.0, 9.0, 16.0]), np.stack([moment, [1e3] * 4], axis=1)  # of the log, and of noise
    equations = SimpleNamespace(
        gram=np.stack([gram / 4, 3 * gram / 4]),
        moment=np.stack([moment / 4, 3 * moment / 4]),
        energy=np.array([[100.0], [300.0]]),
        design="slopes",
    )
    trial = SimpleNamespace(hypotheses=(CAUSE,), residual={})
    return Calibrated(sizes=np.array(sizes), trial=trial, equations=equations, cost=1.0)


def test_a_step_of_numbers_and_causes_pays_for_how_far_numbers_are_from_what_is_described(put, monkeypatch):
    setting = put([0.0, 0.0, 0.0], at=(0.3, -0.2, 0.4))
    numbers = _Numbers(setting=setting, prior=None)
    now = place_beside_a_cause(setting, [0.5, -1.0, 0.0], [10.0, 1.0, 20.0, 8.0], monkeypatch)
    step = numbers.step(now, np.inf)
    np.testing.assert_allclose(step, [(10 - 0.8) / 5, (1 + 1.2) / 2, 0.0, 8 / 16.5])
    full = np.array([step[0], step[1], (20 - 0.4) / 10, step[3]])
    left = 400 - 2 * full @ [10, 1, 20, 8] + full**2 @ [4, 1, 9, 16]
    assert numbers.predict_energy(now) == pytest.approx(left)
    near = numbers.step(now, 0.25)  # which bounds numbers, and no causes
    np.testing.assert_allclose(near, [0.25, 0.25, 0.0, step[3]])
    down = place_beside_a_cause(setting, [0.5, -1.0, 0.0], [-10.0, -9.0, -20.0, -8.0], monkeypatch)
    np.testing.assert_allclose(numbers.step(down, 0.25), [-0.25, -0.25, 0.0, -step[3]])
    assert numbers.length(near) == 0.25
    assert numbers.length(np.array([0.1, -0.3, 0.0, 9.0])) == 0.3


def test_numbers_and_errors_stay_within_their_bounds_and_causes_too(put, monkeypatch):
    numbers = _Numbers(setting=put([0.0, 0.0, 0.0]), prior=None)
    now = place_beside_a_cause(None, [1.5, -1.5, 0.0], [900.0, -900.0, 900.0, 900.0], monkeypatch, bound=2.0)
    step = numbers.step(now, np.inf)
    np.testing.assert_allclose(step, [0.5, -0.5, 0.0, 1.0])
    full = np.array([0.5, -0.5, 2.0, 1.0])
    left = 400 - 2 * full @ [900, -900, 900, 900] + full**2 @ [4, 1, 9, 16]
    assert numbers.predict_energy(now) == pytest.approx(left)
    up = place_beside_a_cause(None, [-1.5, 1.5, 0.0], [900.0, -900.0, -900.0, 900.0], monkeypatch, bound=2.0)
    np.testing.assert_allclose(numbers.step(up, np.inf), [3.5, -3.5, 0.0, 1.0])
    there = place_beside_a_cause(None, [2.0, -2.0, 0.0], [900.0, -900.0, 0.0, 0.0], monkeypatch, bound=2.0)
    assert np.abs(numbers.step(there, np.inf)).max() <= HELD


def test_a_move_leads_to_a_machine_with_numbers_within_their_bounds_beside_moved_causes(put, monkeypatch):
    setting = put([0.0, 0.0, 0.0])
    numbers = _Numbers(setting=setting, prior=None)
    now = place_beside_a_cause(setting, [1.0, 1.0, 0.0], [0.0] * 4, monkeypatch)
    replayed = []
    monkeypatch.setattr(module, "replay_hypotheses", lambda *given: replayed.append(given[1:]) or "trial")
    monkeypatch.setattr(_Numbers, "place", lambda numbers, *place: place)
    (free,) = CAUSE.list_free()
    sizes, trial, slopes = numbers.move(now, np.array([0.5, 99.0, 0.0, 0.5]))
    np.testing.assert_allclose(sizes, [1.5, BOUND, 0.0])
    assert (trial, slopes) == ("trial", "slopes")
    (((moved,), machine),) = replayed
    assert machine is sizes
    assert float(moved.values["share"]) == pytest.approx(0.1 + 0.5 * free.step)
    sizes, *_ = numbers.move(now, np.array([-1.0 + 0.5 * HELD, -99.0, HELD, 0.0]))
    np.testing.assert_allclose(sizes, [0.0, -BOUND, 0.0], atol=0)
    monkeypatch.setattr(module, "replay_hypotheses", lambda *_: None)
    assert numbers.move(now, np.zeros(4)) is None
    monkeypatch.setattr(module, "possible_numbers", lambda *_: None)
    monkeypatch.setattr(module, "replay_hypotheses", lambda *_: "trial")
    assert numbers.move(now, np.zeros(4)) is None


def test_slopes_about_a_place_are_taken_anew_unless_it_is_the_last_or_there_are_none(put, monkeypatch):
    numbers, now = begin(put([1.8, -1.2, 0.7]))
    again = numbers.renew(now, is_last=False)
    assert again is not now
    assert again.cost == pytest.approx(now.cost)
    assert numbers.renew(now, is_last=True) is now
    monkeypatch.setattr(_Numbers, "slopes", lambda numbers, trial: None)
    assert numbers.renew(now, is_last=False) is now


def test_a_place_that_leaves_what_is_no_number_is_none(put):
    numbers, now = begin(put([1.8, -1.2, 0.7]))
    trial = SimpleNamespace(residual={"torque": np.full((1, ROWS, 1), 1e200)}, hypotheses=())
    assert numbers.place(np.zeros(3), trial, now.equations.design) is None


@pytest.mark.parametrize(("most", "hopeless"), [(99.0, True), (100.0, False), (101.0, False), (np.inf, False)])
def test_a_search_is_hopeless_where_slopes_promise_more_than_the_most(put, monkeypatch, most, hopeless):
    monkeypatch.setattr(_Numbers, "predict_energy", lambda numbers, point: 100.0)
    numbers = _Numbers(setting=put([0.0, 0.0, 0.0]), prior=None, most=most)
    assert bool(numbers.is_hopeless(None)) is hopeless


def test_only_rows_of_blocks_tell_whether_a_replay_is_bent(put):
    """Energy per such row, in units of noise, of what slopes do not say."""
    setting, limit = put([0.0, 0.0, 0.0]), settings().estimator.bent
    numbers, now = begin(setting)
    of_row = np.zeros((1, ROWS), dtype=int)  # the first block is one of them
    of_row[0, : ROWS // 2] = -1
    setting.blocks = SimpleNamespace(of_row=of_row)
    step = np.array([0.5, -1.0, 2.0])
    slopes = sum(size * column[KEY] for size, column in zip(step, setting.nuisance_columns, strict=True))

    def is_bent(early, late):
        change = slopes + np.where(of_row < 0, early, late)
        there = SimpleNamespace(
            trial=SimpleNamespace(residual={"torque": now.trial.residual["torque"] - change[..., None]})
        )
        return numbers.is_bent(now, there, step)

    assert not is_bent(9.0, 0.99 * limit**0.5)
    assert is_bent(0.0, 1.01 * limit**0.5)
    assert is_bent(0.0, -1.01 * limit**0.5)
    with pytest.raises(ValueError, match="shorter"):
        numbers.is_bent(now, now, step[:2])
    # channels that were not replayed say nothing
    assert not numbers.is_bent(now, SimpleNamespace(trial=SimpleNamespace(residual={})), step)
