"""What the documentation says runs, and its parts fit together."""

import re
from pathlib import Path

import numpy as np
import pytest

from ffgym.cli.main import main
from ffgym.robot.reading.rules import RULES

ROOT = Path(__file__).parent.parent
WITH_COMMANDS = ("your_robot.md", "identify.md", "diagnose.md", "real_machine.md", "onto_the_machine.md")
"""Tutorials whose blocks need their commands: test_tutorial_with_commands."""

EXECUTED = [
    "README.md",
    "docs/claims.md",
    "docs/getting_started.md",
    "docs/identification.md",
    "docs/kinematics.md",
    "docs/narx.md",
    "docs/recorder.md",
    "docs/robot_check.md",
    "docs/reproduction.md",
    "docs/simulate.md",
    "docs/torque_prediction.md",
    "docs/deployment/programs.md",
    "docs/deployment/setpoints.md",
    "docs/deployment/streams.md",
    "docs/leaderboard/README.md",
    "docs/agents/README.md",
    "docs/agents/bspline.md",
    "docs/agents/learning_stability.md",
    "docs/agents/lugre.md",
    "docs/agents/online_lffc.md",
    "docs/agents/feedback_error.md",
    "docs/agents/residual.md",
    "docs/agents/residual_torque.md",
    "docs/agents/narx.md",
    *sorted(
        str(p.relative_to(ROOT)) for p in (ROOT / "docs" / "tutorials").glob("*.md") if p.name not in WITH_COMMANDS
    ),
]


@pytest.mark.parametrize("document", EXECUTED)
def test_every_python_block_of_a_document_runs(document, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / document).read_text(encoding="utf-8"), flags=re.S)
    assert blocks
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, document, "exec"), names)  # the blocks of one document build on each other


@pytest.mark.parametrize(
    ("document", "name", "source"),
    [
        ("docs/arm_files.md", "arm.urdf", "tests/robot/arm_file/files/ur_like.urdf"),
        ("docs/robot_description.md", "friction_of_cell_3.toml", "ffgym/robot/data/one_axis.toml"),
    ],
)
def test_the_python_block_of_a_page_runs_on_a_file_of_its_kind(document, name, source, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = (ROOT / source).read_text(encoding="utf-8")
    if name.endswith(".toml"):
        text = text[text.index("[friction.") : text.index("[servo.")]
    (tmp_path / name).write_text(text, encoding="utf-8")
    (block,) = re.findall(r"```python\n(.*?)```", (ROOT / document).read_text(encoding="utf-8"), flags=re.S)
    exec(compile(block, document, "exec"), {})


def test_the_exported_motion_runs_in_plain_mujoco_as_its_page_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "export.md").read_text(encoding="utf-8")
    (commands,), (block,) = (re.findall(rf"```{kind}\n(.*?)```", page, flags=re.S) for kind in ("sh", "python"))
    for command in commands.splitlines():
        assert main(command.split()[1:]) == 0
    names: dict[str, object] = {}
    exec(compile(block, "export.md", "exec"), names)
    assert np.abs(names["data"].qvel).max() < 1e-3  # it rests again, at the end of the circles
    files = {path.name for path in (tmp_path / "circles").iterdir()} | {"model.mjb"}
    assert files == set(re.findall(r"^\| `(\w+\.\w+)` \|", page, flags=re.M))


def test_links_between_documents_lead_somewhere():
    for document in [ROOT / "README.md", *ROOT.glob("docs/**/*.md")]:
        for target in re.findall(r"\]\((?!https?:)([^)#]+)", document.read_text(encoding="utf-8")):
            assert (document.parent / target).exists(), f"{document.name} links to {target}"


def test_every_room_of_the_package_is_in_the_architecture_page():
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    packages = {p.stem for p in (ROOT / "ffgym").iterdir() if p.suffix == ".py" or (p / "__init__.py").exists()}
    missing = {package for package in packages - {"__init__", "__main__"} if f"`ffgym.{package}`" not in text}
    assert not missing


def test_every_entry_of_a_description_is_on_its_page():
    text = (ROOT / "docs" / "robot_description.md").read_text(encoding="utf-8")
    rows = {line.split("`")[1]: line.split(" | ") for line in text.splitlines() if re.match(r"\| `[a-z_.]+` \| ", line)}
    assert set(rows) == set(RULES)
    for path, rule in RULES.items():
        assert rows[path][-1].rstrip(" |") == rule.meaning
