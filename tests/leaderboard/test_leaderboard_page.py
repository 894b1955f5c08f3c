import base64
import hashlib
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.leaderboard.comparison.samples import GROUPS, SELECTIONS, WORKCELLS
from ffgym.leaderboard.plants import NOMINAL, THESIS_WORKCELL
from ffgym.leaderboard.presentation.page import ToolTrace, render_page
from ffgym.leaderboard.presentation.pictures import compute_traces, number, tool_pictures
from ffgym.leaderboard.presentation.words import best_reductions, list_published_rows
from ffgym.leaderboard.results import Trail
from tests.leaderboard.conftest import PROVENANCE
from tests.leaderboard.synthetic_rows import SORTS, row, tracks

NAMES = ("none", "lugre_dynamic", "elastic", "tqc_elastic")


def small(names=NAMES, plants=(THESIS_WORKCELL,), **changed):
    return [replace(row(name, list(plants), seeds=3), **changed.get(name, {})) for name in names]


def render(some, **options):
    return render_page(some, provenance={}, **options)


def data_of(page):
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)[1])


def table_of(page):
    return re.search(r'<table id="board">.*?</table>', page, re.S)[0]


def test_the_page_has_every_table_and_every_card(board_page):
    tables = data_of(board_page)
    assert set(tables) == {f"{group}|{selection}" for group in GROUPS if group != WORKCELLS for selection in SELECTIONS}
    assert {name for name in SORTS if f'id="agent-{name}"' in board_page} == set(SORTS)
    widths = {len(table["columns"]) for table in tables.values()}
    assert all(len(line[4]) == len(table["columns"]) for table in tables.values() for line in table["lines"])
    assert len(widths) > 1  # a column per speed


def test_cards_and_table_tell_what_a_row_acts_through(board_page):
    sent = re.search(r'id="agent-narx".*?</details>', board_page, re.S)[0]
    assert "set-points of position, one every 4 ms; delay 8.00 ms, no filter, not compensated" in sent
    assert '<span class="tag">set-points</span>' in sent
    added = re.search(r'id="agent-elastic".*?</details>', board_page, re.S)[0]
    assert "<dt>channel</dt><dd>torque of the motors</dd>" in added
    assert '<span class="tag">set-points</span>' not in added
    table = data_of(board_page)[f"{THESIS_WORKCELL}|held_out"]
    k = [column[0] for column in table["columns"]].index("channel")
    told = {line[1]: (line[4][k][0], *line[4][k][2:]) for line in table["lines"]}
    assert told["narx"] == ("set-points", "+8 ms")
    assert {each for name, each in told.items() if name != "narx"} == {("torque",)}


def test_cards_are_of_the_held_out_circles_that_were_run():
    some = [
        replace(each, outcomes=tuple(replace(o, cells=o.cells[:36]) for o in each.outcomes))  # those of the thesis
        for each in small()
    ]
    page = render(some)
    assert set(data_of(page)) == {f"{THESIS_WORKCELL}|{name}" for name in ("positions", "thesis", "train")}
    assert "<figcaption>workcell “thesis”, held-out positions." in page
    assert "no complete result on held-out circles" not in page
    assert re.search(r"rank 1, leaves \d", page)


def test_how_to_read_the_page_comes_before_the_headline_and_the_table(board_page):
    places = [board_page.index(words) for words in ("How to read this page", 'class="headline"', 'id="board"')]
    assert places == sorted(places)


def test_random_torque_is_not_told_to_have_learned(board_page):
    lines = data_of(board_page)[f"{THESIS_WORKCELL}|held_out"]["lines"]
    learned = {line[1]: line[3] for line in lines}
    assert (learned["random"], learned["bsn_static"], learned["tqc_elastic"]) == (0, 1, 1)


def test_the_page_asks_for_nothing_outside(board_page):
    assert not re.search(r"""(src|href)\s*=\s*["']?(https?:)?//""", board_page)
    assert not re.search(r"url\(|@import|<link[^>]+stylesheet|<iframe|<object", board_page)
    policy = re.search(r'Content-Security-Policy" content="([^"]+)"', board_page)[1]
    assert policy.startswith("default-src 'none'")
    script = re.findall(r"<script>(.*?)</script>", board_page, re.S)
    digest = base64.b64encode(hashlib.sha256(script[0].encode()).digest()).decode()
    assert len(script) == 1
    assert f"script-src 'sha256-{digest}'" in policy.replace("&#39;", "'").replace("&#43;", "+")


