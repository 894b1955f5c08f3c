"""`ffgym leaderboard submit` packs an agent, `ffgym leaderboard verify` accepts it, or says in one line why not."""

import json
from dataclasses import fields

import numpy as np
import pytest

from ffgym.cli import submission
from ffgym.cli.learning_options import NewRound, Verify
from ffgym.cli.main import main
from ffgym.leaderboard.submission import judge
from ffgym.leaderboard.submission.rounds import Round
from ffgym.robot import load_robot
from tests.cli.errors import read_error
from tests.leaderboard.submission_samples import PLAN, ROBOT, agent_file, changed

WHO = ["--name", "mine", "--author", "somebody", "--track", "causal, nominal parameters"]


@pytest.fixture
def small(monkeypatch, tmp_path):
    """A folder with an agent's file, and one circle instead of the standard ones."""
    monkeypatch.setattr(judge, "STANDARD", PLAN)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_bytes(agent_file())
    return tmp_path


def test_what_is_submitted_is_accepted_and_what_is_changed_is_refused_in_one_line(small, capsys):
    assert (
        main(
            [
                "leaderboard",
                "submit",
                "mine.py",
                *WHO,
                "--out",
                "agent.zip",
                "--json",
                "packed.json",
                "--env-steps",
                "7",
            ]
        )
        == 0
    )
    assert "file: agent.zip" in capsys.readouterr().out
    packed = json.loads((small / "packed.json").read_text())
    assert packed["manifest"]["env_steps"] == 7
    assert packed["inference_us_measured"] > 0

    assert main(["leaderboard", "verify", "agent.zip", "--machines", "0", "--json", "verdict.json"]) == 0
    out = capsys.readouterr().out
    assert (
        "mine by somebody, with feedback, causal, nominal parameters: accepted, without a score: no machines were drawn"
        in out
    )
    verdict = json.loads((small / "verdict.json").read_text())
    assert verdict["accepted"]
    assert verdict["claims"] == packed["manifest"]["claims"]

    weights = changed((small / "agent.zip").read_bytes(), {"agent.py": b"PREVIEW = 1"})
    (small / "agent.zip").write_bytes(weights)
    assert main(["leaderboard", "verify", "agent.zip", "--json", "verdict.json"]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("ffgym: error: agent.zip: refused, files: weights were changed")
    verdict = json.loads((small / "verdict.json").read_text())
    assert (verdict["accepted"], verdict["check"]) == (False, "files")


def test_a_committed_round_is_run_after_it_was_revealed_and_its_seed_repeats_it(small, capsys):
    sent = ["--channel", "setpoint", "--robot-seconds", "5", "--out", "agent.zip"]
    assert main(["leaderboard", "submit", "mine.py", *WHO, *sent]) == 0
    size = ["--machines", "2", "--motions", "1", "--series", "draw:", "--kinds", "square"]
    assert main(["leaderboard", "round", *size]) == 0
    out = capsys.readouterr().out
    published, secret = (json.loads((small / name).read_text()) for name in ("round.json", "round_secret.json"))
    assert f"commitment: {published['commitment']}" in out

    verify = ["leaderboard", "verify", "agent.zip", "--json", "verdict.json"]
    committed = ["--round", "round_secret.json", "--committed", "round.json"]
    assert main([*verify, *committed, "--beside", "lugre_dynamic"]) == 0
    lines = capsys.readouterr().out.splitlines()
    [line] = [
        line
        for line in lines
        if line.startswith("mine by somebody, with feedback through set-points, causal, nominal parameters: accepted, ")
    ]
    assert "on 2 machines and 1 motion that were drawn it leaves " in line
    assert "robot time: 0 s before the scored motions, as counted here; 5 s in training, as claimed" in lines
    first = json.loads((small / "verdict.json").read_text())
    assert first["drawn"]["round"] == secret
    assert first["isolation"].partition(":")[0] in ("bubblewrap", "declared", "none")
    rows = {row["name"]: row for row in first["drawn"]["rows"]}
    assert {name for name, row in rows.items() if row["channel"] == "setpoint"} == {"mine"}
    assert [line.split()[0] for line in lines if line.endswith("with feedback through set-points")] == ["mine"]
    left = [
        ours["rms_mm"] / none["rms_mm"]
        for ours, none in zip(*(rows[n]["circles"] for n in ("mine", "none")), strict=True)
    ]
    assert rows["mine"]["score"]["left"] == pytest.approx(np.exp(np.mean(np.log(left))), rel=1e-9)
    assert rows["mine"]["by_kind"] == {"square": pytest.approx(rows["mine"]["score"]["left"], rel=1e-9)}
    assert f"{'by kind of motion':20}  square" in lines
    assert {circle["plant"] for circle in rows["mine"]["circles"]} == set(first["drawn"]["plants"])
    assert sorted(rows) == ["elastic", "lugre_dynamic", "mine", "none"]

    options = Verify(
        submission=small, round_seed=secret["seed"], machines=2, motions=1, series="draw:", kinds=("square",)
    )
    again = submission.find_round(options)
    assert sorted(again.plants) == sorted(first["drawn"]["plants"])
    assert again.draw_motions(load_robot(ROBOT).work_area)[0].kind == "square"


def test_the_secret_of_a_round_is_never_written_over(small, capsys):
    size = ["--machines", "2", "--motions", "1", "--out", "kept.json", "--secret", "kept_secret.json"]
    assert main(["leaderboard", "round", *size]) == 0
    published, secret = ((small / name).read_bytes() for name in ("kept.json", "kept_secret.json"))
    (small / "kept.json").unlink()
    assert main(["leaderboard", "round", *size]) == 0
    assert "holds a round, which is kept" in capsys.readouterr().out
    assert [(small / name).read_bytes() for name in ("kept.json", "kept_secret.json")] == [published, secret]
    assert main(["leaderboard", "round", *size, "--motions", "2"]) == 1
    assert "holds the seed of a round of other machines or motions" in capsys.readouterr().err
    assert (small / "kept_secret.json").read_bytes() == secret


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--committed", "round.json"], "--committed needs the revealed round"),
        (["--round", "round.json", "--round-seed", "1"], "both give a seed"),
        (["--round", "round.json"], "its seed is published after the round"),
        (["--round", "other.json", "--committed", "round.json"], "not the one that was committed to"),
        (["--machines", "-1"], "machines of a round = -1"),
        (["--series", "robot:"], "Unknown plant"),
        (["--beside", "nobody"], "Unknown agent 'nobody'"),
        (["--beside", "bsn_extended"], "learns"),
    ],
)
def test_a_round_that_cannot_be_run_is_told_in_one_line_before_anything_runs(small, capsys, options, message):
    for out, secret in (("round.json", "secret.json"), ("published.json", "other.json")):
        assert main(["leaderboard", "round", "--out", out, "--secret", secret, "--machines", "1"]) == 0
    capsys.readouterr()
    assert main(["leaderboard", "verify", "none.zip", *options]) == 1
    assert message in read_error(capsys)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["bsn_extended", *WHO], "cannot be submitted by its name"),
        (["oracle", *WHO], "cannot be submitted by its name"),
        (["lugre_static:file.toml", *WHO], "takes no file"),
        (["nobody", *WHO], "Unknown agent 'nobody'"),
        (["none.npz", *WHO], "none.npz: no such file"),
        (["none.py", *WHO], "none.py: no such file"),
        (["mine.py", *WHO, "--out", "agent.txt"], "must end in .zip"),
        (["mine.py", *WHO, "--out", "elsewhere/agent.zip"], "does not exist"),
        (["mine.py", *WHO, "--seed", "-1"], "seed = -1"),
        (["mine.py", "--name", " ", *WHO[2:]], "name = ' ' must be a line"),
    ],
)
def test_what_cannot_be_submitted_is_refused_before_anything_runs(small, capsys, arguments, message):
    assert main(["leaderboard", "submit", *arguments]) == 1
    assert message in read_error(capsys)
    assert [path.name for path in small.iterdir()] == ["mine.py"]


@pytest.mark.parametrize(
    ("file", "message"),
    [
        ("none.zip", "no such file"),
        ("mine.py", "refused, archive"),
        (".", "must be a file"),
        ("/dev/zero", "must be a file"),
        ("x" * 300, "cannot be read"),
    ],
)
def test_what_is_no_submission_is_refused_in_one_line(small, capsys, file, message):
    assert main(["leaderboard", "verify", file]) == 1
    assert message in read_error(capsys)


def test_a_verdict_that_cannot_be_written_is_told_in_one_line(small, capsys):
    assert main(["leaderboard", "verify", "mine.py", "--json", "x" * 300 + ".json"]) == 1
    assert "cannot be written" in read_error(capsys)


def test_the_oracle_has_no_track_for_submissions(small):
    with pytest.raises(SystemExit):
        main(["leaderboard", "submit", "mine.py", "--name", "a", "--author", "b", "--track", "oracle"])


@pytest.mark.parametrize("options", [Verify, NewRound])
def test_sizes_of_a_round_are_those_of_the_library(options):
    drawn = Round(seed=1)
    defaults = {field.name: field.default for field in fields(options)}
    for name in ("machines", "motions", "series", "kinds"):
        assert defaults[name] == getattr(drawn, name)
