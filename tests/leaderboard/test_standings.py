from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.leaderboard.comparison.samples import DRAWS, HEADLINED, SELECTIONS, WORKCELLS, collect_grid
from ffgym.leaderboard.comparison.standings import standings
from ffgym.leaderboard.comparison.statistics import draw_resamples, interval, resample_iqms
from ffgym.leaderboard.plants import NOMINAL, THESIS_WORKCELL
from ffgym.leaderboard.presentation.page import all_standings
from ffgym.leaderboard.presentation.table import format_standings
from ffgym.leaderboard.presentation.words import circles_note, residual_sentence
from ffgym.leaderboard.results import CircleResult, Outcome, Row
from tests.leaderboard.synthetic_rows import rows

KEYS = [
    ("train", "p1", 1.0, 10.0),
    ("train", "p1", 3.0, 100.0),
    ("positions", "p2", 1.0, 10.0),
    ("positions", "p2", 3.0, 100.0),
    ("radii", "p1", 2.0, 40.0),
    ("speeds", "p1", 3.0, 20.0),
]


def cell(key, rms, motor=(1e-3, 2e-3)):
    split, position, radius, speed = key
    values = (None,) * 4 if rms is None else (rms, 2 * rms, 1.1 * rms, 2.2 * rms)
    names = ("rms_mm", "max_mm", "rms_3d_mm", "max_3d_mm")
    return CircleResult(
        split=split, position=position, radius_mm=radius, speed_mm_s=speed,
        motor_rms_rad=None if rms is None else motor, **dict(zip(names, values, strict=True)),
    )  # fmt: skip


def row(name, errors, *, plants=(NOMINAL,), track="causal", base=None, ranked=True, seconds=0.0, feedback=False):
    """A row whose error in mm on each circle `errors(seed, plant, key)` tells; five seeds if it takes them."""
    seeds = range(5) if "seed" in errors.__code__.co_varnames[:1] else range(1)
    outcomes = [
        Outcome(
            seed=seed, plant=plant, fingerprint="f", versions="-", artefact=None, robot_seconds=seconds, env_steps=0,
            inference_us=None, cells=tuple(cell(key, errors(seed, plant, key)) for key in KEYS),
        )
        for seed in seeds
        for plant in plants
    ]  # fmt: skip
    return Row(
        name=name, title=name.title(), track=track, about="", page=None, base=base, seeded=len(seeds) > 1,
        command=None, ranked=ranked, outcomes=tuple(outcomes), feedback=feedback,
    )  # fmt: skip


def zero_error(key):
    return {10.0: 0.1, 20.0: 0.15, 40.0: 0.25, 100.0: 0.7}[key[3]]


def fixed(name, factor, **options):
    return row(name, lambda _, plant, key: factor * zero_error(key), **options)


def learned(name, factor, spread, **options):
    rng = np.random.default_rng(sum(map(ord, name)))
    factors = factor * np.exp(spread * rng.normal(size=5))
    return row(name, lambda seed, plant, key: factors[seed] * zero_error(key), **options)


NONE = fixed("none", 1.0, ranked=False)


def ranks(rows, group=NOMINAL, selection="held_out"):
    return {line.row.name: line.rank for line in standings(rows, group, selection).lines}


def test_what_is_left_is_the_geometric_mean_of_errors_over_those_with_zero_action():
    half = row("half", lambda _, plant, key: zero_error(key) * (0.25 if key[3] == 10 else 1.0))
    line = standings([NONE, half], NOMINAL, "train").line("half")
    assert line.score.left == pytest.approx(0.5)
    assert line.score.left_interval is None  # nothing is random


def test_figures_of_a_row_are_those_of_its_circles():
    line = standings([NONE, fixed("half", 0.5, seconds=12.0)], NOMINAL, "held_out").line("half")
    score = line.score
    assert [each.speed_mm_s for each in score.speeds] == [10, 20, 40, 100]
    assert [each.rms_um for each in score.speeds] == pytest.approx([50, 75, 125, 350])
    assert [each.reduction for each in score.speeds] == pytest.approx([0.5] * 4)
    assert score.iqm_um == pytest.approx((75 + 125) / 2)
    assert score.iqm_3d_um == pytest.approx(110)
    assert score.max_um == pytest.approx(700)
    assert score.motor_mrad == pytest.approx((1, 2))
    assert (score.worse, score.stopped, score.robot_seconds) == (0, 0, 12)


