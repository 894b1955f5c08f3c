"""A package outside ffgym adds a family of agents with one file: the one of docs/extending.md."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SECTION = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8").split("## An agent")[1].split("\n## ")[0]
MODULE, ENTRY = (re.findall(rf"^```{kind}\n(.*?)^```", SECTION, flags=re.M | re.S)[0] for kind in ("python", "toml"))

PREDICT = """
import gymnasium as gym
import ffgym
from ffgym.agents import CATALOGUE, LawAgent, AgentSetting, make_law, save_law
from ffgym.report import law_styles
from ffgym.robot import load_robot

assert list(CATALOGUE)[-2:] == ["coulomb_only", "oracle"], list(CATALOGUE)
assert law_styles(["coulomb_only"])["coulomb_only"].label == "Coulomb friction"
law = make_law("coulomb_only", AgentSetting.of(load_robot("one_axis")))
env = gym.make("ffgym/OneAxis-v0", frequencies=[1.0])
observation, _ = env.reset(seed=0)
action, state = LawAgent.for_env(law, env).predict(observation)
assert action.shape == (1,)
assert law.level[0] > 0
save_law("mine.npz", law)
"""
BOARD = """
from ffgym.agents.entrants import ENTRANTS
assert list(ENTRANTS)[-2:] == ["coulomb_only", "oracle"]
from ffgym.agents import load_law
print(type(load_law("mine.npz")).__name__)
"""


@pytest.fixture
def run(tmp_path):
    """Run Python where the package is installed, after a change of its module."""
    site, work = tmp_path / "site", tmp_path / "work"
    installed = site / "coulomb_only-1.0.dist-info"
    installed.mkdir(parents=True)
    work.mkdir()
    (installed / "METADATA").write_text("Metadata-Version: 2.1\nName: coulomb-only\nVersion: 1.0\n", encoding="utf-8")
    group, point = ENTRY.replace('"', "").replace("project.entry-points.", "").strip().splitlines()
    (installed / "entry_points.txt").write_text(f"{group}\n{point}\n", encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(site), str(ROOT)])}

    def python(*arguments, module=MODULE):
        (site / "coulomb_only.py").write_text(module, encoding="utf-8")
        return subprocess.run(
            [sys.executable, *arguments], cwd=work, env=environment, capture_output=True, text=True, check=False
        )

    return python


def test_a_family_of_one_file_elsewhere_is_listed_predicts_and_is_read_from_its_file(run):
    done = run("-c", PREDICT)
    assert done.returncode == 0, done.stderr
    done = run("-c", BOARD)
    assert done.stdout.strip() == "CoulombOnly", done.stderr


def test_commands_know_its_name(run):
    done = run("-m", "ffgym", "export", "one_axis", "sine", "--feedforward", "coulomb_only", "--out", "arm")
    assert done.returncode == 0, done.stderr
    done = run("-m", "ffgym", "demo", "--agents", "nobody")
    assert "coulomb_only, elastic" in done.stderr


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (('name="coulomb_only"', 'name="narx"'), "There is an agent 'narx' already"),
        (
            ('kind: ClassVar[str] = "coulomb_only"', 'kind: ClassVar[str] = "narx"'),
            "has files of kind 'narx' already",
        ),
        (("import numpy as np", "import numpie as np"), "'coulomb-only' in group 'ffgym.agents' cannot be loaded"),
    ],
)
def test_a_family_that_cannot_be_told_from_others_or_loaded_is_one_line(run, change, words):
    done = run("-m", "ffgym", "demo", "--agents", "none", "elastic", module=MODULE.replace(*change))
    assert done.returncode == 1
    (line,) = done.stderr.splitlines()
    assert words in line
