"""An id keeps meaning what it meant: a change of physics or behaviour needs a new version."""

from dataclasses import replace

import numpy as np
import pytest

import ffgym.envs.circle_path
import ffgym.envs.core
import ffgym.envs.rewards
import scripts.env_fingerprints
from ffgym.core.errors import FFGymError
from ffgym.core.registration import ENVIRONMENTS
from ffgym.envs.fingerprint import check, read_fingerprints
from scripts.env_fingerprints import Config, main


@pytest.mark.parametrize("name", sorted(ENVIRONMENTS))
def test_every_id_is_what_it_was_when_its_version_was_given(name):
    check(name)


def test_no_fingerprint_is_kept_for_an_id_that_is_gone():
    assert sorted(read_fingerprints()) == sorted(ENVIRONMENTS)


def changed_stiffness(robot):
    return replace(robot, drive=replace(robot.drive, joint_stiffness=robot.drive.joint_stiffness * (1 + 1e-6)))


def changed_gain(robot):
    return replace(robot, servo=replace(robot.servo, velocity_gain=robot.servo.velocity_gain * 1.001))


@pytest.mark.parametrize("change", [changed_stiffness, changed_gain])
def test_a_changed_constant_of_the_robot_asks_for_a_new_version(monkeypatch, change):
    original = ffgym.envs.tasks.robot_of
    monkeypatch.setattr(ffgym.envs.tasks, "robot_of", lambda robot: change(original(robot)))
    with pytest.raises(FFGymError, match=r"model.* changed.*bump the version \(register ffgym/CirclePath-v1"):
        check("ffgym/CirclePath-v0")


def test_a_changed_reward_asks_for_a_new_version(monkeypatch):
    original = ffgym.envs.rewards.MotorError.cost
    monkeypatch.setattr(ffgym.envs.rewards.MotorError, "cost", lambda *a: 1.0001 * original(*a))
    with pytest.raises(FFGymError, match=r": behaviour changed.*bump the version \(register ffgym/OneAxis-v1"):
        check("ffgym/OneAxis-v0")


@pytest.mark.parametrize(
    "change",
    [
        (ffgym.envs.core, "path_error", lambda original: lambda *a, **k: 1.001 * original(*a, **k)),
        (ffgym.envs.rewards.AbsolutePathError, "cost", lambda original: lambda *a: 1.001 * original(*a)),
        (ffgym.envs.rewards.RelativePathError, "cost", lambda original: lambda *a: 1.001 * original(*a)),
        (ffgym.envs.rewards.FeedbackEffort, "cost", lambda original: lambda *a: 1.001 * original(*a)),
        (ffgym.envs.rewards.Reward, "__call__", lambda original: lambda *a: original(*a) * np.where(a[3], 2, 1)),
    ],
    ids=["path error", "privileged reward", "relative reward", "feedback reward", "price of a stop"],
)
def test_what_only_some_see_is_part_of_what_an_id_means(monkeypatch, change):
    owner, name, wrap = change
    monkeypatch.setattr(owner, name, wrap(getattr(owner, name)))
    with pytest.raises(FFGymError, match="behaviour changed"):
        check("ffgym/CirclePath-v0")


def test_a_changed_default_asks_for_a_new_version(monkeypatch):
    defaults = ffgym.envs.OneAxisVectorEnv.tasks.__init__.__kwdefaults__
    monkeypatch.setitem(defaults, "frequencies", (1.0, 2.0))
    with pytest.raises(FFGymError, match="bump the version"):
        check("ffgym/OneAxis-v0")


def test_the_script_writes_what_is_stored(tmp_path, monkeypatch):
    monkeypatch.setattr(scripts.env_fingerprints, "ENVIRONMENTS", ["ffgym/OneAxis-v0"])
    main(Config(out=tmp_path / "fingerprints.json"))
    monkeypatch.setattr(ffgym.envs.fingerprint.resources, "files", lambda _: tmp_path)
    read_fingerprints.cache_clear()
    try:
        again = read_fingerprints()
    finally:
        monkeypatch.undo()
        read_fingerprints.cache_clear()
    (name,), kept = again, read_fingerprints()["ffgym/OneAxis-v0"]
    assert name == "ffgym/OneAxis-v0"
    assert again[name]["model"] == kept["model"]
    np.testing.assert_allclose(again[name]["behaviour"], kept["behaviour"], rtol=1e-6, atol=1e-6)


def test_an_id_without_fingerprint_is_an_error():
    with pytest.raises(FFGymError, match=r"no stored fingerprint.*scripts\.env_fingerprints"):
        check("ffgym/Nothing-v0")
