"""What is kept of numbers that were made again, and the table that tells of it."""

import json

import pytest

from ffgym.core.errors import FFGymError
from scripts.claims.history import keep_made
from scripts.claims.steps import Made, Step, choose_steps, every_step
from scripts.claims.trace import Fault
from scripts.tables.claims import made_again

STEPS = [Step(name, "", list) for name in ("page a.md", "page agents/b.md", "tests/test_c.py", "record d")]
NUMBERS = {"pages": 3, "numbers": 1234, "traced": 1233, "faults": 0}


def made(name, seconds, faults=(), skipped=""):
    return Made(name, seconds, faults, skipped, date="2026-11-01", commit=f"of {name}")


def test_steps_are_chosen_by_their_names_and_stay_in_order():
    assert choose_steps(STEPS, ()) == STEPS
    assert choose_steps(STEPS, ["record d", "page a*"]) == [STEPS[0], STEPS[1], STEPS[3]]
    with pytest.raises(FFGymError, match=r"No step is named 'page c\.md'; there are 'page PLACE' in docs/"):
        choose_steps(STEPS, ["record d", "page c.md"])


def test_what_was_made_stays_until_it_is_made_again_or_is_no_step_any_more(tmp_path):
    file = tmp_path / "claims.json"
    keep_made([made("page a.md", 3.0), made("record d", 7.0), made("page gone.md", 1.0)], STEPS, NUMBERS, file)
    keep_made([made("record d", 9.0), made("tests/test_c.py", 0.0, skipped="no data")], STEPS, NUMBERS, file)
    kept = {row.pop("name"): row for row in json.loads(file.read_text())["steps"]}
    assert list(kept) == [step.name for step in STEPS]
    assert kept["page a.md"] == {"seconds": 3.0, "date": "2026-11-01", "commit": "of page a.md", "faults": 0}
    assert kept["record d"]["seconds"] == 9.0
    assert kept["tests/test_c.py"] == kept["page agents/b.md"] == {}


def test_the_page_tells_of_each_long_step_and_of_quick_ones_together(tmp_path):
    file = tmp_path / "claims.json"
    long = made("record d", 3600.0, (Fault("a.md", 1, "wrong"), Fault("a.md", 2, "wrong")))
    quick = [made("page a.md", 3.0), made("page agents/b.md", 4.0)]
    keep_made([*quick, long], STEPS, NUMBERS | {"faults": 1}, file)
    text = made_again(file).parts["made again"]
    assert (
        "1,234 numbers on 3 pages, 1,233 of them traced; 3 do not hold. 3 of 4 steps were made again, in 1.0 h." in text
    )
    assert "| 2 of 10 s and less | 7 s | 2026-11-01 by of page a.md, 2026-11-01 by of page agents/b.md |" in text
    assert "| `record d` | 60 min | 2026-11-01 by of record d; 2 did not hold |" in text
    assert "| `tests/test_c.py` |  | not yet |" in text
    keep_made([made("tests/test_c.py", 60.0), made("record d", 3600.0)], STEPS, NUMBERS, file)
    assert "all hold. 4 of 4 steps" in made_again(file).parts["made again"]
    assert "| `tests/test_c.py` | 60 s |" in made_again(file).parts["made again"]


def test_a_record_whose_command_fails_does_not_hold(tmp_path, monkeypatch):
    def fail(name, folder):
        raise FFGymError("python -m scripts.thesis failed: ['no such robot']")

    monkeypatch.setattr("scripts.claims.steps.make_record", fail)
    (step,) = choose_steps(every_step(tmp_path), ["record thesis"])
    assert [str(fault) for fault in step.make()] == [
        "docs/records/thesis.json:0: python -m scripts.thesis failed: ['no such robot']"
    ]


def test_the_page_of_these_steps_is_none_of_them(tmp_path):
    names = {step.name for step in every_step(tmp_path)}
    assert "page narx.md" in names
    assert "page claims.md" not in names
