"""Results of an exam on a page: from kept marks, between its marks, with what was asked and what was not."""

import re
from dataclasses import replace

import pytest

from ffgym.core.errors import FFGymError
from scripts.exam.draw import COUNTS
from scripts.exam.exams import EXAMS
from scripts.exam.marks import write_marks
from scripts.exam.page import PAGE, Config, main
from tests.report.test_exam_plot import mark

HEAD = EXAMS["own"].head(12)
MARKS = [mark("clean", "none", "none"), mark("foreign", "wrong", "named", number=3)]


@pytest.fixture
def config(tmp_path):
    page = tmp_path / "docs" / "page.md"
    (page.parent / "pictures").mkdir(parents=True)
    page.write_text("a\n<!-- exam -->\nold\n<!-- end -->\nb\n", encoding="utf-8")
    return Config(seed=12, out=tmp_path, commit="abc123", page=page)


def test_tables_misses_and_the_picture_are_written(config):
    write_marks(config.out / "seed_12.jsonl", HEAD, MARKS)
    text = main(config)
    assert config.page.read_text(encoding="utf-8") == f"a\n<!-- exam -->\n{text}\n<!-- end -->\nb\n"
    assert "--seed 12" in text
    assert "abc123" in text
    assert f"2 of {sum(COUNTS.values())} questions (1 of 100 `clean`" in text
    assert "foreign-3: cogging on j1 (20); named" in text
    assert (config.page.parent / "pictures" / "exam.png").read_bytes().startswith(b"\x89PNG")


def test_a_whole_exam_says_so(config):
    whole = [
        replace(mark(row, "right", "named"), number=k, outcome="none", truth=())
        for row, n in COUNTS.items()
        for k in range(n)
    ]
    write_marks(config.out / "seed_12.jsonl", HEAD, whole)
    assert f"all {sum(COUNTS.values())} questions." in main(config)
    write_marks(config.out / "seed_12.jsonl", HEAD, [*whole, replace(whole[0], number=COUNTS["clean"])])
    assert f"all {sum(COUNTS.values())} questions, and 1 more of some rows." in main(config)


def test_without_marks_nothing_is_written(config):
    with pytest.raises(FFGymError, match=r"seed_12\.jsonl: holds no marks"):
        main(config)
    assert "old" in config.page.read_text(encoding="utf-8")


def test_the_second_exam_has_a_part_of_its_own(config):
    config = replace(config, exam="independent")
    config.page.write_text("<!-- exam -->\nold\n<!-- end -->\n<!-- independent -->\n<!-- end -->\n", encoding="utf-8")
    write_marks(config.out / "independent_seed_12.jsonl", EXAMS["independent"].head(12), MARKS[:1])
    text = main(config)
    assert "--exam independent --seed 12" in text
    assert "1 of 460 questions (1 of 200 `clean`" in text
    assert "clean logs: none" in text
    assert "old" in config.page.read_text(encoding="utf-8")
    assert (config.page.parent / "pictures" / "independent.png").exists()


@pytest.mark.parametrize("part", ["exam", "independent"])
def test_the_page_of_the_project_has_the_place(part):
    assert len(re.findall(rf"<!-- {part} -->\n.*?\n<!-- end -->", PAGE.read_text(encoding="utf-8"), flags=re.S)) == 1
