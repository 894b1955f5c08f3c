"""What the pages about motions say runs, and they leave nothing out."""

import re
from pathlib import Path

import numpy as np

from ffgym.paths.motions import list_motions
from ffgym.paths.motions.load import PARTS

DOCS = Path(__file__).parents[3] / "docs"


def blocks(page, kind):
    return re.findall(rf"```{kind}\n(.*?)```", (DOCS / page).read_text(encoding="utf-8"), flags=re.S)


def run(page):
    names: dict[str, object] = {}
    for block in blocks(page, "python"):
        exec(compile(block, page, "exec"), names)
    return names


def test_the_page_about_motion_files_has_every_part_and_motion():
    text = (DOCS / "motion_files.md").read_text(encoding="utf-8")
    assert set(re.findall(r"^### (\w+)", text, flags=re.M)) == set(PARTS)
    assert all(f"| `{name}` |" in text for name in list_motions())


def test_the_example_of_a_motion_file_is_a_motion(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (example,) = blocks("motion_files.md", "toml")
    (tmp_path / "cut.toml").write_text(example)
    motion = run("motion_files.md")["motion"]
    kinds = [phase.kind for phase in motion.reference.phases]
    assert kinds == ["standstill", "motion", "motion", "standstill", "motion", "circle", "standstill"]
    assert motion.notes == ()


def test_the_moves_of_the_page_about_paths_run():
    names = run("paths.md")
    motion, arm, p1 = (names[name] for name in ("motion", "arm", "p1"))
    end = arm.tcp_position(motion.reference.q[-1:])[0]
    np.testing.assert_allclose(end, p1 + np.array([0.1, 0.1, 0]), atol=1e-8)
