"""Numbers within their calibration are found where slopes about the described ones do not lead to them."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.fit import calibrate as module
from ffgym.diagnosis.fit.calibrate import _Numbers, calibrate
from ffgym.diagnosis.normal_equations import build_design_matrix
from ffgym.diagnosis.resampling import cut_blocks
from ffgym.diagnosis.solving import Priors
from ffgym.effects import EFFECTS

ROWS = 400
TIME = np.linspace(0.0, 1.0, ROWS)
KEY = ("torque", 0)
BOUND = 4.0


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
    _, now = begin(setting)
    rows = now.trial.residual["torque"][0, :, 0]
    # of one error: an offset of one unit in each row, with the prior about what is described
    size = (rows.sum() - at[2]) / (ROWS + 1)
    wanted = ((rows - size) ** 2).sum() + at[0] ** 2 + at[1] ** 2 + (at[2] + size) ** 2
    assert now.cost == pytest.approx(wanted)


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
