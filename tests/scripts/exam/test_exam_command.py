"""`python -m scripts.exam`: what it asks, what it keeps when it is interrupted, and what it refuses."""

import json

import pytest

from scripts.exam import exams
from scripts.exam.__main__ import main
from scripts.exam.marks import Mark


@pytest.fixture
def asked(monkeypatch):
    """Questions that were asked; answers come from no diagnosis."""
    questions = []

    def answer(question, *, exam, seed):
        if len(questions) == answer.most:
            raise KeyboardInterrupt
        questions.append(question)
        row, number = question
        return Mark(
            row=row,
            number=number,
            truth=(),
            outcome="none",
            verdict="none",
            sentence=f"seed {seed}",
            causes=(),
            tied=(),
            first_is_right=False,
            seconds=2.0,
        )

    answer.most = 10**6
    questions_of = type("Asked", (), {"questions": questions, "answer": answer})
    monkeypatch.setattr(exams, "examine", answer)
    return questions_of


def test_it_asks_some_questions_of_the_rows_that_are_named(asked, capsys):
    assert main(["--rows", "poor", "clean", "--cases", "2"]) == 0
    assert asked.questions == [("clean", 0), ("clean", 1), ("poor", 0), ("poor", 1)]
    text = capsys.readouterr().out
    assert "| clean logs named" in text
    assert "NO" not in text


def test_a_whole_exam_has_a_hundred_clean_logs_and_all_rows(asked, capsys):
    assert main([]) == 0
    rows = [row for row, _ in asked.questions]
    assert rows.count("clean") == 100
    assert set(rows) == {row for row, _ in asked.questions}
    assert len(rows) == len(set(asked.questions)) > 300


def test_an_interrupted_exam_goes_on_where_it_was(asked, tmp_path, capsys):
    arguments = ["--rows", "clean", "--cases", "4", "--out", str(tmp_path / "exam")]
    asked.answer.most = 2
    assert main(arguments) == 130
    asked.answer.most = 10**6
    assert main(arguments) == 0
    assert asked.questions == [("clean", k) for k in range(4)]
    lines = (tmp_path / "exam" / "seed_7.jsonl").read_text().splitlines()
    assert len(lines) == 5


def test_marks_of_questions_that_are_not_asked_are_kept_but_not_counted(asked, tmp_path, capsys):
    arguments = ["--out", str(tmp_path), "--cases", "1"]
    assert main([*arguments, "--rows", "clean", "single"]) == 0
    assert main([*arguments, "--rows", "poor_clean"]) == 0
    assert capsys.readouterr().out.count("| single ") == 1
    assert main([*arguments, "--rows", "clean", "single"]) == 0
    assert len(asked.questions) == 3


def test_numbers_go_into_a_file_with_their_origin(asked, tmp_path, capsys):
    place = tmp_path / "exam.json"
    assert main(["--seed", "12", "--rows", "clean", "--cases", "1", "--json", str(place)]) == 0
    found = json.loads(place.read_text())
    assert found["seed"] == 12
    assert found["physics_fingerprint"] == "cf38a0448a78c960"
    assert found["figures"][0]["figure"] == "clean logs named"
    assert [mark["sentence"] for mark in found["marks"]] == ["seed 12"]


def test_answers_are_drawn_if_asked_for(asked, tmp_path, capsys):
    place = tmp_path / "exam.svg"
    assert main(["--rows", "clean", "--cases", "3", "--figure", str(place)]) == 0
    assert b"<svg" in place.read_bytes()
    assert f"picture: {place}" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--rows", "easy"], "Unknown row of the exam"),
        (["--cases", "0"], "--cases"),
        (["--seed", "-1"], "--seed"),
        (["--jobs", "0"], "--jobs"),
        (["--json", "exam.txt"], ".json"),
        (["--figure", "exam.gif"], "figure format"),
    ],
    ids=lambda x: x[0] if isinstance(x, list) else "",
)
def test_what_cannot_be_asked_is_refused(asked, arguments, words, capsys):
    assert main([*arguments]) == 1
    assert words in capsys.readouterr().err
    assert asked.questions == []


def test_a_folder_of_another_kind_is_refused(asked, tmp_path, capsys):
    (tmp_path / "seed_7.jsonl").write_text('{"format": "other"}\n')
    assert main(["--cases", "1", "--out", str(tmp_path)]) == 1
    assert "another seed" in capsys.readouterr().err


def test_the_second_exam_has_rows_marks_and_demands_of_its_own(asked, tmp_path, capsys):
    place = tmp_path / "exam.json"
    arguments = ["--exam", "independent"]
    assert main([*arguments, "--json", str(place)]) == 0
    rows = [row for row, _ in asked.questions]
    counts = {"clean": 200, "single": 180, "outside": 30, "arm": 30, "arm_blind": 20}
    assert {row: rows.count(row) for row in rows} == counts
    assert "clean logs: none" in capsys.readouterr().out
    assert json.loads(place.read_text())["physics_fingerprint"] is None
    for _ in range(2):
        asked.questions.clear()
        assert main([*arguments, "--cases", "3", "--out", str(tmp_path)]) == 0
    assert asked.questions == []
    assert len((tmp_path / "independent_seed_7.jsonl").read_text().splitlines()) == 16
    assert main([*arguments, "--rows", "poor"]) == 1
    assert "Unknown row of the exam" in capsys.readouterr().err


def test_marks_of_one_exam_are_none_of_the_other(asked, tmp_path, capsys):
    assert main(["--rows", "clean", "--cases", "1", "--out", str(tmp_path)]) == 0
    (tmp_path / "seed_7.jsonl").rename(tmp_path / "independent_seed_7.jsonl")
    assert main(["--exam", "independent", "--cases", "1", "--out", str(tmp_path)]) == 1
    assert "another seed or exam" in capsys.readouterr().err
