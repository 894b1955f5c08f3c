import shlex

import numpy as np
import pytest
import tyro

from agents.artefacts import manifest_of, path_of
from agents.residual.actor import Actor, Layer
from agents.residual.plan import Training
from agents.residual.policy import ResidualPolicy, load_policy, save_policy
from ffgym.errors import FFGymError
from scripts.publish import Config, main
from scripts.train import Sweep

ACTOR = Actor(
    n_motors=6,
    layers=(Layer(weight=np.zeros((1, 24), dtype=np.float32), bias=np.zeros(1, dtype=np.float32)),),
    activation="tanh",
    output="clip",
    factored=True,
)


def trained(folder, seed, curve=((16.0, -1.0), (32.0, -0.5)), **changes):
    """A folder as a training leaves it."""
    training = Training(algorithm="ppo", seed=seed, steps=32, memory=4, **changes)
    meta = {"training": training.document(), "env_steps": 32, "learning_curve": [list(point) for point in curve]}
    (folder / f"seed_{seed}").mkdir(parents=True)
    what = ResidualPolicy(base=training.base, actor=ACTOR, memory=4, bound=0.6, action_scale=110.0, meta=meta)
    save_policy(folder / f"seed_{seed}" / "policy.npz", what)


def test_policies_are_copied_with_a_manifest_that_can_be_read(tmp_path):
    for seed in (0, 1):
        trained(tmp_path / "sweep", seed, curve=((16.0, -1.0 - seed), (32.0, -0.5 - seed)))
    main(Config(name="ppo_elastic", folder=tmp_path / "sweep", out=tmp_path / "out"))
    manifest_of.cache_clear()
    manifest = manifest_of("ppo_elastic", tmp_path / "out")
    assert manifest.seeds == (0, 1)
    assert manifest.learning_curve == ((16.0, -1.5), (32.0, -1.0))
    artefact = manifest.find("workcell:thesis", 1)
    assert artefact.env_steps == 32
    assert artefact.robot_seconds == 0.0
    assert load_policy(path_of("ppo_elastic", artefact, tmp_path / "out")).meta["training"]["seed"] == 1


def test_the_command_in_the_manifest_asks_for_the_same_training(tmp_path):
    for seed in (3, 5):
        trained(tmp_path / "sweep", seed, base="lugre_dynamic", bound=0.3, randomization=False, factored=False)
    manifest = main(Config(name="ppo_lugre", folder=tmp_path / "sweep", out=tmp_path / "out"))
    train, publish = manifest.command.split(" && ")
    sweep = tyro.cli(Sweep, args=shlex.split(train)[3:])
    assert sweep.seeds == (3, 5)
    wanted = Training(
        algorithm="ppo",
        base="lugre_dynamic",
        seed=3,
        steps=32,
        memory=4,
        bound=0.3,
        randomization=False,
        factored=False,
    )
    assert sweep.with_seed(3).document() == wanted.document()
    assert publish == "python -m scripts.publish ppo_lugre out/ppo_lugre"


def test_trainings_that_differ_in_more_than_the_seed_are_refused(tmp_path):
    trained(tmp_path, 0)
    trained(tmp_path, 1, bound=0.3)
    with pytest.raises(FFGymError, match="differ in more than the seed"):
        main(Config(name="ppo_elastic", folder=tmp_path, out=tmp_path / "out"))
    assert not (tmp_path / "out").exists()


def test_an_empty_folder_is_refused(tmp_path):
    with pytest.raises(FFGymError, match="train first"):
        main(Config(name="ppo_elastic", folder=tmp_path))
