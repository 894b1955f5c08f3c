import re
from dataclasses import fields
from pathlib import Path
from typing import get_args

import pytest

from ffgym.recordings import PHASE_KINDS, Header
from ffgym.recordings.header import Hold, TorqueSemantics

PAGE = (Path(__file__).parents[2] / "docs" / "recordings.md").read_text(encoding="utf-8")


def first_cells(heading: str) -> list[str]:
    """Names in the first column of the tables between `heading` and the next heading."""
    section = re.split(r"^#+ ", PAGE.split(f"{heading}\n", 1)[1], maxsplit=1, flags=re.MULTILINE)[0]
    return re.findall(r"^\| `([^`]+)` \|", section, flags=re.MULTILINE)


def test_table_of_header_fields_is_the_header() -> None:
    assert sorted(first_cells("## Header")) == sorted(field.name for field in fields(Header))
    required = re.findall(r"^\| `(\w+)` \| required \|", PAGE, flags=re.MULTILINE)
    assert tuple(required) == Header.required()


def test_choices_are_explained() -> None:
    assert sorted(first_cells("### Torque")) == sorted((*get_args(TorqueSemantics), *get_args(Hold)))
    assert all(f"`{kind}`" in PAGE for kind in PHASE_KINDS)


def test_examples_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    code = "\n".join(re.findall(r"^```python\n(.*?)^```", PAGE, flags=re.MULTILINE | re.DOTALL))
    exec(compile(code, "docs/recordings.md", "exec"), {})
    assert sorted(path.name for path in tmp_path.iterdir()) == ["lab.csv", "lab.npz", "motion.npz", "trace.csv"]


def test_example_file_is_what_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    code = re.findall(r"^```python\n(.*?)^```", PAGE, flags=re.MULTILINE | re.DOTALL)[0]
    exec(code.replace('"motion.npz"', '"motion.csv"'), {})
    shown = re.findall(r"^```text\n(.*?)^```", PAGE, flags=re.MULTILINE | re.DOTALL)[0]
    start, end = shown.split("...\n")
    written = Path("motion.csv").read_text(encoding="utf-8")
    assert written.startswith(start)
    assert end in written
