"""A page of synthetic rows that several tests look at."""

import pytest

from ffgym.leaderboard.presentation.page import render_page
from tests.leaderboard.synthetic_rows import rows, tracks

PROVENANCE = {"ffgym": "0.0.page", "versions": {"numpy": "9.9"}}
"""Of the page."""


@pytest.fixture(scope="session")
def board_page() -> str:
    """Page of all synthetic rows with three drawn plants."""
    return render_page(rows(draws=3), tracks=tracks(), provenance=PROVENANCE)
