"""The study of settings: a short exam with one of them changed."""

import json
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import pytest

from ffgym.diagnosis.settings import setting_values, settings
from scripts.exam import settings_study
from scripts.exam.settings_study import Varied, main, read_variations, vary
from scripts.exam.study_questions import Answer, DiagnosisQuestion, IdentificationQuestion, Statement

SLIDING = IdentificationQuestion(robot="one_axis", number=0, resamples=40, record_dt=1e-3)
"""Friction that is identified in a few seconds."""


@pytest.fixture(autouse=True)
def ask(monkeypatch):
    """Ask other questions than usual; one about a machine with one axis, unless a test chooses."""

    def choose(*questions):
        monkeypatch.setattr(settings_study, "QUESTIONS", questions)
        settings_study._usual.cache_clear()

    choose(DiagnosisQuestion(row="single", number=2, axes=1))
    return choose


@pytest.mark.slow
def test_a_setting_that_forbids_all_causes_changes_the_answer_and_another_does_not():
    """Twice the whole residual must be removed: no cause does that. The spread of thinned stretches decides nothing."""
    one, other = vary("significance.explains", 10.0, 28), vary("blocks.spread_share", 2.0, 28)
    assert one.value == 10 * setting_values()["significance.explains"]
    assert one.changed
    assert one.right == 0
    assert not other.changed
    assert other.right == 1
    assert other.largest_change == 0.0


@pytest.mark.slow
def test_identified_friction_is_a_question_too(ask):
    """With fewer starts the fit ends at the same place.

    No interval is as narrow as a millionth of its value, and none holds a velocity beyond those that are looked at.
    """
    ask(SLIDING)
    fewer, strict, beyond = (
        vary(f"friction.{name}", factor, 4)
        for name, factor in (("starts", 0.5), ("wide", 1e-6), ("largest_stribeck_velocity", 0.004))
    )
    assert not fewer.changed
    assert (fewer.right, fewer.wrong) == (1, 0)
    assert 0.0 < fewer.largest_change < 0.01
    letters = ("f_c", "f_s", "f_v", "v_s")
    assert strict.changed[:4] == tuple(f"identify one_axis {letter}: covered -> wide" for letter in letters)
    assert (strict.right, strict.wrong) == (0, 0)
    assert strict.largest_change == 0.0
    assert "identify one_axis v_s: covered -> missed" in beyond.changed
    assert (beyond.right, beyond.wrong) == (0, 1)


def test_an_identification_that_fails_has_no_answer():
    """Of one resample there are no intervals."""
    assert replace(SLIDING, resamples=1).ask(4).error.startswith("FFGymError: n_resamples")


@dataclass(frozen=True)
class Stub:
    """Question that reads one setting."""

    name: str
    asked: list[int] = field(default_factory=list, compare=False)

    def ask(self, seed):
        self.asked.append(seed)
        group, own = self.name.split(".")
        value = getattr(getattr(settings(), group), own)
        if value < 0.01:
            return Answer(error=f"{value} is too small")
        mark = "right" if value < 100 else "wrong"
        return Answer(
            statements={self.name: Statement(mark)},
            sizes={("x",): value},
            is_right=mark == "right",
            is_wrong=value > 99,
        )


def test_questions_of_any_kind_are_asked_again_where_they_read_the_setting(ask):
    """The other one keeps its answer, and is asked with the defaults alone."""
    other, own = Stub("search.slack"), Stub("friction.misfit")
    ask(other, own)
    one = vary("friction.misfit", 4.0, 28)
    assert one.changed == ()
    assert one.largest_change == pytest.approx(0.75)
    assert one.right == 2
    one = vary("friction.misfit", 1e4, 28)
    assert one.changed == ("friction.misfit: right -> wrong",)
    assert (one.right, one.wrong) == (1, 1)
    assert (other.asked, own.asked) == ([28], [28] * 3)


def test_a_question_without_an_answer_ends_the_exam_and_says_why(ask):
    """Questions after it are not asked."""
    ask(Stub("search.slack"), Stub("friction.misfit"))
    one = vary("search.slack", 0.1, 28)
    assert one.error == "0.002 is too small"
    assert one.right == 0


@pytest.mark.slow
def test_the_command_goes_on_where_it_was_interrupted(tmp_path, capsys):
    """What is in the file is not asked again."""
    assert main(["--settings", "blocks.spread_share", "--out", str(tmp_path)]) == 0
    place = tmp_path / "seed_28.jsonl"
    before = place.read_text()
    assert [one.factor for one in read_variations(place)] == [0.5, 2.0]
    assert main(["--settings", "blocks.spread_share", "--out", str(tmp_path)]) == 0
    assert place.read_text() == before
    assert json.loads(before.splitlines()[0])["changed"] == []
    printed = capsys.readouterr().out
    assert "### blocks\n\n" in printed
    assert "| `spread_share` | 0.5 | 0 |  |  |" in printed


def test_a_page_tells_what_each_setting_changes(tmp_path):
    """Those that no question reads have empty cells, and those that were not varied say so."""
    page = tmp_path / "page.md"
    page.write_text("before\n<!-- settings -->\n<!-- end -->\nafter\n")
    (tmp_path / "seed_28.jsonl").write_text(
        "".join(
            json.dumps(asdict(varied(setting, factor, **told))) + "\n"
            for factor in (0.5, 2.0)
            for setting, told in (
                (
                    "search.near_best",
                    {"changed": ("single-3: right -> none",)} if factor < 1 else {"largest_change": 0.1},
                ),
                ("search.slack", {"largest_change": 0.001}),
                ("rivals.near", {"n_read": 0}),
            )
        )
    )
    assert main(["--settings", "search.slack", "--out", str(tmp_path), "--page", str(page)]) == 0
    text = page.read_text()
    assert text.startswith("before\n")
    assert text.endswith("after\n")
    assert "3 were varied (seed 28); the 1 questions read 2 of them." in text
    assert "value 1 move a size by 1 % or change an answer; 1 change an answer." in text
    assert "| `near_best` | 0.5 | 1 | single-3: right -> none | the same, sizes up to 10% |" in text
    assert "| `slack` | 0.02 | 1 | the same | the same |" in text
    assert "| `near` | 0.9 | 0 |  |  |" in text
    assert "| `tried` | 3 | 0 | not asked | not asked |" in text


def varied(setting, factor, **told):
    usual = {"changed": (), "largest_change": 0.0, "right": 1, "wrong": 0, "seconds": 1.0, "n_read": 1}
    return Varied(setting=setting, factor=factor, value=setting_values()[setting] * factor, **usual | told)


def test_the_page_of_the_docs_has_every_setting_with_its_value():
    text = (Path(__file__).parents[3] / "docs" / "diagnosis_settings.md").read_text(encoding="utf-8")
    groups = {part.partition("\n")[0]: part for part in text.split("### ")[1:]}
    for name, value in setting_values().items():
        group, own = name.split(".")
        assert f"| `{own}` | {value:g} |" in groups[group], name
    assert "not asked" not in text


def test_an_unknown_setting_is_refused_in_one_line(tmp_path, capsys):
    """Nothing is written."""
    assert main(["--settings", "search.neer", "--out", str(tmp_path / "out")]) != 0
    assert "search.neer" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