def test_interquartile_means_have_an_interval_where_something_is_random_and_only_there():
    found = standings([NONE, fixed("half", 0.5), learned("some", 0.5, 0.1)], NOMINAL, "held_out")
    assert found.line("half").score.iqm_interval_um is None
    some = found.line("some").score
    assert some.iqm_interval_um.low < some.iqm_um < some.iqm_interval_um.high


def test_two_seeds_are_enough_for_an_interval_and_two_exact_rows_have_none():
    few = row("few", lambda seed, plant, key: (0.5 + 0.1 * seed) * zero_error(key))
    few = replace(few, outcomes=few.outcomes[:2])
    found = standings([NONE, few, fixed("half", 0.5, base="none")], NOMINAL, "held_out")
    score = found.line("few").score
    assert score.seeds == (0, 1)
    assert score.iqm_interval_um.low < score.iqm_um < score.iqm_interval_um.high
    assert found.line("half").against_base.difference.interval is None


def test_the_interval_of_an_interquartile_mean_is_of_the_same_errors_in_um():
    few = row("few", lambda seed, plant, key: (0.5 + 0.1 * seed) * zero_error(key))
    score = standings([NONE, few], NOMINAL, "held_out").line("few").score
    errors = np.array([zero_error(key) for key in sorted(KEYS) if key[0] in SELECTIONS["held_out"]])
    values = (0.5 + 0.1 * np.arange(5))[:, None, None] * errors * 1e3
    expected = interval(resample_iqms(values, draw_resamples("few", 5, 1)), 5)
    assert (score.iqm_interval_um.low, score.iqm_interval_um.high) == pytest.approx((expected.low, expected.high))


def test_a_row_of_two_seeds_beside_an_exact_one_differs_with_an_interval():
    few = row("few", lambda seed, plant, key: (0.5 + 0.1 * seed) * zero_error(key), base="exact")
    found = standings([NONE, replace(few, outcomes=few.outcomes[:2]), fixed("exact", 0.5)], NOMINAL, "held_out")
    difference = found.line("few").against_base.difference
    assert difference.interval.low < difference.ratio < difference.interval.high


def test_cells_made_worse_are_counted():
    mixed = row("mixed", lambda _, plant, key: zero_error(key) * (1.5 if key[3] == 100 else 0.5))
    found = standings([NONE, mixed], NOMINAL, "held_out")
    assert found.line("mixed").score.worse == pytest.approx(1 / 4)
    assert found.line("none").score.worse == 0


def test_the_score_is_0_for_zero_action_and_1_for_the_oracle_and_unknown_without_one():
    rows = [NONE, fixed("oracle", 0.2, track="oracle"), fixed("some", 0.6)]
    found = standings(rows, NOMINAL, "held_out")
    scores = {line.row.name: line.score.normalised for line in found.lines}
    assert scores == pytest.approx({"none": 0, "oracle": 1, "some": 0.5})
    assert standings(rows[::2], NOMINAL, "held_out").line("some").score.normalised is None


def test_circles_on_which_the_oracle_does_not_help_tell_no_score():
    useless = fixed("oracle", 1.1, track="oracle")
    assert standings([NONE, useless, fixed("some", 0.6)], NOMINAL, "held_out").line("some").score.normalised is None


def test_circles_on_which_the_oracle_changes_nothing_are_left_out_of_the_score():
    partly = row("oracle", lambda _, plant, key: zero_error(key) * (1.0 if key[3] == 10 else 0.2), track="oracle")
    found = standings([NONE, partly, fixed("some", 0.6)], NOMINAL, "held_out")
    assert found.line("some").score.normalised == pytest.approx(0.5)


