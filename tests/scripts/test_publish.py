import shlex

import numpy as np
import pytest
import tyro

from ffgym.agents.artefacts import TRAINED, locate_artefact, read_manifest
from ffgym.agents.residual.actor import Actor, LinearLayer
from ffgym.agents.residual.hyperparameters import hyperparameters
from ffgym.agents.residual.plan import Training
from ffgym.agents.residual.policy import ResidualPolicy, load_policy, save_policy
from ffgym.cli.train_policy import options_of
from ffgym.core.errors import FFGymError
from scripts.publish import Config, command_of, main
from scripts.train import Sweep

ACTOR = Actor(
    n_motors=6,
    layers=(LinearLayer(weight=np.zeros((1, 24), dtype=np.float32), bias=np.zeros(1, dtype=np.float32)),),
    activation="tanh",
    output="clip",
    factored=True,
)
CURVE = ((16.0, -1.0), (32.0, -0.5))
ORIGIN = {"physics_fingerprint": "f00d"}
VERSIONS = {"ffgym": "0.0.1", "torch": "2.3"}
ABOUT = {"origin": ORIGIN, "versions": VERSIONS, "env_steps": 32, "learning_curve": CURVE}


def trained(folder, seed, curve=CURVE, origin=ORIGIN, versions=VERSIONS, named=None, **changes):
    """A folder as a training leaves it."""
    training = Training(**{"algorithm": "ppo", "seed": seed, "steps": 32, "memory": 4} | changes)
    meta = ABOUT | {"training": training.document(), "origin": origin, "versions": versions}
    meta |= {"learning_curve": [list(point) for point in curve]}
    place = folder / (named or f"seed_{seed}")
    place.mkdir(parents=True)
    what = ResidualPolicy(base=training.base, actor=ACTOR, memory=4, bound=0.6, action_scale=110.0, meta=meta)
    save_policy(place / "policy.npz", what)
    return training


def publish(tmp_path, name="ppo_elastic", folder="sweep"):
    return main(Config(name=name, folder=tmp_path / folder, out=tmp_path / "out"))


def test_policies_are_copied_with_a_manifest_that_can_be_read(tmp_path):
    for seed in (0, 1):
        trained(tmp_path / "sweep", seed, curve=((16.0, -1.0 - seed), (32.0, -0.5 - seed)))
    publish(tmp_path)
    read_manifest.cache_clear()
    manifest = read_manifest("ppo_elastic", tmp_path / "out")
    assert manifest.seeds == (0, 1)
    assert manifest.learning_curve == ((16.0, -1.5), (32.0, -1.0))
    assert manifest.versions == VERSIONS
    artefact = manifest.find("workcell:thesis", 1)
    assert (artefact.env_steps, artefact.robot_seconds, artefact.fingerprint) == (32, 0.0, "f00d")
    assert load_policy(locate_artefact("ppo_elastic", artefact, tmp_path / "out")).meta["training"]["seed"] == 1


def test_policies_of_seeds_that_are_no_longer_there_go(tmp_path):
    for seed in (0, 1):
        trained(tmp_path / "sweep", seed)
    trained(tmp_path / "less", 1)
    publish(tmp_path)
    assert publish(tmp_path, folder="less").seeds == (1,)
    assert [place.name for place in (tmp_path / "out" / "ppo_elastic" / "any").iterdir()] == ["seed_1.npz"]


OTHERWISE = {"base": "lugre_dynamic", "bound": 0.3, "randomization": False, "factored": False}
MACHINES = {"base": "lugre_dynamic", "robot": "irb4600_60_205_arm_drives", "machines": 4}
SET = {"hyperparameters": hyperparameters("ppo", ["hidden=[64, 64]", "activation=relu", "learning_rate=1e-5"])}


@pytest.mark.parametrize("changes", [OTHERWISE, {"base": "lugre_dynamic", "reward": "path_error", **SET}])
def test_the_command_in_the_manifest_asks_for_the_same_training(changes, tmp_path):
    for seed in (3, 5):
        wanted = trained(tmp_path / "sweep", seed, **changes)
    train, again = publish(tmp_path, "ppo_lugre").command.split(" && ")
    sweep = tyro.cli(Sweep, args=shlex.split(train)[3:])
    assert sweep.seeds == (3, 5)
    assert sweep.with_seed(5).document() == wanted.document()
    assert again == "python -m scripts.publish ppo_lugre out/ppo_lugre"


