"""Results in docs/leaderboard are of the agents, plants and circles of this version, and the page shows them."""

import json
import math
import re
from pathlib import Path

import pytest

from ffgym.agents.entrants import ENTRANTS, REGISTRY
from ffgym.core.executors import Executor
from ffgym.leaderboard.board import Board
from ffgym.leaderboard.comparison.samples import DRAWS, GROUPS, WORKCELLS, group_of
from ffgym.leaderboard.comparison.standings import standings
from ffgym.leaderboard.plants import NOMINAL, THESIS_WORKCELL, draw_name, find_plant
from ffgym.leaderboard.presentation.figures import share
from ffgym.leaderboard.presentation.page import all_standings
from ffgym.leaderboard.presentation.table import table_of
from ffgym.leaderboard.presentation.words import group_title
from ffgym.leaderboard.submission.rounds import read_round

DOCS = Path(__file__).parents[2] / "docs" / "leaderboard"
N_DRAWS, N_WORKCELLS = 20, 10


@pytest.fixture(scope="module")
def rows():
    """Committed rows in the order of the entrants."""
    board = Board(registry=REGISTRY, folder=DOCS / "results")
    due = {name for name, entrant in ENTRANTS.items() if not entrant.slow}
    assert due <= set(board.rows) <= set(ENTRANTS)
    return {name: board.rows[name] for name in ENTRANTS if name in board.rows}


@pytest.mark.parametrize("plant", [NOMINAL, THESIS_WORKCELL, draw_name(0), draw_name(N_DRAWS - 1)])
def test_results_are_of_this_physics(plant, rows):
    fingerprint = find_plant(plant).fingerprint
    found = {name: {o.fingerprint for o in row.outcomes if o.plant == plant} for name, row in rows.items()}
    assert {name: prints for name, prints in found.items() if not prints <= {fingerprint}} == {}
    assert found["none"] == {fingerprint}


def test_laws_that_are_made_from_the_robot_still_give_these_results(rows):
    fitted = ("model_fitted", "fitted")  # to recordings of the machine
    made = [entrant for entrant in ENTRANTS.values() if entrant.seeds == (0,) and entrant.name not in fitted]
    board = Board(registry=REGISTRY)
    board.run(made, [NOMINAL], ["speeds"], 1, Executor())
    assert len(board.rows) == 10
    for name, row in board.rows.items():
        now = {cell.key: cell.rms_mm for cell in row.outcomes[0].cells}
        (committed,) = (outcome for outcome in rows[name].outcomes if outcome.plant == NOMINAL)
        then = {cell.key: cell.rms_mm for cell in committed.cells if cell.key in now}
        assert then == pytest.approx(now, rel=1e-4), name


def test_results_are_of_the_artefacts_that_ship(rows):
    for name, row in rows.items():
        for outcome in row.outcomes:
            assert outcome.artefact == ENTRANTS[name].artefact(outcome.plant, outcome.seed), (name, outcome.key)


def test_rows_say_what_entrants_say(rows):
    for name, row in rows.items():
        own = ENTRANTS[name].row()
        told = [
            (r.title, r.track, r.about, r.page, r.base, r.seeded, r.command, r.ranked, r.control, r.setpoints)
            for r in (row, own)
        ]
        assert told[0] == told[1]


def test_every_agent_with_feedback_has_margins_of_every_seed(rows):
    current, _ = Board(registry=REGISTRY, folder=DOCS / "results").current()
    found = {row.name: tuple(each.seed for each in row.margins) for row in current if row.margins}
    assert found == {name: ENTRANTS[name].seeds for name in rows if ENTRANTS[name].feedback}


@pytest.mark.parametrize("group", GROUPS)
def test_every_row_is_complete_where_it_may_run(group, rows):
    found = standings(list(rows.values()), group, "held_out")
    assert len(found.grid.plants) == {DRAWS: N_DRAWS, WORKCELLS: N_WORKCELLS}.get(group, 1)
    here = {line.row.name: line.score.seeds for line in found.lines}
    for name, seeds in here.items():
        least = 2 if group == WORKCELLS else 5
        assert len(seeds) >= (least if ENTRANTS[name].row().seeded else 1), name
    assert set(rows) - set(here) == set(found.missing)
    assert found.missing.keys() <= ABSENT[group]