def test_the_oracle_of_each_plant_is_that_beside_which_a_row_is_scored():
    plants = tuple(f"draw:{k}" for k in range(4))
    hard = {plant: 1.0 + k for k, plant in enumerate(plants)}

    def times(factor):
        return lambda _, plant, key: factor * hard[plant] * zero_error(key)

    rows = [
        row(name, times(factor), plants=plants, **options)
        for name, factor, options in (
            ("none", 1.0, {"ranked": False}),
            ("oracle", 0.2, {"track": "oracle"}),
            ("some", 0.6, {}),
        )
    ]
    score = standings(rows, DRAWS, "held_out").line("some").score
    assert score.normalised == pytest.approx(0.5)
    assert (score.left, score.worse) == (pytest.approx(0.6), 0.0)


def test_oracle_zero_and_rows_that_are_shown_only_have_no_rank_and_come_last():
    rows = [NONE, fixed("oracle", 0.1), fixed("random", 2.0, ranked=False), fixed("good", 0.5), fixed("bad", 0.9)]
    assert ranks(rows) == {"good": 1, "bad": 2, "oracle": None, "none": None, "random": None}
    assert list(ranks(rows)) == ["good", "bad", "oracle", "none", "random"]


def test_rows_whose_difference_may_be_zero_share_a_rank_and_the_next_rank_is_its_place():
    rows = [NONE, learned("a", 0.5, 0.1), learned("b", 0.51, 0.1), learned("c", 0.9, 0.01)]
    assert ranks(rows) == {"a": 1, "b": 1, "c": 3} | {"none": None}


def test_two_rows_without_chance_differ_however_little():
    assert ranks([NONE, fixed("a", 0.5), fixed("b", 0.5001), fixed("c", 0.5)]) == {
        "a": 1, "c": 1, "b": 3, "none": None,
    }  # fmt: skip


def test_plants_are_paired_so_that_a_small_difference_on_unlike_plants_counts():
    plants = tuple(f"draw:{k}" for k in range(8))
    hard = {plant: 1 + k for k, plant in enumerate(plants)}
    zero = row("none", lambda _, plant, key: zero_error(key), plants=plants, ranked=False)
    a = row("a", lambda _, plant, key: 0.05 * hard[plant] * zero_error(key), plants=plants)
    b = row("b", lambda _, plant, key: 0.0505 * hard[plant] * zero_error(key), plants=plants)
    found = standings([zero, a, b], DRAWS, "held_out")
    first, second = (found.line(name).score.left_interval for name in "ab")
    assert second.low < first.high
    assert [found.line(name).rank for name in "ab"] == [1, 2]


def test_ranks_within_a_track_leave_the_others_out():
    rows = [
        NONE,
        fixed("a", 0.2),
        fixed("b", 0.3, track="per task"),
        fixed("c", 0.4),
        fixed("d", 0.5, track="per task"),
        fixed("e", 0.6, feedback=True),
    ]
    lines = standings(rows, NOMINAL, "held_out").ranked
    assert [(line.row.name, line.rank, line.track_rank) for line in lines] == [
        ("a", 1, 1), ("b", 2, 1), ("c", 3, 2), ("d", 4, 2), ("e", 5, 1),
    ]  # fmt: skip


def test_neither_the_order_of_rows_nor_that_of_results_matters():
    rows = [NONE, learned("a", 0.5, 0.1), learned("b", 0.6, 0.1, base="a"), fixed("c", 0.55)]
    turned = [
        replace(each, outcomes=tuple(replace(one, cells=one.cells[::-1]) for one in each.outcomes[::-1]))
        for each in rows[::-1]
    ]
    for one, other in zip(
        standings(rows, NOMINAL, "held_out").lines, standings(turned, NOMINAL, "held_out").lines, strict=True
    ):
        assert (one.row.name, one.score, one.rank) == (other.row.name, other.score, other.rank)
        assert one.against_base == other.against_base


