"""Mutation testing: what is changed, which tests are asked, and what is kept."""

import json
from dataclasses import replace

import pytest

from ffgym.core.errors import FFGymError
from scripts import mutation
from scripts.mutation import Config, main, mutants
from scripts.mutation.mutants import Mutant, draw_mutants, list_mutants
from scripts.mutation.rooms import REPOSITORY, ROOMS, Room
from scripts.mutation.score import Score, keep_outcome, read_outcomes
from scripts.mutation.testing import Outcome, Workplace

SOURCE = '''"""Doc with 1 + 2."""
from functools import lru_cache

@lru_cache(4)
def area(width: float | None, *, height: float) -> float:
    if width is None or height < 0:
        return 0
    return width * height
'''


@pytest.fixture
def room(tmp_path, monkeypatch):
    """A room of one module, in a repository of its own."""
    (tmp_path / "code").mkdir()
    (tmp_path / "code" / "area.py").write_text(SOURCE)
    monkeypatch.setattr(mutants, "REPOSITORY", tmp_path)
    monkeypatch.setattr("scripts.mutation.rooms.REPOSITORY", tmp_path)
    monkeypatch.setattr("scripts.mutation.testing.REPOSITORY", tmp_path)
    return Room(code=("code",), tests=("tests",))


def test_mutants_change_one_place_of_the_code_and_no_words_or_types(room):
    found = {(mutant.operator, mutant.line): mutant.code() for mutant in list_mutants(room)}
    changed = {
        place: [new for new, old in zip(code.splitlines(), SOURCE.splitlines(), strict=True) if new != old]
        for place, code in found.items()
    }
    assert changed.pop(("NumberReplacer", 6)) == ["    if width is None or height < -1:"]
    assert changed["ReplaceBinaryOperator_Mul_Div", 8] == ["    return width / height"]
    assert changed["ReplaceOrWithAnd", 6] == ["    if width is None and height < 0:"]
    assert changed["ReplaceComparisonOperator_Lt_GtE", 6] == ["    if width is None or height >= 0:"]
    assert all(len(lines) == 1 for lines in changed.values())
    assert {line for _, line in found} == {6, 7, 8}


def test_a_larger_sample_holds_the_smaller_one_and_lines_before_change_nothing(room, tmp_path):
    before = list_mutants(room)
    few, more = (draw_mutants(before, count, seed=3) for count in (4, 8))
    assert more[:4] == few
    assert draw_mutants(before, 4, seed=4) != few
    (tmp_path / "code" / "area.py").write_text("LIMIT = 7\n" + SOURCE)
    again = {mutant.key: mutant for mutant in list_mutants(room)}
    assert all(again[mutant.key].line == mutant.line + 1 for mutant in before)


def test_files_that_run_the_line_are_asked_fastest_first_and_new_ones_before(room, tmp_path):
    (tmp_path / "tests").mkdir()
    for name in ("slow", "fast", "other", "new"):
        (tmp_path / "tests" / f"test_{name}.py").write_text("")
    files = {name: f"tests/test_{name}.py" for name in ("slow", "fast", "other", "new")}
    lines = {"code/area.py": {"4": [files["slow"], files["fast"]], "3": ["", files["other"]]}}
    workplace = Workplace(
        copy=tmp_path,
        room=room,
        lines=lines,
        times={files["slow"]: 9.0, files["fast"]: 1.0, files["other"]: 2.0},
        digests=dict.fromkeys((files["slow"], files["fast"], files["other"]), "e3b0c44298fc1c14"),
    )
    mutant = list_mutants(room)[0]
    at = {line: replace(mutant, line=line) for line in (4, 9)}
    assert workplace.files_for(at[4], 60.0) == [files["new"], files["fast"], files["slow"]]
    assert workplace.files_for(at[4], 5.0) == [files["new"], files["fast"]]
    assert workplace.files_for(at[9], 60.0)[1:] == [files["fast"], files["other"], files["slow"]]  # runs when imported


@pytest.mark.slow  # starts pytest five times
def test_tests_kill_what_they_notice_and_the_module_is_put_back(room, tmp_path):
    (tmp_path / "tests").mkdir()
    (tmp_path / "tests" / "test_area.py").write_text(
        "from code_of.area import area\ndef test_it():\n    assert area(2, 3) == 6\n"
    )
    copy = tmp_path / "copy"
    for folder in ("code_of", "code", "tests"):
        (copy / folder).mkdir(parents=True)
    (copy / "code_of").rmdir()
    (copy / "code_of").symlink_to("code")
    (copy / "tests" / "test_area.py").write_bytes((tmp_path / "tests" / "test_area.py").read_bytes())
    workplace = Workplace(copy=copy, room=room, lines={}, times={}, digests={})
    results = {mutant.operator: workplace.test(mutant, 5.0).result for mutant in list_mutants(room)}
    assert results["ReplaceBinaryOperator_Mul_Div"] == "failed"
    assert results["ReplaceOrWithAnd"] == "survived"
    assert (copy / "code" / "area.py").read_text() == SOURCE


def outcome(number, result="failed"):
    return Outcome(Mutant("a.py", "AddNot", number, 1, "if x:", number), result, "tests/test_a.py::test_a", 1.0)


def test_a_score_says_how_sure_it_is_and_what_survived(tmp_path):
    outcomes = [
        outcome(number, "survived" if number < 2 else "hung" if number < 4 else "failed") for number in range(20)
    ]
    score = Score(room="plant", seed=3, n_mutants=400, outcomes=tuple(outcomes))
    assert score.share == 0.9
    assert score.interval() == pytest.approx((0.699, 0.972), abs=0.001)  # of Wilson's formula
    first, *rest = str(score).splitlines()
    assert first == "plant: 18 of 20 killed, 90% (70% to 97%) of 400 mutants"
    assert [line.split()[0] for line in rest] == ["survived", "survived"]
    for each in outcomes:
        keep_outcome(tmp_path / "kept.jsonl", each)
    assert read_outcomes(tmp_path / "kept.jsonl") == outcomes
    (tmp_path / "kept.jsonl").write_text('{"mutant": 1}\n')
    with pytest.raises(FFGymError, match="holds no outcomes of mutants"):
        read_outcomes(tmp_path / "kept.jsonl")


def test_what_was_tested_is_not_tested_again_unless_it_survived_and_that_is_asked_for(room, tmp_path, monkeypatch):
    asked = []

    class Stub:
        @classmethod
        def prepare(cls, *arguments):
            return cls()

        def test(self, mutant, limit):
            asked.append(mutant.key)
            return Outcome(mutant, "survived" if mutant.operator == "NumberReplacer" else "failed", "", 0.0)

    monkeypatch.setattr(mutation, "ROOMS", {"area": room})
    monkeypatch.setattr(mutation, "Workplace", Stub)
    config = Config(rooms=("area",), sample=50, out=tmp_path / "out", json=tmp_path / "score.json")
    (score,) = main(config)
    survived = [each.mutant.key for each in score.outcomes if not each.is_killed]
    assert len(asked) == len(score.outcomes) == score.n_mutants
    asked.clear()
    assert main(config)[0].share == score.share
    assert asked == []
    main(replace(config, again=True))
    assert sorted(asked) == sorted(survived)
    assert json.loads((tmp_path / "score.json").read_text())["rooms"][0]["n_killed"] == score.n_killed
    with pytest.raises(FFGymError, match="room"):
        main(replace(config, rooms=("kitchen",)))


def test_every_room_has_code_and_tests():
    for room in ROOMS.values():
        assert room.modules()
        assert room.test_files()
        assert all((REPOSITORY / module).is_file() for module in room.modules())