def test_the_same_rows_in_any_order_give_the_same_bytes():
    some = small()
    turned = [replace(each, outcomes=each.outcomes[::-1]) for each in some[::-1]]
    assert render(some, tracks=tracks()) == render(turned, tracks=dict(reversed(tracks().items())))


def test_what_rows_are_called_cannot_become_markup():
    evil = "</script><script>alert(1)</script><img src=x onerror=alert(2)>'\""
    fields = ("title", "about", "command", "page", "track")
    some = small(elastic=dict.fromkeys(fields, evil))
    told = [replace(row, outcomes=tuple(replace(o, versions=evil) for o in row.outcomes)) for row in some]
    page = render(told)
    assert "<script>alert" not in page
    assert "<img" not in page
    assert page.count("</script>") == 2
    assert any(
        line[1] == "elastic" and evil in line[4][1] for line in data_of(page)[f"{THESIS_WORKCELL}|held_out"]["lines"]
    )


def test_without_javascript_the_workcells_held_out_circles_are_there(board_page):
    table = table_of(board_page)
    assert "TQC on elastic feed-forward" in table
    assert "published, real robot" in table
    first = data_of(board_page)[f"{THESIS_WORKCELL}|held_out"]
    assert table.count('<th scope="row"') == len(first["lines"])
    for line in first["lines"]:
        for text, *_ in line[4]:
            assert text in table.replace("&#39;", "'")


def test_the_headline_is_of_drawn_workcells_where_they_were_run():
    page = render(small(plants=("workcell:drives-1", "workcell:drives-2", THESIS_WORKCELL)))
    headline = re.search(r'<div class="headline">(.*?)</header>', page, re.S)[1]
    assert "On 2 drawn workcells, at positions without training" in headline
    assert "with feedback, 2 drawn workcells, held-out positions" in headline or "feed-forward, 2 drawn" in headline


def test_the_headline_says_who_is_best_and_by_how_much(board_page):
    headline = re.search(r'<div class="headline">(.*?)</header>', board_page, re.S)[1]
    shown = [line for line in data_of(board_page)[f"{THESIS_WORKCELL}|positions"]["lines"] if line[1] == "tqc_elastic"]
    assert "TQC on elastic feed-forward leaves the least error" in headline
    for k in (4, 5, 6):
        change = shown[0][4][k][2]
        assert f"{change.strip('−%')}% less" in headline
    assert "iterative learning on the tool" in headline
    assert all(f"{track}, workcell" in headline for track in ("feed-forward", "with feedback"))
    assert "54% less (dynamic LuGre)" in headline
    assert "published as figures only" in headline


def test_the_two_tracks_are_told_apart_in_table_and_cards(board_page):
    tracks = {line[1]: line[2] for line in data_of(board_page)[f"{THESIS_WORKCELL}|held_out"]["lines"]}
    assert (tracks["elastic"], tracks["tqc_elastic"]) == ("feed-forward", "with feedback")
    for name, track in tracks.items():
        if track != "published":
            card = re.search(rf'id="agent-{name}">(.*?)</details>', board_page, re.S)[1]
            assert f"<dt>track</dt><dd>{track}</dd>" in card, name


def test_residuals_that_are_better_than_their_base_are_named_in_the_headline(board_page):
    assert re.search(r"Of 4 agents that learned on top of another one, \d (is|are) better than their base", board_page)


def test_published_rows_are_marked_never_ranked_and_of_measured_circles_only():
    assert list_published_rows([("radii", "p1", 2.0, 10.0), ("speeds", "p1", 3.0, 20.0)]) == []
    page = render(small())
    lines = data_of(page)[f"{THESIS_WORKCELL}|positions"]["lines"]
    published = [line for line in lines if line[0] == "published"]
    assert len(published) == 5
    assert all(line[4][0][0] == "–" and "published" in line[4][1][2] for line in published)
    assert "another machine, never ranked" in page
    assert not [line for line in data_of(page)[f"{THESIS_WORKCELL}|radii"]["lines"] if line[0] == "published"]


def test_the_best_published_reductions_are_those_of_the_thesis():
    best = best_reductions()
    assert {speed: round(share, 2) for speed, (_, share) in best.items()} == {10.0: 0.54, 40.0: 0.28}


