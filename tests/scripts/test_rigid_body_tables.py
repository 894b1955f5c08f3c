"""Tables of docs/rigid_body_identification.md; needs the published recordings, see FFGYM_DATA."""

import json
import os
from pathlib import Path

import pytest

from ffgym.core.errors import FFGymError
from scripts.rigid_body_tables import Config, main

PAGE = Path(__file__).parents[2] / "docs" / "rigid_body_identification.md"


@pytest.mark.slow
@pytest.mark.skipif(
    not os.environ.get("FFGYM_DATA"), reason="set FFGYM_DATA to the folder with the published recordings"
)
def test_the_tables_of_the_page_are_current(tmp_path):
    copy, numbers = tmp_path / "page.md", tmp_path / "tables.json"
    copy.write_text(PAGE.read_text(encoding="utf-8"), encoding="utf-8")
    tables = main(Config(write=copy, json=numbers))
    assert copy.read_text(encoding="utf-8") == PAGE.read_text(encoding="utf-8")
    assert json.loads(numbers.read_text(encoding="utf-8"))["tables"] == dict(tables)


def test_without_the_recordings_it_is_one_clear_error(monkeypatch):
    monkeypatch.delenv("FFGYM_DATA", raising=False)
    with pytest.raises(FFGymError, match="FFGYM_DATA"):
        main(Config())
