"""What each agent beyond the thesis needed: its trials are counted, and its errors compared circle by circle."""

from types import SimpleNamespace

import pytest

from ffgym.agents.catalogue import CATALOGUE
from ffgym.agents.declaration import AgentSetting
from ffgym.agents.trials import CountedTrial, thesis_motions
from ffgym.control import NoCompensation
from ffgym.simulation import Run
from scripts.thesis import ITEMS
from scripts.thesis.claims import judge
from scripts.thesis.studies import contender

CLAIMS = {claim.name: claim for item in ITEMS for claim in item.claims}
[AGENTS] = [item for item in ITEMS if item.name == "agents"]


def test_trials_are_counted_and_pass_through(one_axis):
    setting = AgentSetting.of(one_axis)
    [reference] = thesis_motions(setting.arm)
    counted = CountedTrial(lambda runs, number: [f"{number}: {run.law.name}" for run in runs])
    runs = [Run(reference=reference, law=NoCompensation())] * 2
    assert counted(runs, 7) == ["7: none", "7: none"]
    assert counted.trials == 1
    assert counted.robot_seconds == pytest.approx(2 * reference.duration)


def test_a_law_that_learns_counts_its_trials_and_one_that_does_not_has_none(one_axis):
    network = contender("bsn_static", AgentSetting.of(one_axis))
    assert network.entry is CATALOGUE["bsn_static"]
    assert network.law.name == "bsn_static"
    assert 1 < network.trials <= 16  # 15 iterations and the trial before them, unless locked earlier
    assert network.robot_seconds == pytest.approx(10.0 * network.trials)
    assert contender("lugre_static", AgentSetting.of(one_axis)).trials == 0


def test_members_whose_packages_are_missing_are_left_out_and_named(compared, monkeypatch):
    assert all(entry.is_available for entry in CATALOGUE.values())
    monkeypatch.setattr("ffgym.agents.declaration.is_installed", lambda package: package != "torch")
    assert [name for name, entry in CATALOGUE.items() if not entry.is_available] == ["mlp_fel"]
    [table] = AGENTS.numbers(compared({"none": 1.0, "lugre_dynamic": 0.5}))
    assert "circles at p1, which they learned on, are among those that are scored" in table.note
    assert table.note.endswith("a package is not installed: perceptron, feedback-error learning (torch).")


@pytest.fixture
def compared(studies, made_up_circles):
    """Function that puts path errors by law into the studies."""

    def put(errors):
        studies.all_circles = made_up_circles(errors, lambda law, *where: errors[law])
        studies.contenders = [
            SimpleNamespace(entry=CATALOGUE[name], law=SimpleNamespace(name=name), trials=3, robot_seconds=42.0)
            for name in errors
        ]
        return studies

    return put


def test_the_table_compares_with_no_compensation(compared):
    studies = compared({"none": 1.0, "lugre_dynamic": 0.5, "elastic": 0.05})
    [table] = AGENTS.numbers(studies)
    assert [row[0] for row in table.rows] == ["no compensation", "dynamic LuGre", "elastic feed-forward"]
    assert table.rows[0][2:] == ("3", "42", *["1000"] * 3)
    assert table.rows[1][4:] == ("500 (50% less)",) * 3
    assert table.rows[2][4:] == ("50 (95% less)",) * 3


def test_the_figure_has_a_line_per_law(compared):
    [figure] = AGENTS.figures(compared({"none": 1.0, "lugre_dynamic": 0.5, "elastic": 0.05}))
    [axes] = figure.figure.axes
    assert [label.get_text() for label in axes.get_yticklabels()] == [
        "no compensation",
        "dynamic LuGre",
        "elastic feed-forward",
    ]
    assert [list(line.get_xdata()) for line in axes.get_lines()] == [pytest.approx([1.0, 0.5, 0.05])] * 3


@pytest.mark.parametrize(("left", "verdict"), [(0.29, "holds"), (0.31, "does not hold")])
def test_the_limit_is_broken_where_70_percent_of_it_is_gone(compared, left, verdict):
    studies = compared({"lugre_dynamic": 1.0, "elastic": left})
    assert judge(CLAIMS["agents-elastic"], studies).verdict == verdict