def test_machines_can_be_asked_for():
    training = Training(**MACHINES)
    assert options_of(training)[-4:] == ["--robot", "irb4600_60_205_arm_drives", "--machines", "4"]


def test_a_recurrent_policy_on_another_robot_can_be_asked_for_too():
    training = Training(algorithm="recurrent_ppo", factored=False, robot="one_axis", base="none")
    assert options_of(training)[-2:] == ["--robot", "one_axis"]


def test_what_options_cannot_say_is_refused():
    with pytest.raises(FFGymError, match="needs a machine file"):
        options_of(Training(base="model", machine="[machine]"))


def test_a_machine_file_is_named_by_its_option(tmp_path):
    file = tmp_path / "machine.toml"
    file.write_text('[machine]\ntitle = "mine"\nrobot = "irb4600_60_205"\n')
    training = Training(base="model", machine=file.read_text())
    assert f"model:{file}" in options_of(training, f"model:{file}")
    file.write_text(file.read_text().replace("mine", "other"))
    with pytest.raises(FFGymError, match="its machine would differ"):
        options_of(training, f"model:{file}")


@pytest.mark.parametrize("name", ["ppo_elastic_memory", "ppo_none", "sac_elastic"])
def test_commands_of_policies_that_ship_ask_for_what_they_are(name):
    manifest = read_manifest(name, TRAINED)
    about = load_policy(locate_artefact(name, manifest.artefacts[0])).meta["training"]
    assert command_of(name, Training(**about), manifest.seeds) == manifest.command


@pytest.mark.parametrize(
    ("other", "message"),
    [
        ({"seed": 1, "bound": 0.3}, "seed_0 and seed_1 differ in more than the seed: training.bound"),
        ({"seed": 1, "origin": {"physics_fingerprint": "cafe"}}, "differ in .*: origin.physics_fingerprint"),
        ({"seed": 1, "versions": {"ffgym": "0.0.1"}}, r"differ in .*: versions.torch"),
        ({"seed": 1, "named": "seed_old"}, "seed_old: its name must be seed_<number>"),
        ({"seed": 1, "named": "seed_2"}, "was trained with seed 1; its folder must be seed_1"),
    ],
)
def test_trainings_that_differ_in_more_than_the_seed_are_refused(other, message, tmp_path):
    trained(tmp_path / "sweep", 0)
    trained(tmp_path / "sweep", **other)
    with pytest.raises(FFGymError, match=message):
        publish(tmp_path)
    assert not (tmp_path / "out").exists()


def test_what_the_row_is_not_of_is_refused(tmp_path):
    trained(tmp_path / "sweep", 0)
    with pytest.raises(FFGymError, match=r"ppo_lugre is a row of ppo on lugre_dynamic, .* these are of ppo on "):
        publish(tmp_path, "ppo_lugre")
    with pytest.raises(FFGymError, match=r"ppo_drives is a row of .* on machines .*, these are of .* on robots\."):
        publish(tmp_path, "ppo_drives")
    with pytest.raises(FFGymError, match="Unknown row of trained residual policies 'best'"):
        publish(tmp_path, "best")
    assert not (tmp_path / "out").exists()


def test_an_empty_folder_and_policies_of_no_training_are_refused(tmp_path):
    with pytest.raises(FFGymError, match="train first"):
        publish(tmp_path)
    (tmp_path / "sweep" / "seed_0").mkdir(parents=True)
    for meta, message in (
        ({}, "does not say its training, origin, versions, env_steps, learning_curve"),
        (ABOUT | {"training": {"seed": 0, "steps": 32, "wings": 2}}, "is of a training that this ffgym has not"),
        (ABOUT | {"training": {"seed": 0, "steps": 32}}, "some of its settings are others here"),
    ):
        what = ResidualPolicy(base="none", actor=ACTOR, memory=4, bound=0.6, action_scale=30.0, meta=meta)
        save_policy(tmp_path / "sweep" / "seed_0" / "policy.npz", what)
        with pytest.raises(FFGymError, match=message):
            publish(tmp_path)
