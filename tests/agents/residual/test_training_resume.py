"""Training: an interruption leaves no trace, and a folder holds one training."""

import json
import os
import signal
import subprocess
import sys
from hashlib import sha256
from math import isclose

import numpy as np
import pytest

from ffgym.agents.amortised.draws import draw_machines
from ffgym.agents.residual import training as under_test
from ffgym.agents.residual.environment import make_environment
from ffgym.agents.residual.policy import load_policy
from ffgym.agents.residual.training import segment_seed, train
from ffgym.agents.residual.validation import POINTS, RADIUS, SEED, SPEEDS
from ffgym.core.errors import FFGymError
from ffgym.leaderboard.tasks import NEW_RADII, NEW_SPEEDS
from ffgym.robot import load_robot
from tests.agents.residual.residual_samples import tiny
from tests.processes import held_elsewhere

STEPS = 48


class Stop(Exception):
    """In place of a signal."""


def stop_at(steps):
    def watch(done, total):
        assert total == STEPS
        if done >= steps:
            raise Stop

    return watch


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """Folders of undisturbed trainings, by algorithm."""
    made = {}

    def get(algorithm):
        if algorithm not in made:
            made[algorithm] = tmp_path_factory.mktemp(algorithm)
            train(tiny(algorithm), made[algorithm])
        return made[algorithm]

    return get


@pytest.fixture
def stopped(tmp_path):
    """A folder of a training that was stopped in its second segment."""
    with pytest.raises(Stop):
        train(tiny(), tmp_path, watch=stop_at(20))
    return tmp_path


def events(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("algorithm", ["ppo", pytest.param("sac", marks=pytest.mark.slow)])
def test_a_training_that_was_killed_ends_as_if_it_had_not_been(algorithm, done, tmp_path):
    """The process kills itself in the middle of the second segment."""
    code = (
        "import os, signal; from pathlib import Path\n"
        "from ffgym.agents.residual.training import train\n"
        "from tests.agents.residual.residual_samples import tiny\n"
        f"train(tiny({algorithm!r}), Path({str(tmp_path)!r}),\n"
        "      watch=lambda done, total: os.kill(os.getpid(), signal.SIGKILL) if done > 24 else None)"
    )
    killed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=os.environ)
    assert killed.returncode == -signal.SIGKILL, killed.stderr
    assert "checkpoint.pt" in events(tmp_path)
    train(tiny(algorithm), tmp_path)
    for name in ("policy.npz", "training.json"):
        assert (tmp_path / name).read_bytes() == (done(algorithm) / name).read_bytes()
    assert events(tmp_path) == ["policy.npz", "tensorboard", "training.json"]


@pytest.mark.parametrize("algorithm", ["recurrent_ppo", "tqc"])
def test_a_training_may_be_stopped_more_than_once(algorithm, done, tmp_path):
    for steps in (2, 20, 36, 48):
        with pytest.raises(Stop):
            train(tiny(algorithm), tmp_path, watch=stop_at(steps))
    train(tiny(algorithm), tmp_path)
    assert (tmp_path / "policy.npz").read_bytes() == (done(algorithm) / "policy.npz").read_bytes()


def test_a_training_that_was_stopped_before_its_policy_was_written_only_writes_it(done, tmp_path, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(under_test, "encode_policy", lambda policy: stop_at(0)(1, STEPS))
        with pytest.raises(Stop):
            train(tiny(), tmp_path)
    assert "checkpoint.pt" in events(tmp_path)
    train(tiny(), tmp_path, watch=stop_at(0))
    assert (tmp_path / "policy.npz").read_bytes() == (done("ppo") / "policy.npz").read_bytes()


def test_the_numbers_say_where_they_come_from(done):
    folder = done("ppo")
    numbers = json.loads((folder / "training.json").read_text())
    assert numbers["sha256"] == sha256((folder / "policy.npz").read_bytes()).hexdigest()
    assert numbers["env_steps"] == STEPS
    assert [steps for steps, _ in numbers["learning_curve"]] == list(range(4, STEPS + 1, 4))
    assert all(reward <= 0 for _, reward in numbers["learning_curve"])
    assert numbers["training"]["hyperparameters"]["n_steps"] == 8
    assert (numbers["origin"]["environment"], numbers["origin"]["position"]) == ("ffgym/CirclePath-v0", "p1")
    assert len(numbers["origin"]["physics_fingerprint"]) > 10
    assert {"torch", "stable_baselines3", "sb3_contrib", "mujoco"} <= numbers["versions"].keys()
    meta = load_policy(folder / "policy.npz").meta
    assert meta == {k: v for k, v in numbers.items() if k != "sha256"}
    assert (meta["algorithm"], meta["seed"]) == ("ppo", 0)
    assert len(list((folder / "tensorboard").iterdir())) == 3


def test_a_training_that_is_done_is_not_done_again(done):
    trained = train(tiny(), done("ppo"), watch=stop_at(0))
    assert trained.env_steps == STEPS
    assert trained.file == done("ppo") / "policy.npz"


def test_seeds_differ_and_so_do_segments(done, tmp_path):
    assert len({segment_seed(seed, segment) for seed in range(5) for segment in range(5)}) == 25
    other = train(tiny(seed=1), tmp_path).policy.actor
    own = load_policy(done("ppo") / "policy.npz").actor
    assert np.any(own.layers[0].weight != other.layers[0].weight)
    assert np.abs(own.layers[-1].weight).max() > 0  # it began at zero


def test_a_folder_that_another_process_trains_in_is_refused(stopped):
    with held_elsewhere(stopped), pytest.raises(FFGymError, match=r"process \d+ .* is writing there"):
        train(tiny(), stopped)


@pytest.mark.parametrize("when", ["stopped", "done"])
def test_another_training_in_the_same_folder_is_refused(when, stopped, done):
    folder = stopped if when == "stopped" else done("ppo")
    before = events(folder)
    with pytest.raises(FFGymError, match=r"another training: training.bound was 0.6, now 0.5.*Choose another folder"):
        train(tiny(bound=0.5), folder)
    with pytest.raises(
        FFGymError, match=r"training.hyperparameters.gamma was 0.9, now 0.8; training.seed was 0, now 2"
    ):
        train(tiny("ppo", "gamma=0.8", seed=2), folder)
    assert events(folder) == before


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: b"",
        lambda data: data[: len(data) // 2],
        lambda data: b"x" + data[1:],
        lambda data: data[:-1] + b"x",
        lambda data: data.replace(b"about", b"abuot"),
    ],
    ids=["empty", "cut", "sum", "end", "inside"],
)
def test_a_damaged_checkpoint_is_one_clear_error(damage, stopped):
    place = stopped / "checkpoint.pt"
    place.write_bytes(damage(place.read_bytes()))
    with pytest.raises(FFGymError, match=r"checkpoint\.pt: the checkpoint is damaged: .* Remove it to begin"):
        train(tiny(), stopped)


