"""The study of settings: a short exam with one of them changed."""

import json

import pytest

from ffgym.diagnosis.settings import setting_values
from scripts.exam import settings_study
from scripts.exam.settings_study import main, read_variations, vary


@pytest.fixture(autouse=True)
def one_question(monkeypatch):
    """One question about a machine with one axis."""
    monkeypatch.setattr(settings_study, "QUESTIONS", (("single", 2, 1),))
    settings_study._usual.cache_clear()


def test_a_setting_that_forbids_all_causes_changes_the_answer_and_another_does_not():
    """Twice the whole residual must be removed: no cause does that. The spread of thinned stretches decides nothing."""
    one, other = vary("significance.explains", 10.0, 28), vary("blocks.spread_share", 2.0, 28)
    assert one.value == 10 * setting_values()["significance.explains"]
    assert one.changed
    assert one.right == 0
    assert not other.changed
    assert other.right == 1
    assert other.largest_change == 0.0


def test_the_command_goes_on_where_it_was_interrupted(tmp_path, capsys):
    """What is in the file is not asked again."""
    assert main(["--settings", "blocks.spread_share", "--out", str(tmp_path)]) == 0
    place = tmp_path / "seed_28.jsonl"
    before = place.read_text()
    assert [one.factor for one in read_variations(place)] == [0.5, 2.0]
    assert main(["--settings", "blocks.spread_share", "--out", str(tmp_path)]) == 0
    assert place.read_text() == before
    assert json.loads(before.splitlines()[0])["changed"] == []
    assert "| `blocks.spread_share` | 0.5 | the same | the same |" in capsys.readouterr().out


def test_an_unknown_setting_is_refused_in_one_line(tmp_path, capsys):
    """Nothing is written."""
    assert main(["--settings", "search.neer", "--out", str(tmp_path / "out")]) != 0
    assert "search.neer" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