def test_a_row_whose_robot_stopped_is_shown_as_stopped():
    some = small()
    cells = [
        replace(cell, rms_mm=None, max_mm=None, rms_3d_mm=None, motor_rms_rad=None)
        for cell in some[2].outcomes[0].cells
    ]
    some[2] = replace(some[2], outcomes=(replace(some[2].outcomes[0], cells=tuple(cells)),))
    page = render(some)
    line = next(line for line in data_of(page)[f"{THESIS_WORKCELL}|held_out"]["lines"] if line[1] == "elastic")
    assert line[4][3][:2] == ["stopped", 1e300]
    assert "100.0% stopped" in str(line)


def test_cards_tell_how_an_agent_came_to_be():
    page = render(small(), agent_pages="https-free/")
    card = re.search(r'<details class="card" id="agent-tqc_elastic">(.*?)</details>', page, re.S)[1]
    for words in (
        "ffgym train tqc_elastic --seeds 3",
        "2 M environment steps",
        "Learning curve",
        'href="#agent-elastic"',
    ):
        assert words in card
    for outcome in small()[3].outcomes:
        assert outcome.artefact in card
        assert outcome.fingerprint in card
    assert 'href="https-free/lugre.md"' in page


def test_a_page_without_the_workcell_says_so():
    page = render(small(plants=(NOMINAL,)))
    assert "held-out positions have not been run yet" in page
    assert "<figcaption>nominal robot, held out: positions, radii, speeds." in page


def test_a_page_without_zero_action_is_refused():
    with pytest.raises(FFGymError, match="zero action"):
        render(small(["elastic"]))


def test_provenance_is_on_the_page(board_page):
    assert PROVENANCE["ffgym"] in board_page
    assert "ffgym 0.0.test" in board_page  # of the rows, on the cards


def circle(outward, n=100):
    angle = np.linspace(0, 2 * np.pi, n)
    unit = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return 3 * unit, (3 + outward) * unit


def test_only_the_distance_from_the_path_is_enlarged_not_the_delay():
    reference, tool = circle(0.1)
    path = ToolTrace(reference=reference, tool=np.roll(tool[:-1], 7, axis=0))
    np.testing.assert_allclose(np.linalg.norm(path.enlarge(5.0), axis=1), 3.5, atol=0.01)


@pytest.mark.parametrize(("outward", "factor"), [(0.001, 100), (0.08, 10), (0.3, 2), (2.0, 1)])
def test_an_error_is_enlarged_as_far_as_the_path_stays_recognisable(outward, factor):
    reference, tool = circle(outward)
    assert ToolTrace(reference=reference, tool=tool).magnification == factor


def test_an_agents_error_is_enlarged_as_much_as_that_of_zero_action():
    own, zero = (ToolTrace(reference=circle(d)[0], tool=circle(d)[1]) for d in (0.001, 0.08))
    picture = tool_pictures({10.0: own}, {10.0: zero})[0]
    assert picture.caption == "10 mm/s, error × 10"
    assert [line.colour for line in picture.lines] == ["reference", "zero", "own"]


def test_trails_of_results_become_paths_of_the_first_seed():
    trail = Trail(position="p2", radius_mm=3.0, speed_mm_s=40.0, deviation_um=(100.0,) * 120)
    some = row("elastic", [THESIS_WORKCELL])
    with_trail = replace(some, outcomes=tuple(replace(each, trails=(trail,)) for each in some.outcomes))
    paths = compute_traces([row("none", [THESIS_WORKCELL]), with_trail])
    assert list(paths) == ["elastic"]
    np.testing.assert_allclose(np.linalg.norm(paths["elastic"][40.0].enlarge(2.0), axis=1), 3.2, atol=1e-3)
    assert paths["elastic"][40.0].where == "p2, r = 3 mm, workcell:thesis"


@pytest.mark.parametrize(("value", "text"), [(0.0, "0"), (-0.0001, "0"), (1.5, "1.5"), (-10.0, "-10"), (100.0, "100")])
def test_numbers_of_pictures_are_short(value, text):
    assert number(value) == text


def test_a_page_of_all_rows_is_small_enough_to_send(board_page):
    assert len(board_page) < 1_500_000
    assert board_page.count('<details class="card"') == len(SORTS)
