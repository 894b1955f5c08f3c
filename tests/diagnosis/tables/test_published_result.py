"""The result for the thesis that ships says of every structure what its rows say."""

import json
from pathlib import Path

import numpy as np
import pytest

from ffgym.diagnosis.tables.parts import SINGLE, find_structure
from ffgym.diagnosis.tables.published import thesis_table

RESULT = Path(__file__).parents[3] / "docs" / "published_robot.json"


@pytest.fixture(scope="module")
def result():
    return json.loads(RESULT.read_text(encoding="utf-8"))


def test_its_rows_are_those_of_the_thesis(result):
    assert [row["value_mm"] for row in result["rows"]] == thesis_table().values.tolist()


def test_all_structures_are_there_and_some_pairs(result):
    names = {one["name"] for one in result["structures"]}
    assert set(SINGLE) < names
    assert sum("+" in name for name in names) >= 3


def test_its_counts_follow_from_its_rows(result):
    table = thesis_table()
    for one in result["structures"]:
        assert one["free_parameters"] == len(find_structure(one["name"]).numbers) == len(one["numbers"]) <= 14
        right = np.abs(np.log(np.array(one["predicted_mm"]) / table.values)) < np.log(1.5)
        # rounded to a tenth of a micrometre, an error may cross the factor
        assert abs(int(right[table.is_rms & table.fitted].sum()) - one["fitted_within_1_5"]) <= 1
        assert abs(int(right[table.is_rms & ~table.fitted].sum()) - one["held_out_within_1_5"]) <= 1


def test_its_scores_follow_from_rows_that_a_fit_did_not_see(result):
    table = thesis_table()
    for one in result["structures"]:
        unseen = np.where(table.fitted, np.array(one["left_out_mm"], dtype=float), one["predicted_mm"])
        logs = np.abs(np.log(unseen / table.values))[table.is_rms]
        assert np.mean(logs**2) == pytest.approx(one["score"], rel=5e-3)
        assert abs(int(np.sum(logs[table.fitted[table.is_rms]] < np.log(1.5))) - one["left_out_within_1_5"]) <= 1
    scores = [one["score"] for one in result["structures"]]
    assert scores == sorted(scores)


def test_its_signs_follow_from_its_rows(result):
    pairs = thesis_table().sign_pairs()
    for one in result["structures"]:
        ratios = [one["predicted_mm"][law] / one["predicted_mm"][none] for law, none in pairs]
        assert ratios == pytest.approx(one["sign_ratios"], rel=2e-3)
        right = [(a < 1) == (b < 1) for a, b in zip(one["sign_ratios"], one["sign_measured"], strict=True)]
        assert one["sign_right"] == sum(right)


def test_the_verdict_names_no_structure_with_the_wrong_sign(result):
    best = next(one for one in result["structures"] if one["name"] == result["structure"])
    assert result["verdict"] != "named" or 2 * best["sign_right"] > best["sign_cells"]
