from dataclasses import replace

import numpy as np
import pytest

from ffgym.agents.adapters import ADAPTERS
from ffgym.agents.amortised.estimator import Estimator, is_silent
from ffgym.agents.artefacts import TRAINED
from ffgym.agents.elastic import elastic_law
from ffgym.agents.residual.actor import LSTM, LinearLayer
from ffgym.agents.trials import RigTrial
from ffgym.core.errors import FFGymError
from ffgym.leaderboard.adaptation.protocol import scored_motions
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation import SimulatedRig, sensors_of


@pytest.fixture(scope="module")
def arm():
    return RigidArm(load_robot("irb4600_60_205_arm_drives"))


@pytest.mark.parametrize("variant", ["amortised", "amortised_motors", "amortised_recurrent"])
def test_on_the_nominal_robot_it_keeps_the_base_law(arm, variant):
    adapter = next(adapter for adapter in ADAPTERS if adapter.name == variant)
    rig = SimulatedRig(arm=arm, sensors=sensors_of(arm.robot))
    law, _ = adapter.practise(arm, RigTrial(rig=rig, n_threads=1), laps=1)
    motion = scored_motions(arm)[0]
    assert law.torque(motion).tobytes() == elastic_law(arm).torque(motion).tobytes()


def test_differences_beyond_the_noise_are_no_silence():
    quiet = 0.5 * np.random.default_rng(0).standard_normal((100, 9))
    assert is_silent(quiet, "tracker")
    assert not is_silent(quiet * 3, "tracker")
    only_tool = np.zeros((100, 9))
    only_tool[:, 6:] = 3.0
    assert is_silent(only_tool, "motors")
    assert not is_silent(only_tool, "tracker")


def make_estimator(rng, cells=None):
    def layer(outputs, inputs):
        return LinearLayer(weight=rng.standard_normal((outputs, inputs)), bias=rng.standard_normal(outputs))

    return Estimator(
        variant="motors" if cells is None else "recurrent",
        components=rng.standard_normal((4, 12)),
        spread=rng.uniform(1.0, 2.0, 4),
        linear=layer(3, 4),
        layers=(layer(5, 4 if cells is None else cells), layer(6, 5)),
        lstm=None if cells is None else LSTM(inputs=layer(4 * cells, 6), hidden=layer(4 * cells, cells)),
    )


def test_the_network_in_numpy_equals_the_one_in_torch():
    torch = pytest.importorskip("torch")
    rng = np.random.default_rng(3)
    estimator = make_estimator(rng)
    difference = rng.standard_normal((2, 9))
    found = estimator.estimate(difference)
    x = torch.as_tensor(estimator.components @ difference[:, :6].ravel() / estimator.spread)
    h = x
    first, last = ((torch.as_tensor(layer.weight), torch.as_tensor(layer.bias)) for layer in estimator.layers)
    h = torch.nn.functional.linear(torch.relu(torch.nn.functional.linear(h, *first)), *last)
    linear = torch.nn.functional.linear(
        x, torch.as_tensor(estimator.linear.weight), torch.as_tensor(estimator.linear.bias)
    )
    np.testing.assert_allclose(found.mean, (linear + h[:3]).numpy(), rtol=1e-12)
    np.testing.assert_allclose(found.deviation, torch.exp(h[3:]).numpy(), rtol=1e-12)


def test_a_recurrent_estimator_reads_the_rows_of_a_lap_in_their_order():
    torch = pytest.importorskip("torch")
    rng = np.random.default_rng(8)
    estimator = make_estimator(rng, cells=7)
    difference = rng.standard_normal((2, 9))
    lstm = torch.nn.LSTM(6, 7, batch_first=True).double()
    with torch.no_grad():
        for name, layer in (("ih", estimator.lstm.inputs), ("hh", estimator.lstm.hidden)):
            getattr(lstm, f"weight_{name}_l0").copy_(torch.as_tensor(layer.weight))
            getattr(lstm, f"bias_{name}_l0").copy_(torch.as_tensor(layer.bias))
        last = lstm(torch.as_tensor(difference[None, :, :6]))[0][0, -1].numpy()
    hidden, out = estimator.layers
    wanted = estimator.linear(estimator.features(difference)) + out(np.maximum(hidden(last), 0.0))[:3]
    np.testing.assert_allclose(estimator.estimate(difference).mean, wanted, rtol=1e-10)
    assert not np.isclose(
        estimator.estimate(difference[::-1]).deviation, np.exp(out(np.maximum(hidden(last), 0))[3:])
    ).any()


@pytest.mark.parametrize("cells", [None, 7])
def test_a_file_gives_the_estimator_back_and_others_are_refused(tmp_path, cells):
    estimator = make_estimator(np.random.default_rng(4), cells)
    estimator.save(tmp_path / "mine.npz", {"seed": 4})
    difference = np.random.default_rng(5).standard_normal((2, 9))
    again = Estimator.load(tmp_path / "mine.npz").estimate(difference)
    np.testing.assert_allclose(again.mean, estimator.estimate(difference).mean, rtol=0.02, atol=0.02)
    (tmp_path / "cut.npz").write_bytes((tmp_path / "mine.npz").read_bytes()[:100])
    with pytest.raises(FFGymError, match="damaged"):
        Estimator.load(tmp_path / "cut.npz")
    with pytest.raises(FFGymError, match="an estimator's is 'amortised_estimator'"):
        Estimator.load(TRAINED / "narx" / "nominal" / "seed_0.npz")


def test_layers_that_do_not_follow_the_cells_are_refused():
    seven, six = (make_estimator(np.random.default_rng(6), cells) for cells in (7, 6))
    with pytest.raises(FFGymError, match=r"Layers with \[4, 7, 3\] inputs"):
        replace(seven, lstm=six.lstm)


def test_a_lap_of_another_motion_is_refused():
    with pytest.raises(FFGymError, match="18 signals, the estimator was trained on 12"):
        make_estimator(np.random.default_rng(6)).estimate(np.zeros((3, 9)))
