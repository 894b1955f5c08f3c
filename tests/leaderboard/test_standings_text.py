import pytest

from ffgym.leaderboard.comparison.samples import DRAWS
from ffgym.leaderboard.comparison.standings import standings
from ffgym.leaderboard.plants import NOMINAL, THESIS_WORKCELL
from ffgym.leaderboard.presentation.table import format_standings
from tests.leaderboard.synthetic_rows import rows


@pytest.fixture(scope="module")
def some():
    return rows(draws=2, seeds=3)


@pytest.mark.parametrize("group", [NOMINAL, THESIS_WORKCELL, DRAWS])
def test_standings_fit_a_terminal_and_name_every_row(some, group):
    text = format_standings(standings(some, group, "thesis"))
    assert max(map(len, text.splitlines())) <= 120
    assert text.isascii()
    assert all(row.name in text for row in some)


def test_the_table_begins_with_the_best_and_says_who_is_missing(some):
    text = format_standings(standings(some, THESIS_WORKCELL, "held_out"))
    lines = text.splitlines()
    assert lines[3].startswith("1     ilc_tcp")
    assert "oracle: not run on these plants" in " ".join(lines)
    assert "better than their base" in text


def test_what_the_tracker_of_a_workcell_cannot_see_is_told(some):
    words = "a laser tracker with 10 um of noise in each coordinate"
    texts = {group: format_standings(standings(some, group, "thesis")) for group in (NOMINAL, THESIS_WORKCELL)}
    assert [words in " ".join(text.split()) for text in texts.values()] == [False, True]
