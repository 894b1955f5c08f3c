"""`ffgym play`: files that can be read back, numbers, and requests that cannot be met."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import tyro

from ffgym.cli import play
from ffgym.cli.main import main
from ffgym.cli.motion_options import Play
from ffgym.envs.machines import make_rig
from ffgym.leaderboard.submission.manifest import AgentSource
from ffgym.robot import ModelOptions, compile_model, physics_fingerprint
from tests.cli.errors import read_error
from tests.leaderboard.submission_samples import packed

iio = pytest.importorskip("imageio.v3")

SMALL = ("--width", "160", "--height", "90")
CIRCLE = ("--speed-mm-s", "100", "--radii-mm", "3", *SMALL)


@pytest.fixture(scope="module")
def filmed(tmp_path_factory, needs_gl):
    """Folder with a video of one fast circle, and its numbers."""
    folder = tmp_path_factory.mktemp("video")
    files = ("--out", str(folder / "circle.mp4"), "--json", str(folder / "circle.json"))
    assert main(["play", *files, "--law", "lugre_dynamic", *CIRCLE, "--playback", "0.5", "--fps", "20"]) == 0
    return folder


@pytest.mark.filterwarnings("ignore:Exception ignored in:pytest.PytestUnraisableExceptionWarning")  # imageio's reader
def test_the_video_has_the_frames_that_its_speed_asks_for(filmed):
    numbers = json.loads((filmed / "circle.json").read_text())
    assert {p.name for p in filmed.iterdir()} == {"circle.mp4", "circle.json"}
    frames = iio.imread(filmed / "circle.mp4")
    assert frames.shape == (numbers["frames"], 90, 160, 3)
    duration = numbers["length"] * 0.004
    assert numbers["frames"] == int(duration / 0.5 * 20 + 1e-9) + 1
    assert (frames[0] != frames[-1]).mean() > 0.01


def test_the_numbers_say_what_was_filmed_and_where_it_comes_from(filmed, irb4600):
    numbers = json.loads((filmed / "circle.json").read_text())
    assert numbers["command"] == "ffgym play"
    assert numbers["config"]["law"] == "lugre_dynamic"
    assert numbers["task"] == {"position": "p1", "speed": 0.1, "radii": [0.003]}
    assert numbers["seed"] == 0
    assert numbers["versions"].keys() == {"ffgym", "mujoco", "numpy", "scipy", "gymnasium", "python"}
    assert numbers["physics_fingerprint"] == physics_fingerprint(compile_model(irb4600, ModelOptions(looks=False)))
    assert numbers["return"] < 0
    assert not numbers["terminated"]
    assert 0.1 < numbers["rms_path_error_mm"] < 1.0
    assert len(numbers["rms_motor_error_rad"]) == 6


def test_a_gif_of_one_axis(needs_gl, tmp_path, capsys):
    out = tmp_path / "axis.gif"
    arguments = ("--env", "ffgym/OneAxis-v0", "--frequency-hz", "3", "--playback", "10", "--fps", "5", *SMALL)
    assert main(["play", "--out", str(out), *arguments]) == 0
    assert iio.improps(out).shape == (6, 90, 160, 3)
    assert iio.immeta(out)["duration"] == 200
    assert "frames: 6" in capsys.readouterr().out


def test_another_robot_on_a_motion_of_its_own(needs_gl, tmp_path, capsys):
    out, numbers = tmp_path / "screw.gif", tmp_path / "screw.json"
    arguments = ("--env", "ffgym/FollowPath-v0", "--robot", "ball_screw", "--path", "sine", "--playback", "10", *SMALL)
    assert main(["play", "--out", str(out), "--json", str(numbers), *arguments, "--fps", "5"]) == 0
    values = json.loads(numbers.read_text())
    assert (values["robot"], values["task"]) == ("ball_screw", {"path": "sine"})
    assert values["rms_path_error_mm"] is None
    assert "path error" not in capsys.readouterr().out


@pytest.mark.parametrize("env", ["ffgym/CirclePath-v0", "ffgym/WorkcellCircles-v0"])
def test_a_workcell_is_filmed_as_what_it_is(env, needs_gl, tmp_path):
    out, numbers = tmp_path / "cell.gif", tmp_path / "cell.json"
    circle = ("--speed-mm-s", "100", "--radii-mm", "1", "--playback", "10", "--fps", "5")
    arguments = ("--env", env, "--robot", "workcell:thesis", "--json", str(numbers), *circle, *SMALL)
    assert main(["play", "--out", str(out), *arguments]) == 0
    values = json.loads(numbers.read_text())
    assert values["robot"] == "workcell:thesis"
    assert values["physics_fingerprint"] == make_rig("workcell:thesis").fingerprint


def play_still(tmp_path, *arguments):
    """The picture and the numbers of a still."""
    out, numbers = tmp_path / "still.png", tmp_path / "still.json"
    assert main(["play", *arguments, "--out", str(out), "--json", str(numbers), *SMALL]) == 0
    return iio.imread(out), json.loads(numbers.read_text())


def test_a_law_and_a_trained_policy_side_by_side_meet_the_same_episode(needs_gl, tmp_path):
    circle = ("--speed-mm-s", "100", "--radii-mm", "3")
    both, numbers = play_still(tmp_path, "none", "ppo_elastic", *circle)
    assert both.shape == (90, 320, 3)
    law, policy = numbers["agents"]
    assert (law["agent"], policy["agent"], numbers["agent"]) == ("none", "ppo_elastic", "none")
    assert law["length"] == policy["length"]
    assert 20 * policy["rms_path_error_mm"] < law["rms_path_error_mm"]
    # each as it is alone, at the time when the law is worst
    worst, alone = play_still(tmp_path, "none", *circle)
    assert np.array_equal(worst, both[:, :160])
    assert alone["agents"] == [law]


def test_agents_bring_their_own_base_on_a_machine_that_is_drawn(needs_gl, tmp_path):
    arguments = ("--env", "ffgym/Adapt-v0", "--speed-mm-s", "100", "--radii-mm", "3", "--at", "0.5")
    picture, numbers = play_still(tmp_path, "none", "elastic", *arguments)
    assert picture.shape == (90, 320, 3)
    errors = [agent["rms_path_error_mm"] for agent in numbers["agents"]]
    assert 2 * errors[1] < errors[0]  # with the environment's base below it, none would be as good


@pytest.mark.slow
def test_a_submission_decides_on_the_robot_of_the_environment(needs_gl, tmp_path):
    submission = tmp_path / "mine.zip"
    submission.write_bytes(packed(AgentSource(kind="law", law="elastic")).data)
    arguments = ("--env", "ffgym/CirclePath-v1", "--speed-mm-s", "100", "--radii-mm", "1")
    _, numbers = play_still(tmp_path, "elastic", str(submission), *arguments)
    law, mine = numbers["agents"]
    assert mine["rms_path_error_mm"] == pytest.approx(law["rms_path_error_mm"], rel=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["amortised", "amortised_recurrent"])
def test_an_estimator_practises_a_lap_on_the_machine_first(name, needs_gl, tmp_path):
    machine = ("--env", "ffgym/CirclePath-v1", "--robot", "workcell:drives-1")
    _, numbers = play_still(tmp_path, "elastic", name, *machine, "--position", "p3", *CIRCLE[:4])
    law, adapted = (agent["rms_path_error_mm"] for agent in numbers["agents"])
    assert 2 * adapted < law


def test_a_still_shows_the_time_that_is_asked_for(needs_gl, tmp_path):
    axis = ("none", "--env", "ffgym/OneAxis-v0", "--frequency-hz", "3")
    pictures = [play_still(tmp_path, *axis, *at)[0] for at in (("--at", "0.5"), ())]
    assert np.any(pictures[0] != pictures[1])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["none", "elastic", "oracle"], "There is room for two agents, got none elastic oracle"),
        (["none", "--law", "lugre_static"], "--law lugre_static is for plays without named agents, got none too"),
        (["nobody"], "Unknown agent 'nobody'. Available: "),
        (["nobody.npz"], "nobody.npz: no such file"),
        (["nobody.zip"], "nobody.zip: "),
        (["model_fitted"], "Agent 'model_fitted' was trained on another machine"),
        (["amortised", "--env", "ffgym/OneAxis-v0"], "amortised cannot practise on one_axis: Robot 'one_axis' has no "),
        (["amortised:machine.toml"], "Agent 'amortised' takes no file, got 'amortised:machine.toml'"),
        (["ppo_elastic", "--env", "ffgym/OneAxis-v0"], "ppo_elastic cannot run in ffgym/OneAxis-v0: A policy for 6"),
        (["--out", "a.mp4", "--at", "1"], "--at 1 is for a still, --out FILE.png"),
        (["--out", "a.png", "--at", "99", "--speed-mm-s", "100", "--radii-mm", "1"], "at = 99 s is after the end of"),
        (["--window", "--at", "1"], "--at has no effect in a window"),
        (["--out", "a.avi"], "a.avi: a video must end in .mp4 or .gif, a still in .png, got '.avi'"),
        (["--out", "nowhere/a.mp4"], "does not exist"),
        (["--out", "a.mp4", "--json", "a.mp4"], "--out and --json are both"),
        (["--env", "ffgym/Triangle-v0"], "Unknown environment 'ffgym/Triangle-v0'. Available: "),
        (["--env", "ffgym/OneAxis-v0", "--position", "p2"], "--position is for ffgym/CirclePath-v0"),
        (["--env", "ffgym/WorkcellCircles-v0", "--robot", "one_axis"], "--robot one_axis is no workcell"),
        (["--robot", "workcell:nobody"], "Unknown workcell 'workcell:nobody'"),
        (["--frequency-hz", "1"], "--frequency-hz is for ffgym/OneAxis-v0"),
        (["--path", "circles"], "--path is for ffgym/FollowPath-v0"),
        (["--robot", "nobody"], "Unknown robot 'nobody'"),
        (["--position", "p9"], "Unknown position 'p9'"),
        (["--speed-mm-s", "0"], "speed = 0.0 m/s is out of range"),
        (["--playback", "0"], "playback = 0.0 is out of range"),
        (["--playback", "1e-308"], "playback = 1e-308 is out of range"),
        (["--fps", "1000"], "fps = 1000.0 1/s is out of range"),
        (["--magnify", "-1"], "magnify = -1.0 is out of range"),
        (["--width", "9"], "width = 9.0 pixel is out of range"),
        (["--seed", "-1"], "seed = -1.0 is out of range"),
    ],
)
def test_a_video_that_cannot_be_made_is_one_line_and_exit_code_1(arguments, message, needs_gl, capsys, tmp_path):
    arguments = [str(tmp_path / a) if a.startswith(("a.", "nowhere")) else a for a in arguments]
    if not {"--out", "--window"} & set(arguments):
        arguments = ["--out", str(tmp_path / "b.mp4"), *arguments]
    assert main(["play", *SMALL, *arguments]) == 1
    assert message in read_error(capsys)
    assert not list(tmp_path.iterdir())


def test_a_missing_package_is_named(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr("ffgym.cli.outputs.is_installed", lambda name: name != "imageio-ffmpeg")
    assert main(["play", "--out", str(tmp_path / "a.mp4")]) == 1
    assert "needs imageio-ffmpeg; pip install 'ffgym[video]'" in capsys.readouterr().err


@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
def test_an_interrupt_leaves_no_half_file_and_the_old_one(suffix, needs_gl, monkeypatch, tmp_path):
    out = tmp_path / f"old{suffix}"
    out.write_bytes(b"old")
    made = play.make

    def make(config):
        (player,) = made(config)
        step, count = player.step, iter(range(100))

        def interrupted():
            if next(count) == 50:
                raise KeyboardInterrupt
            step()

        monkeypatch.setattr(player, "step", interrupted)
        return [player]

    monkeypatch.setattr(play, "make", make)
    assert main(["play", "--out", str(out), *CIRCLE]) == 130
    assert [p.name for p in tmp_path.iterdir()] == [out.name]
    assert out.read_bytes() == b"old"


def test_the_commands_of_the_documentation_parse():
    text = (Path(__file__).parents[2] / "docs" / "rendering.md").read_text(encoding="utf-8")
    commands = re.findall(r"^ffgym play (.*)$", text, flags=re.M)
    assert len(commands) == 4
    for command in commands:
        play.check(tyro.cli(Play, args=command.split()))
