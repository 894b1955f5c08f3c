"""The pages of the effect library: complete, and their examples run."""

import re
from pathlib import Path

import pytest

from ffgym.effects import EFFECTS
from ffgym.simulation.protocols import PROTOCOLS

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "docs" / "effects"


def blocks(document, language):
    return re.findall(rf"```{language}\n(.*?)```", document.read_text(encoding="utf-8"), flags=re.S)


def test_there_is_one_page_for_each_effect():
    assert {path.stem for path in FOLDER.glob("*.md")} == set(EFFECTS) | {"README"}


def test_what_looks_alike_does_so_both_ways_and_some_protocol_separates_it():
    alike = {effect.code: set(effect.confusable_with) for effect in EFFECTS.values()}
    for code, others in alike.items():
        assert all(code in alike[other] for other in others), code
    for effect in EFFECTS.values():
        assert set(effect.separating_motions) <= set(PROTOCOLS)
        assert effect.separating_motions


@pytest.mark.parametrize("document", ["effects/README.md", "machine_files.md"])
def test_the_python_blocks_run(document, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for text in blocks(ROOT / "docs" / document, "toml"):
        (tmp_path / "machine.toml").write_text(text, encoding="utf-8")
    names = {}
    for block in blocks(ROOT / "docs" / document, "python"):
        exec(compile(block, document, "exec"), names)
