"""The residual torque model: recovery of known friction, shrinking to the line, and what it is worth on the robot."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from ffgym.agents.declaration import AgentSetting
from ffgym.agents.residual_torque import ResidualTorque, fit_residual_torque, learn_residual_torque
from ffgym.agents.supervised import MotorRecord
from ffgym.control import DynamicLuGreExact, NoCompensation, Window
from ffgym.core.errors import FFGymError
from ffgym.recordings.metrics import motor_error_rms
from ffgym.robot.friction import slip_along
from ffgym.simulation import Run
from ffgym.studies import circle_references

DT = 0.004


def known(motor_dq, torque, noise=1e-3):
    """A record in which the torque is known."""
    return MotorRecord(
        dt=DT,
        motor_dq=motor_dq,
        motor_ddq=np.gradient(motor_dq, DT, axis=0),
        slip=slip_along(motor_dq, DT),
        torque=torque,
        moving=np.ones(len(motor_dq), dtype=np.bool_),
        noise=np.full(motor_dq.shape[1], noise),
        error=np.zeros(motor_dq.shape[1]),
    )


@pytest.fixture(scope="module")
def motor_dq():
    t = DT * np.arange(1500)
    return np.stack([2 * np.sin(2 * np.pi * 0.5 * t), np.sin(2 * np.pi * 0.7 * t)], axis=-1)


@pytest.fixture(scope="module")
def friction(irb4600):
    return {name: getattr(irb4600.friction, name)[:2] for name in ("coulomb", "static", "viscous")} | {
        name: getattr(irb4600.friction, name)[:2]
        for name in ("stribeck_velocity", "bristle_stiffness", "bristle_damping")
    }


@pytest.fixture(scope="module")
def lugre(irb4600, friction):
    return DynamicLuGreExact(type(irb4600.friction)(**friction))


@pytest.fixture(scope="module")
def model(lugre, motor_dq):
    return fit_residual_torque([known(motor_dq, lugre.along(motor_dq, DT))])


def along(law, motor_dq):
    slip = slip_along(motor_dq, DT)
    return law.at(slip, motor_dq, np.gradient(motor_dq, DT, axis=0))


def test_it_finds_dynamic_friction_on_motions_it_has_not_seen(model, lugre, motor_dq):
    other = 0.6 * motor_dq[:, ::-1]
    true, said = lugre.along(other, DT), along(model, other)
    assert np.sqrt(np.mean((said - true) ** 2)) < 0.08 * np.sqrt(np.mean(true**2))


def test_memory_is_worth_more_than_any_curve_over_speed(model, lugre, motor_dq):
    """The best torque that is a function of speed and sign of acceleration leaves several times the error."""
    true = lugre.along(motor_dq, DT)[:, 0]
    bins = np.digitize(motor_dq[:, 0], np.linspace(-2, 2, 80)) + 100 * (np.gradient(motor_dq[:, 0]) > 0)
    curve = np.array([true[bins == b].mean() for b in bins])
    late = slice(500, None)
    left = np.std((along(model, motor_dq)[:, 0] - true)[late])
    assert left < 0.5 * np.std((curve - true)[late])


def test_far_from_all_that_was_seen_the_line_answers_alone(model):
    fast, slip = np.full((1, 2), 1e8), np.ones((1, 2, 5))
    line = (model.coefficients * np.concatenate([slip, fast[..., None], 0 * fast[..., None]], -1)).sum(-1)
    np.testing.assert_allclose(model.at(slip, fast, 0 * fast), line, rtol=0, atol=1e-3)


def test_a_noisy_motion_does_not_drown_a_quiet_one(lugre, motor_dq):
    true = lugre.along(motor_dq, DT)
    rng = np.random.default_rng(0)
    loud = known(motor_dq, true + 2 * rng.normal(size=true.shape), noise=2.0)
    model = fit_residual_torque([known(motor_dq, true), loud])
    assert np.sqrt(np.mean((along(model, motor_dq) - true) ** 2)) < 0.05 * np.sqrt(np.mean(true**2))


def test_a_motor_that_stood_still_gets_no_torque(lugre, motor_dq):
    true = lugre.along(motor_dq, DT)
    still = np.where([True, False], motor_dq, 0.0)
    model = fit_residual_torque([known(still, np.where([True, False], true, 0.0))])
    np.testing.assert_allclose(along(model, still)[:, 1], 0, atol=1e-9)


def test_rows_of_a_batch_do_not_touch_each_other(model, motor_dq):
    window = Window(q=np.zeros((7, 2, 2)), motor_dq=motor_dq[:14].reshape(7, 2, 2), motor_ddq=np.ones((7, 2, 2)), dt=DT)
    together, memory = model.step(model.initial_memory(window), window)
    for row in range(7):
        torque, alone = model.step(model.initial_memory(window[row]), window[row])
        np.testing.assert_allclose(together[row], torque, rtol=0, atol=1e-12)
        np.testing.assert_array_equal(memory[row], alone)


def test_prediction_needs_no_scikit_learn(model, monkeypatch, motor_dq):
    monkeypatch.setitem(sys.modules, "sklearn.gaussian_process", None)
    again = ResidualTorque.from_parts(*model.parts())
    np.testing.assert_array_equal(along(again, motor_dq), along(model, motor_dq))


def test_fitting_says_what_to_install(setting, monkeypatch):
    monkeypatch.setitem(sys.modules, "sklearn.gaussian_process", None)
    with pytest.raises(FFGymError, match=r"pip install 'ffgym\[gp\]'"):
        learn_residual_torque(setting.trial, [])


def test_parts_that_do_not_fit_are_refused(model):
    with pytest.raises(FFGymError, match="points has shape"):
        replace(model, points=model.points[:1])
    with pytest.raises(FFGymError, match=r"length = .* must be > 0"):
        replace(model, length=np.zeros(2))


@pytest.fixture(scope="module")
def setting(irb4600):
    return AgentSetting.of(irb4600)


def test_one_trial_on_small_circles_takes_most_of_the_motor_error_away_and_elsewhere_too(setting, irb4600):
    references = circle_references(setting.arm, ["p1", "p2"], [0.01], [0.003])
    learned = learn_residual_torque(setting.trial, [references["p1", 0.01]], n_trials=1)
    error = {
        law.name: [
            motor_error_rms(r) for r in setting.trial([Run(reference=x, law=law) for x in references.values()], 1)
        ]
        for law in (NoCompensation(), learned.law)
    }
    for trained, before in zip(error["residual_gp"], error["none"], strict=True):
        assert trained.mean() < 0.15 * before.mean()
        assert np.all(trained < before)
    np.testing.assert_allclose(learned.error[0, 0], error["none"][0], rtol=1e-3)


def test_a_file_without_widths_is_refused_and_does_not_get_those_of_today(model):
    settings, arrays = model.parts()
    del arrays["widths"]
    with pytest.raises(FFGymError, match="lacks widths"):
        ResidualTorque.from_parts(settings, arrays)