LEARNED_ELSEWHERE = {"bsn_static", "bsn_extended", "bsn_extended_prior", "mlp_fel", "narx", "residual_gp"}
ABSENT = {
    WORKCELLS: LEARNED_ELSEWHERE | {"model_fitted", "ilc_motor", "ilc_tcp", "oracle"},
    THESIS_WORKCELL: set(),
    NOMINAL: {"model_fitted"},
    DRAWS: {"model_fitted", "ilc_motor", "ilc_tcp", "fitted", "amortised_motors", "amortised"}
    | {"ppo_drives", "tqc_drives", "recurrent_ppo_drives"},
}
"""A model of the workcell is no model of another machine; practising takes hours on many machines, so do laws that are
made for each of a hundred; robots drawn without drives say little of policies for drives; the truth of drawn workcells
is shut away."""


def test_drawn_workcells_are_those_of_the_round_whose_hash_was_published(rows):
    found = {outcome.plant for outcome in rows["none"].outcomes if group_of(outcome.plant) == WORKCELLS}
    assert found == set(read_round(DOCS / "round.json").plants)


def test_what_set_points_leave_in_the_docs_is_of_these_results(rows):
    names = ("elastic", "elastic_setpoints", "elastic_setpoints_late")
    text = (DOCS / "README.md").read_text(encoding="utf-8")
    some, costs = [rows[name] for name in ("none", *names)], {}
    for group in GROUPS:
        lines = {line.row.name: line.score for line in standings(some, group, "held_out").lines}
        left = " | ".join(share(lines[name].left, lines[name].left_interval).plain for name in names)
        assert f"| {group_title(group)} | {left} |" in text
        costs[group] = 100 * (lines["elastic_setpoints_late"].left - lines["elastic_setpoints"].left)
    thesis = {name: standings([rows["none"], rows[name]], THESIS_WORKCELL, "held_out").line(name) for name in names}
    at = {name: {each.speed_mm_s: each.rms_um for each in line.score.speeds} for name, line in thesis.items()}
    late, sent = at["elastic_setpoints_late"], at["elastic_setpoints"]
    assert f"{late[100]:.0f} instead of {sent[100]:.0f} um are left at 100 mm/s" in text
    assert f"{late[40]:.1f} instead of {sent[40]:.1f} um at 40 mm/s" in text
    *others, least = (round(cost) for cost in sorted(costs.values(), reverse=True))
    assert f"cost {others[-1]} to {others[0]} percentage points" in text
    assert (least, min(costs, key=costs.__getitem__)) == (1, THESIS_WORKCELL)


def test_the_page_shows_these_results(rows):
    text = (DOCS / "index.html").read_text(encoding="utf-8")
    data = re.search(r'<script type="application/json"[^>]*>(.*?)</script>', text, re.DOTALL)
    shown = json.loads(data[1])
    tables = {table.key: table.plain() for table in map(table_of, all_standings(list(rows.values())))}
    assert differences(shown, json.loads(json.dumps(tables))) == []


def differences(one, other, place=""):
    """Places where two documents differ; numbers beyond the last bits, which differ between processors."""
    if isinstance(one, float) and isinstance(other, float):
        return [] if math.isclose(one, other, rel_tol=1e-12) else [place]
    if isinstance(one, dict) and isinstance(other, dict) and one.keys() == other.keys():
        return [each for key in one for each in differences(one[key], other[key], f"{place}/{key}")]
    if isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        pairs = enumerate(zip(one, other, strict=True))
        return [each for k, pair in pairs for each in differences(*pair, f"{place}/{k}")]
    return [] if one == other else [place]


def test_documents_that_differ_do_so_at_a_place():
    assert differences({"a": [1, 0.1, "x"]}, {"a": [1, 0.1 + 2e-17, "x"]}) == []
    assert differences({"a": [1, 0.1, "x"]}, {"a": [2, 0.1001, "y"]}) == ["/a/0", "/a/1", "/a/2"]
    assert differences({"a": [1]}, {"a": [1, 2]}) == ["/a"]
    assert differences({"a": 1}, {"b": 1}) == [""]


def test_the_readme_tells_of_these_results(rows):
    lines = standings(list(rows.values()), WORKCELLS, "held_out").lines
    left = {line.row.name: round(100 * line.score.left) for line in lines}
    feedback = [left[line.row.name] for line in lines if line.row.feedback and line.row.base == "elastic"]
    told = re.findall(
        r"^\| .* \| (.*) % \|$", (DOCS.parents[1] / "README.md").read_text(encoding="utf-8"), re.MULTILINE
    )
    named = [str(left[name]) for name in ("lugre_dynamic", "elastic", "fitted", "amortised")]
    assert told == [*named[:2], f"{min(feedback)} to {max(feedback)}", *named[2:]]