@pytest.mark.parametrize(
    ("factor", "spread", "words", "sign"),
    [
        (0.3, 0.02, "better than its base", -1),
        (0.7, 0.02, "worse than its base", 1),
        (0.5, 0.2, "not better: the interval includes zero", 0),
    ],
)
def test_a_residual_is_told_against_its_base_on_held_out_circles(factor, spread, words, sign):
    rows = [NONE, fixed("base", 0.5), learned("residual", factor, spread, base="base")]
    for selection in SELECTIONS:
        found = standings(rows, NOMINAL, selection).line("residual").against_base
        assert (found.base, found.sentence, found.difference.sign) == ("base", words, sign)
        assert found.difference.interval.includes(found.difference.ratio)


def test_learned_feedback_counts_as_learning_only_if_it_beats_servo_gains():
    rows = [
        NONE,
        fixed("base", 0.5),
        learned("slow", 0.45, 0.01, base="base"),
        learned("quick", 0.2, 0.01, base="base"),
    ]
    gains = fixed("servo_gains", 0.3, base="base")
    without, found = (standings(each, NOMINAL, "held_out") for each in (rows, [*rows, gains]))
    assert without.line("quick").against_gains is None
    assert "servo gains" not in residual_sentence(without)
    assert found.line("servo_gains").against_gains is None
    assert found.line("slow").against_gains.sentence == "worse than servo gains"
    assert found.line("quick").against_gains.sentence == "better than servo gains"
    told = residual_sentence(found)
    assert told.startswith("Of 2 agents that learned on top of another one, 2 are better than their base")
    assert "1 of 2 is better than servo gains, a linear feedback of three numbers, and so counts as learning: " in told
    assert told.index("Quick", told.index("servo gains")) > 0
    better = fixed("servo_gains_drives", 0.15, base="base")
    both = standings([*rows, gains, better], NOMINAL, "held_out")
    assert both.line("quick").against_gains.base == "servo_gains_drives"
    assert both.line("quick").against_gains.sentence == "worse than servo gains"
    assert both.line("servo_gains_drives").against_gains is None
    assert "Slow" not in told[told.index("servo gains") :]


def test_what_a_residual_does_where_agents_may_learn_is_no_better_than_its_base():
    overfit = row("residual", lambda _, plant, key: (0.1 if key[0] == "train" else 0.6) * zero_error(key), base="base")
    found = standings([NONE, fixed("base", 0.5), overfit], NOMINAL, "train").line("residual")
    assert found.rank == 1
    assert found.against_base.sentence == "worse than its base"


def test_a_residual_is_unknown_where_zero_action_has_no_held_out_circles():
    rows = [with_splits(NONE, "train"), fixed("base", 0.5), learned("residual", 0.3, 0.02, base="base")]
    found = standings(rows, NOMINAL, "train").line("residual").against_base
    assert (found.difference, found.sentence) == (None, "unknown: zero action has no held-out circles here")


@pytest.mark.parametrize(
    ("factor", "words"),
    [(0.5, "not better: the same as its base"), (0.4, "better than its base"), (0.6, "worse than its base")],
)
def test_an_exact_residual_is_better_worse_or_the_same_as_its_exact_base(factor, words):
    rows = [NONE, fixed("base", 0.5), fixed("residual", factor, base="base")]
    assert standings(rows, NOMINAL, "train").line("residual").against_base.sentence == words


def test_a_residual_that_has_not_run_on_all_held_out_circles_is_named_before_its_base():
    rows = [NONE, *(with_splits(fixed(name, 0.5, base=base), "train") for name, base in (("b", None), ("r", "b")))]
    found = standings(rows, NOMINAL, "train").line("r").against_base
    assert found.sentence == "unknown: r has not run on all held-out circles here"


def test_a_residual_without_its_base_is_told_to_be_unknown():
    found = standings([NONE, fixed("residual", 0.3, base="base")], NOMINAL, "train").line("residual").against_base
    assert found.difference is None
    assert "base has not run" in found.sentence


