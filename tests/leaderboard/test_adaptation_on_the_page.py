"""The curve of adaptation on the page of the leaderboard."""

from dataclasses import replace
from pathlib import Path

import pytest

from ffgym.agents.adapters import ADAPTERS
from ffgym.cli.main import main
from ffgym.leaderboard.adaptation.results import AdaptationResults, AdaptationRun, read_results
from ffgym.leaderboard.presentation.adaptation import draw_adaptation

ROOT = Path(__file__).parents[2]
TITLES = {"none": "nothing", "law": "the law", "learner": "the learner"}
MACHINES = ("workcell:1", "workcell:2")


def run(adapter, machine, laps, error):
    return AdaptationRun(
        adapter=adapter,
        machine=machine,
        laps=laps,
        budget_s=2.0 * laps,
        robot_seconds=2.0 * laps,
        seed=0,
        fingerprint="",
        versions="",
        artefact=None,
        rms_um=(error, error),
    )


@pytest.fixture
def results():
    """The law leaves 0.4, the learner 0.5 of one lap and 0.1 of ten; on the second machine a fifth more."""
    errors = {("none", 0): 100.0, ("law", 0): 40.0, ("learner", 1): 50.0, ("learner", 10): 10.0}
    runs = [
        run(adapter, machine, laps, error if adapter == "none" else error * factor)
        for (adapter, laps), error in errors.items()
        for machine, factor in zip(MACHINES, (1.0, 1.2), strict=True)
    ]
    return AdaptationResults(motions=("a", "b"), lap="a lap", runs=tuple(runs))


def test_laws_are_level_and_learners_fall_with_a_line_for_each_machine(results):
    picture = draw_adaptation(results, TITLES)
    law, learner = picture.families
    (_, y), (_, same) = (point.split(",") for point in law.line.split())
    assert (law.title, y, law.machines) == ("the law", same, ())
    places = [tuple(map(float, point.split(","))) for point in learner.line.split()]
    assert places[0][0] < places[1][0]
    assert places[0][1] < places[1][1]  # lower on the picture
    assert len(learner.machines) == picture.machines == 2
    assert [point.budget_s for point in learner.points] == [2.0, 20.0]


def test_families_of_the_committed_curve_can_be_told_apart():
    titles = {adapter.name: adapter.title for adapter in ADAPTERS}
    families = draw_adaptation(read_results(ROOT / "docs/leaderboard/adaptation.json"), titles).families
    assert len({family.colour for family in families}) == len(families) == len(ADAPTERS) - 1


def test_sentences_say_who_leaves_least_from_which_budget_on(results):
    first, second, last = draw_adaptation(results, TITLES).sentences
    assert first.startswith("Without any motion the law leaves least: 43.8%")
    assert second.startswith("After 20 s of motion the learner leaves least: 11.0%")
    assert last == "No larger budget of any family left less."


def test_machines_that_are_no_workcells_are_not_in_it(results):
    nominal = replace(results, runs=tuple(replace(each, machine="irb4600_60_205") for each in results.runs))
    assert draw_adaptation(nominal, TITLES) is None


def test_the_curve_needs_a_page(tmp_path, capsys):
    file = tmp_path / "curve.json"
    assert main(["leaderboard", "--adaptation", str(file), "--page", str(tmp_path / "page.html")]) == 1
    assert "curve.json: cannot be read" in capsys.readouterr().err
    assert main(["leaderboard", "--adaptation", "docs/leaderboard/adaptation.json"]) == 1
    assert "say where that goes: --page FILE" in capsys.readouterr().err