@pytest.mark.parametrize(
    ("file", "change", "message"),
    [
        ("training.json", lambda data: data[:40], "training.json: is damaged"),
        ("policy.npz", lambda data: data[:-1], "policy.npz: is not what was written"),
    ],
)
def test_a_damaged_result_is_one_clear_error(file, change, message, done, tmp_path):
    for name in ("training.json", "policy.npz"):
        data = (done("ppo") / name).read_bytes()
        (tmp_path / name).write_bytes(change(data) if name == file else data)
    with pytest.raises(FFGymError, match=message):
        train(tiny(), tmp_path)


@pytest.mark.parametrize("steps", [16, STEPS])  # seen at the end, or where the next actions are drawn
def test_a_training_that_diverges_says_so(steps, tmp_path, monkeypatch):
    training = tiny("ppo", "n_epochs=1", "batch_size=16", steps=steps)
    with monkeypatch.context() as patch:
        patch.setattr(type(training), "learning_rate", lambda self, segment: float("inf"))
        with pytest.raises(FFGymError, match=r"diverged after \d+ steps.*Lower the learning rate"):
            train(training, tmp_path)


def test_the_base_acts_while_a_replay_buffer_is_filled():
    training = tiny("sac", "learning_starts=1000", "prefill_std=0.05", steps=1001)
    env = make_environment(training)
    model = under_test.make_algorithm(training, env, seed=0, segment=0)
    model.learn(16)
    env.close()
    actions = model.replay_buffer.actions[:8]
    assert 0 < np.abs(actions).max() < 0.25
    assert 0.02 < actions.std() < 0.1


def test_training_sees_p1_alone_and_the_validation_no_named_position():
    env = make_environment(tiny())
    tasks = env.get_attr("core")[0].tasks
    env.close()
    assert tuple(tasks._positions) == ("p1",)
    named = load_robot("irb4600_60_205").work_area.positions.values()
    assert all(np.linalg.norm(np.subtract(point, place)) > 0.05 for point in POINTS for place in named)
    radii, speeds = {*tasks._radii, RADIUS}, {*tasks._speeds, *SPEEDS}
    assert len(radii) > 1 < len(speeds)
    assert not any(isclose(own, held) for own in radii for held in NEW_RADII)
    assert not any(isclose(own, held) for own in speeds for held in NEW_SPEEDS)
    assert {"p2", "p3", "p4"} <= load_robot("irb4600_60_205").work_area.positions.keys()  # what the names above are


def test_machines_of_a_training_have_effects_and_are_not_those_of_the_validation():
    training = tiny(robot="irb4600_60_205_arm_drives", machines=3)
    env = make_environment(training)
    own = env.get_attr("core")[0].starts.machines
    env.close()
    assert len(own) == 3
    assert any(machine.effects for machine in own)
    others = draw_machines(training.known(), 3, SEED)
    assert not {machine.robot.friction.static[0] for machine in own} & {m.robot.friction.static[0] for m in others}


def test_machines_without_draws_are_refused():
    with pytest.raises(FFGymError, match="machines = 3 are drawn"):
        tiny(machines=3, randomization=False)


@pytest.mark.parametrize("algorithm", ["ppo", "sac"])
@pytest.mark.filterwarnings("ignore")  # of what reads the files
def test_tensorboard_shows_the_points_of_the_learning_curve(algorithm, tmp_path):
    accumulator = pytest.importorskip("tensorboard.backend.event_processing.event_accumulator")
    trained = train(tiny(algorithm), tmp_path)
    shown = []
    for file in (tmp_path / "tensorboard").iterdir():
        events = accumulator.EventAccumulator(str(file))
        events.Reload()
        shown += [(event.step, event.value) for event in events.Scalars("train/reward_per_step")]
    assert [steps for steps, _ in sorted(shown)] == [steps for steps, _ in trained.curve]
    np.testing.assert_allclose([value for _, value in sorted(shown)], [value for _, value in trained.curve], rtol=1e-6)