def test_a_robot_that_stopped_is_worse_than_any_error_and_never_left_out():
    stopped = row("stopped", lambda _, plant, key: None if key[3] == 40 else 0.01 * zero_error(key))
    found = standings([NONE, stopped, fixed("bad", 3.0)], NOMINAL, "held_out")
    score = found.line("stopped").score
    assert [line.row.name for line in found.ranked] == ["bad", "stopped"]
    assert (score.left, score.max_um, score.stopped, score.worse) == (np.inf, np.inf, 0.25, 0.25)
    assert score.speeds[2].reduction == -np.inf
    assert score.speeds[0].rms_um == pytest.approx(1.0)


def test_two_rows_that_stopped_share_the_last_rank():
    never = [row(name, lambda _, plant, key: None) for name in ("a", "b")]
    assert ranks([NONE, *never, fixed("bad", 3.0)]) == {"bad": 1, "a": 2, "b": 2, "none": None}


def test_a_row_that_lacks_circles_plants_or_seeds_is_left_out_and_the_reason_told():
    whole = learned("whole", 0.5, 0.1)
    first = whole.outcomes[0]
    fewer = replace(whole, name="fewer", outcomes=(replace(first, cells=first.cells[:-1]), *whole.outcomes[1:]))
    elsewhere = fixed("elsewhere", 0.5, plants=(THESIS_WORKCELL,))
    found = standings([NONE, fewer, elsewhere], NOMINAL, "held_out")
    assert found.missing == {
        "fewer": "seed 0 on plant nominal lacks 1 of 4 circles", "elsewhere": "not run on these plants",
    }  # fmt: skip
    assert found.line("fewer") is None
    assert standings([NONE, fewer], NOMINAL, "train").missing == {}


def with_splits(row, *splits, plant=NOMINAL):
    """The row without other splits on a plant."""
    outcomes = [
        replace(one, cells=tuple(each for each in one.cells if each.split in splits)) if one.plant == plant else one
        for one in row.outcomes
    ]
    return replace(row, outcomes=tuple(outcomes))


def test_plants_where_zero_action_lacks_circles_are_left_out_and_told():
    plants = ("draw:0", "draw:1", "draw:2")
    zero, some = fixed("none", 1.0, plants=plants, ranked=False), fixed("some", 0.5, plants=plants)
    found = standings([with_splits(zero, "positions", plant="draw:1"), some], DRAWS, "held_out")
    assert (found.grid.plants, found.grid.left_out) == (("draw:0", "draw:2"), ("draw:1",))
    assert len(found.grid.cells) == 4
    assert found.line("some").score.left == pytest.approx(0.5)
    assert "Without draw:1, where zero action lacks some of these circles." in circles_note(found)


def test_a_selection_is_there_only_with_all_of_its_splits():
    rows = [with_splits(NONE, "train", "positions"), fixed("some", 0.5)]
    assert [each.selection for each in all_standings(rows)] == ["positions", "thesis", "train"]
    with pytest.raises(FFGymError, match="was not run on nominal with positions, radii, speeds"):
        standings(rows, NOMINAL, "held_out")


def test_a_residual_is_told_on_the_held_out_circles_that_were_run():
    rows = [with_splits(NONE, "train", "positions"), fixed("base", 0.5), learned("residual", 0.3, 0.02, base="base")]
    found = standings(rows, NOMINAL, "thesis").line("residual").against_base
    assert found.sentence == "better than its base"


def test_every_workcell_is_a_group_of_its_own():
    plants = (NOMINAL, "workcell:3", THESIS_WORKCELL, "draw:0")
    rows = [fixed("none", 1.0, plants=plants, ranked=False), fixed("some", 0.5, plants=plants)]
    groups = list(dict.fromkeys(each.group for each in all_standings(rows)))
    assert groups == [THESIS_WORKCELL, NOMINAL, DRAWS, "workcell:3"]
    assert "workcell '3'" in format_standings(standings(rows, "workcell:3", "held_out"))


