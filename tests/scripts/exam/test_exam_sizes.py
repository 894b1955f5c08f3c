"""The exam on a robot of the user: from what size on each effect is found, and what cannot be asked."""

import json
import re
import shlex
from dataclasses import replace
from importlib import resources
from pathlib import Path

import pytest

from ffgym.core.errors import FFGymError
from ffgym.effects import EFFECTS
from scripts.exam.__main__ import main
from scripts.exam.marks import Mark
from scripts.exam.sizes import SizesExam, detectable_sizes, places_of, share_of, size_of, sizes_figure, sizes_text
from scripts.exam.tasks import Truth

PAGE = (Path(__file__).parents[3] / "docs" / "bench_diagnosis.md").read_text(encoding="utf-8")
SECTION = PAGE.split("## A machine of your own")[1].split("\n## ")[0]
SESSION = '[[step]]\nprotocol = "excitation"\ncount = 2\nbase = 0.2\nperiods = 1\n'
STEPS = 4


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder with a robot and its motions."""
    monkeypatch.chdir(tmp_path)
    text = (resources.files("ffgym.robot") / "data" / "one_axis.toml").read_text(encoding="utf-8")
    Path("my_robot.toml").write_text(text.replace('"one_axis"', '"mine"', 1), encoding="utf-8")
    Path("session.toml").write_text(SESSION, encoding="utf-8")
    return tmp_path


def command():
    (line,) = re.findall(r"```bash\n(.*?)```", SECTION, flags=re.S)
    python, flag, module, *arguments = shlex.split(line)
    assert (python, flag, module) == ("python", "-m", "scripts.exam")
    return arguments


@pytest.mark.slow
def test_the_command_of_the_page_says_from_what_size_on_an_effect_is_found(place, capsys):
    arguments = [one for one in command() if one != "load_friction"]
    assert main(arguments) == 0
    said, found = capsys.readouterr().out, json.loads(Path("sizes.json").read_text())
    (line,) = found["sizes"]
    assert (line["effect"], line["joint"], line["asked"]) == ("asymmetry", "j1", 4)
    assert 0 < line["not_found_at"] < line["found_from"] < line["largest"]
    assert f"| {line['found_from']:.3g} " in said
    assert "not judgeable: payload: the robot has no tool" in said
    assert {"payload", "backlash"} <= {one["effect"] for one in found["not_judgeable"]}
    assert b"<svg" in Path("sizes.svg").read_bytes()
    marks = Path("sizes/sizes_my_robot_seed_7.jsonl")
    kept = marks.read_bytes()
    assert main(arguments) == 0  # nothing is asked again
    assert marks.read_bytes() == kept
    assert main([*arguments, "--tracker-noise", "1e-5"]) == 1
    assert "has no tracker" in capsys.readouterr().err
    assert main([one if one != "0.02" else "0.03" for one in arguments]) == 1
    assert "another seed or exam" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--protocol", "diagnosis"], "--protocol has no effect without --robot"),
        (["--robot", "one_axis", "--rows", "clean"], "--rows has no effect with --robot"),
        (["--robot", "one_axis", "--exam", "independent"], "--exam has no effect with --robot"),
        (["--robot", "nobody"], "nobody"),
        (["--robot", "one_axis", "--protocol", "dances"], "Unknown protocol"),
        (["--robot", "one_axis", "--torque-noise", "0.1", "0.1"], "must have one, or 1"),
        (["--robot", "one_axis", "--torque-noise", "-0.1"], "--torque-noise"),
        (["--robot", "one_axis", "--resolver-noise", "-1"], "--resolver-noise"),
        (["--robot", "one_axis", "--steps", "0"], "--steps"),
        (["--robot", "one_axis", "--record-dt-ms", "0"], "--record-dt-ms"),
        (["--robot", "one_axis", "--protocol", "session.toml", "--effects", "rust"], "Unknown effect 'rust'"),
        (["--robot", "one_axis", "--protocol", "session.toml", "--effects", "backlash"], "described as rigid"),
    ],
    ids=lambda x: x[-1] if isinstance(x, list) else "",
)
def test_what_cannot_be_asked_of_a_robot_is_refused_in_one_line(place, arguments, words, capsys):
    assert main(arguments) == 1
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1


def mark(step, outcome, size, effect="load_friction", ladder=0):
    place = list(EFFECTS).index(effect)
    name = next(iter(EFFECTS[effect].parameters()))
    return Mark(
        row="size",
        number=(ladder * len(EFFECTS) + place) * STEPS + step,
        truth=(
            Truth(
                effect=effect,
                answer=effect,
                joint="j1",
                is_foreign=False,
                loudness=1 + 10.0**step,
                numbers={name: size},
            ),
        ),
        outcome=outcome,
        verdict="named",
        sentence="",
        causes=(),
        tied=(),
        first_is_right=outcome == "right",
    )


@pytest.mark.parametrize(
    ("outcomes", "found_from", "not_at"),
    [
        (("none", "none", "tie", "right"), 0.03, 0.02),
        (("right", "none", "right", "surplus"), 0.03, 0.02),  # one that is found by chance does not count
        (("right", "tie", "right", "right"), 0.01, None),
        (("none", "right", "right", "wrong"), None, 0.04),
        (("none", "none", "none", "none"), None, 0.04),
    ],
)
def test_an_effect_is_found_from_the_size_on_from_which_all_larger_ones_are(outcomes, found_from, not_at):
    marks = [mark(step, outcome, 0.01 * (step + 1)) for step, outcome in enumerate(outcomes)]
    (one,) = detectable_sizes(marks[::-1], STEPS)
    assert (one.found_from, one.not_found_at) == (found_from, not_at)
    assert one.found == sum(outcome in ("right", "tie", "surplus") for outcome in outcomes)
    assert (f"beyond {one.largest:.3g}" in sizes_text([one])) == (found_from is None)


def test_ladders_stand_in_the_order_of_the_library_and_have_a_picture_over_size():
    marks = [
        mark(k, "right", 0.02 * (k + 1), effect, ladder)
        for effect, ladder in (("cogging", 0), ("load_friction", 1), ("load_friction", 0))
        for k in range(STEPS)
    ]
    assert [one.effect for one in detectable_sizes(marks, STEPS)] == ["load_friction", "load_friction", "cogging"]
    (axes,) = sizes_figure(marks).axes
    assert [label.get_text() for label in axes.get_yticklabels()] == ["cogging", "load_friction"]
    assert len([line for line in axes.lines if line.get_label() == "right"]) == len(marks)
    with pytest.raises(FFGymError, match="no marks"):
        sizes_figure([])


def test_the_size_of_an_effect_is_the_number_that_was_drawn_and_of_a_vector_its_length():
    truth = mark(0, "right", 0.3, "presliding").truth[0]
    assert size_of(replace(truth, numbers={"stiffness": 0.001, "damping": 0.9})) == ("damping", "1", 0.9)
    vector = {"offset.x": 3e-4, "offset.y": -4e-4, "offset.z": 0.0}
    assert size_of(replace(truth, effect="tool_frame", numbers=vector)) == ("offset", "m", pytest.approx(5e-4))


@pytest.mark.parametrize("energy", [0.02, 5.0, 4e4])
def test_a_ladder_goes_from_hardly_any_loudness_to_the_largest_size_or_a_hundred(energy):
    shares = [share_of(step, STEPS, energy) for step in range(STEPS)]
    assert shares == sorted(shares)
    assert shares[-1] ** 2 * energy == pytest.approx(min(energy, 100.0))
    assert shares[0] ** 2 * energy == pytest.approx(min(0.3, 0.1 * energy))
    assert share_of(0, 1, energy) == shares[-1]


def test_an_effect_that_motions_do_not_show_is_asked_for_at_even_sizes():
    assert [share_of(step, STEPS, 0.0) for step in range(STEPS)] == [0.25, 0.5, 0.75, 1.0]


def test_effects_are_hidden_on_joints_that_can_have_them(irb4600, one_axis):
    assert places_of(EFFECTS["backlash"], one_axis) == []
    assert places_of(EFFECTS["wrist_coupling"], one_axis) == []
    assert places_of(EFFECTS["wrist_coupling"], irb4600) == list(irb4600.joints)


def test_a_question_is_the_same_however_many_are_asked(place):
    few, many = (
        SizesExam(robot="my_robot.toml", protocol="session.toml", effects=effects, cases=cases, steps=2)
        for effects, cases in ((("cogging",), 1), ((), 2))
    )
    assert set(few.questions((), None)) < set(many.questions((), None))
    assert few.head(7) == many.head(7)
