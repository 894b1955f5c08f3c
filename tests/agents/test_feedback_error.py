"""Feedback-error learning with a perceptron: evaluation, updates, and what it forgets."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from ffgym.agents.declaration import AgentSetting
from ffgym.agents.feedback_error import MLP
from ffgym.agents.lffc import LFFC
from ffgym.agents.trials import Lesson
from ffgym.control import StaticLuGre
from ffgym.core.errors import FFGymError
from ffgym.simulation import Run
from ffgym.studies import sine_references
from scripts.forgetting import compare, forgetting_figure
from tests.agents.lesson_samples import lesson


@pytest.fixture(scope="module")
def fresh(irb4600):
    return MLP.untrained(irb4600, np.random.default_rng(0))


@pytest.fixture(scope="module")
def trained(fresh):
    rng = np.random.default_rng(1)
    return fresh.with_weights(fresh.weights | {"output": rng.normal(size=fresh.output.shape)})


def test_an_untrained_network_adds_nothing(fresh):
    assert not fresh.torque_at(np.ones((5, 6)), np.ones((5, 6))).any()


def test_torque_is_the_perceptron_written_out(trained, irb4600):
    dq, ddq = np.linspace(-3, 3, 6), np.linspace(50, -50, 6)
    for j in range(6):
        inputs = [dq[j] / trained.scales[0, j], ddq[j] / trained.scales[1, j]]
        layer = np.tanh(trained.hidden[j] @ inputs + trained.bias[j])
        expected = irb4600.friction.static[j] * (trained.output[j] @ layer + trained.offset[j])
        assert trained.torque_at(dq, ddq)[j] == pytest.approx(expected, rel=1e-12)


def test_rows_of_a_batch_do_not_touch_each_other(trained):
    dq, ddq = np.random.default_rng(0).normal(size=(2, 33, 6))
    alone = np.stack([trained.torque_at(*row) for row in zip(dq, ddq, strict=True)])
    np.testing.assert_allclose(trained.torque_at(dq, ddq), alone, rtol=0, atol=1e-12)


@pytest.fixture(scope="module")
def sine(one_axis):
    return sine_references(one_axis)[1.0]


def test_an_update_moves_the_torque_by_the_rate_times_the_signal(one_axis, sine):
    network = MLP.untrained(one_axis, np.random.default_rng(0))
    signal = StaticLuGre(one_axis.friction, steepness=1.0).at_speed(sine.motor_dq)
    after = network.adapt([lesson(sine, signal)], rate=0.5)
    left = after.torque_at(sine.motor_dq, sine.motor_ddq) - 0.5 * signal
    assert np.sqrt(np.mean(left**2)) < 0.05 * np.sqrt(np.mean(signal**2))
    assert not network.output.any()  # the first network is as it was


def test_a_motor_learns_the_same_whatever_the_others_do(fresh, arm):
    rng = np.random.default_rng(2)
    dq, ddq, wanted = rng.normal(size=(3, 100, 6))
    one, other = (fresh.fit_to(dq, ddq, wanted * scale) for scale in (np.ones(6), np.array([1, 1, 5, 1, 1, 1])))
    unchanged = np.arange(6) != 2
    np.testing.assert_allclose(one.hidden[unchanged], other.hidden[unchanged], rtol=0, atol=1e-10)
    assert np.abs(one.output[2] - other.output[2]).max() > 1e-3


def test_one_sample_in_order_is_a_step_down_its_own_gradient(trained):
    """Thesis (3.15), against finite differences of half the squared error."""
    rng = np.random.default_rng(3)
    dq, ddq, wanted = rng.normal(size=(3, 1, 6))
    rate, h = 1e-3, 1e-6
    after = trained.adapt_in_order(dq, ddq, wanted, rate)

    def cost(network):
        error = (network.torque_at(dq, ddq) - wanted) / network.scales[2]
        return 0.5 * (error**2).sum()

    for name, weights in trained.weights.items():
        for index in [(0,) * weights.ndim, (3,) * min(weights.ndim, 2) + (1,) * (weights.ndim == 3)]:
            up, down = weights.copy(), weights.copy()
            up[index] += h
            down[index] -= h
            slope = (
                cost(trained.with_weights(trained.weights | {name: up}))
                - cost(trained.with_weights(trained.weights | {name: down}))
            ) / (2 * h)
            assert after.weights[name][index] - weights[index] == pytest.approx(-rate * slope, abs=1e-9)


def test_trials_bring_the_motor_error_down(one_axis, sine):
    setting = AgentSetting.of(one_axis)
    network = MLP.untrained(one_axis, np.random.default_rng(0))
    learning = LFFC(rate=0.8, iterations=4).learn(network, [sine], setting.trial)
    rms = np.sqrt(learning.error[:, 0, 0])
    assert rms[-1] < 0.5 * rms[0]
    (recording,) = setting.trial([Run(reference=sine, law=learning.best)], 9)
    best = Lesson.of(sine, recording)
    assert np.sqrt(np.mean(best.error[best.moving] ** 2)) == pytest.approx(rms.min(), rel=1e-9)


def test_a_perceptron_forgets_where_b_splines_do_not(one_axis):
    """Thesis 3.2: weights that are adapted globally fit the last data presented."""
    results = compare(one_axis, np.random.default_rng(0), n_sweeps=4)
    splines, perceptron = results["bsn_static"], results["mlp_fel"]
    far = splines.speed < 4.0  # the hat of the knot at 5 rad/s, the lowest that came again, ends there
    np.testing.assert_array_equal(splines.after[far], splines.before[far])
    assert 0 < splines.forgotten < 0.04  # between 4 and 5 rad/s
    assert splines.missed < 0.01
    assert perceptron.forgotten > 0.05
    assert np.abs(perceptron.after - perceptron.before)[splines.speed < 0].max() > 0.05
    figure = forgetting_figure(results)
    assert [axes.get_title() for axes in figure.axes] == ["bsn_static", "mlp_fel"]


def test_a_perceptron_forgets_offline_too_if_a_trial_shows_high_speeds_only(one_axis):
    friction = StaticLuGre(one_axis.friction).at_speed
    speed, high = np.linspace(-10, 10, 400)[:, None], np.linspace(5, 10, 100)[:, None]
    network = MLP.untrained(one_axis, np.random.default_rng(0))
    for _ in range(5):
        network = network.fit_to(speed, np.zeros_like(speed), friction(speed))
    after = network.fit_to(high, np.zeros_like(high), 1.2 * friction(high))
    slow = speed[:, 0] < 4
    moved = (after.torque_at(speed, np.zeros_like(speed)) - network.torque_at(speed, np.zeros_like(speed)))[slow]
    assert np.sqrt(np.mean(moved**2) / np.mean(friction(speed)[slow] ** 2)) > 0.05


def test_running_needs_no_torch():
    code = (
        "import sys\n"
        "class NoTorch:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name.partition('.')[0] == 'torch': raise ModuleNotFoundError(name)\n"
        "sys.meta_path.insert(0, NoTorch())\n"
        "import agents, ffgym.agents.catalogue, numpy as np\n"
        "from ffgym.agents.feedback_error import MLP\n"
        "from ffgym.robot import load_robot\n"
        "n = MLP.untrained(load_robot('one_axis'), np.random.default_rng(0))\n"
        "n.torque_at(np.ones(1), np.ones(1))\n"
        "try: n.fit_to(*np.ones((3, 2, 1)))\n"
        "except Exception as error: print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "pip install 'ffgym[rl]'" in done.stdout


def test_the_number_of_torch_threads_is_left_as_it_was(one_axis):
    import torch

    before = torch.get_num_threads()
    try:
        torch.set_num_threads(2)
        MLP.untrained(one_axis, np.random.default_rng(0)).fit_to(*np.ones((3, 2, 1)))
        assert torch.get_num_threads() == 2
    finally:
        torch.set_num_threads(before)


def test_what_makes_no_network_is_refused(fresh, irb4600):
    with pytest.raises(FFGymError, match="bias has shape"):
        replace(fresh, bias=fresh.bias[:2])
    with pytest.raises(FFGymError, match="must be > 0"):
        replace(fresh, scales=0 * fresh.scales)
    with pytest.raises(FFGymError, match="is for one: 'one_axis'"):
        compare(irb4600, np.random.default_rng(0))