def test_drawn_workcells_are_one_group_before_all_others():
    plants = (NOMINAL, "workcell:drives-1", "workcell:drives-2")
    rows = [fixed("none", 1.0, plants=plants, ranked=False), fixed("some", 0.5, plants=plants)]
    every = all_standings(rows)
    assert list(dict.fromkeys(each.group for each in every)) == [WORKCELLS, NOMINAL]
    assert every[0].grid.plants == plants[1:]
    assert "2 drawn workcells" in " ".join(format_standings(every[0]).split())
    alone = [replace(each, outcomes=each.outcomes[:2]) for each in rows]
    assert standings(alone, WORKCELLS, "held_out").line("some").unproven == "one drawn workcell"


def test_a_row_that_met_other_physics_than_zero_action_is_left_out():
    some = fixed("some", 0.01)
    other = replace(some, outcomes=(replace(some.outcomes[0], fingerprint="older"),))
    assert standings([NONE, other], NOMINAL, "train").missing == {
        "some": "seed 0 on plant nominal met other physics than zero action"
    }


def test_what_one_seed_learned_is_not_told_to_be_better_than_its_base():
    residual = learned("residual", 0.3, 0.02, base="base")
    one = replace(residual, outcomes=residual.outcomes[:1])
    found = standings([NONE, fixed("base", 0.5), one], NOMINAL, "held_out")
    line = found.line("residual")
    assert (line.unproven, line.against_base.sentence) == ("one seed", "unknown: one seed")
    assert line.against_base.difference.ratio < 1
    assert "0 are better than their base on held-out circles, nominal robot. Unknown of Residual." in residual_sentence(
        found
    )
    assert "so that the place is not proven: residual (one seed)" in circles_note(found)
    assert found.line("base").unproven is None


def test_one_drawn_robot_proves_nothing_of_the_others():
    plants = ("draw:0",)
    rows = [fixed("none", 1.0, plants=plants, ranked=False), fixed("some", 0.5, plants=plants)]
    assert standings(rows, DRAWS, "held_out").line("some").unproven == "one drawn robot"


def test_a_missing_plant_of_one_seed_is_told():
    plants = ("draw:0", "draw:1")
    zero = fixed("none", 1.0, plants=plants)
    some = learned("some", 0.5, 0.1, plants=plants)
    found = standings([zero, replace(some, outcomes=some.outcomes[:-1])], DRAWS, "held_out")
    assert found.missing == {"some": "seed 4 was not run on plant draw:1"}


@pytest.mark.parametrize(
    ("rows", "group", "selection", "message"),
    [
        ([fixed("a", 0.5)], NOMINAL, "train", "zero action's row 'none'"),
        ([NONE, NONE], NOMINAL, "train", "Two rows"),
        ([NONE], DRAWS, "train", "was not run on draws"),
        ([NONE], "moon", "train", "was not run on moon"),
        ([NONE], NOMINAL, "all", "Unknown selection of circles 'all'"),
        ([row("none", lambda _, plant, key: None)], NOMINAL, "train", "stopped with zero action"),
        ([NONE, fixed("a", 0.0)], NOMINAL, "train", "must be > 0"),
    ],
)
def test_what_cannot_be_compared_is_refused(rows, group, selection, message):
    with pytest.raises(FFGymError, match=message):
        standings(rows, group, selection)


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


def test_drawn_workcells_and_then_the_workcell_of_the_thesis_are_the_headline():
    assert HEADLINED == (WORKCELLS, THESIS_WORKCELL)


def test_circles_of_an_unknown_split_are_refused():
    with pytest.raises(FFGymError, match="Unknown split 'moon'"):
        collect_grid(NONE, NOMINAL, ["train", "moon"])


def test_selections_are_all_held_out_circles_each_split_those_of_the_thesis_and_those_of_training():
    assert SELECTIONS["held_out"] == ("positions", "radii", "speeds")
    assert [SELECTIONS[split] for split in ("positions", "radii", "speeds")] == [
        ("positions",),
        ("radii",),
        ("speeds",),
    ]
    assert SELECTIONS["thesis"] == ("train", "positions")
    assert SELECTIONS["train"] == ("train",)
