"""`ffgym leaderboard submit` packs an agent, `ffgym leaderboard verify` accepts it, or says in one line why not."""

import json

import pytest

from ffgym.cli.main import main
from ffgym.leaderboard.submission import judge
from tests.leaderboard.submission_samples import PLAN, agent_file, changed

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

    assert main(["leaderboard", "verify", "agent.zip", "--json", "verdict.json"]) == 0
    out = capsys.readouterr().out
    assert "mine by somebody, causal, nominal parameters: accepted" in out
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


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["bsn_extended", *WHO], "cannot be submitted by its name"),
        (["oracle", *WHO], "cannot be submitted by its name"),
        (["lugre_static:file.toml", *WHO], "takes no file"),
        (["nobody", *WHO], "Unknown agent 'nobody'"),
        (["none.npz", *WHO], "none.npz: cannot be read"),
        (["none.py", *WHO], "none.py: no such file"),
        (["mine.py", *WHO, "--out", "agent.txt"], "must end in .zip"),
        (["mine.py", *WHO, "--out", "elsewhere/agent.zip"], "does not exist"),
        (["mine.py", *WHO, "--seed", "-1"], "seed = -1"),
        (["mine.py", "--name", " ", *WHO[2:]], "name = ' ' must be a line"),
    ],
)
def test_what_cannot_be_submitted_is_refused_before_anything_runs(small, capsys, arguments, message):
    assert main(["leaderboard", "submit", *arguments]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert message in line
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
    (line,) = capsys.readouterr().err.splitlines()
    assert message in line


def test_a_verdict_that_cannot_be_written_is_told_in_one_line(small, capsys):
    assert main(["leaderboard", "verify", "mine.py", "--json", "x" * 300 + ".json"]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "cannot be written" in line


def test_the_oracle_has_no_track_for_submissions(small):
    with pytest.raises(SystemExit):
        main(["leaderboard", "submit", "mine.py", "--name", "a", "--author", "b", "--track", "oracle"])
