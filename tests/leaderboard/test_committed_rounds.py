"""Rounds: a seed draws machines and motions; it is committed to by a hash and revealed afterwards."""

import hashlib
import json

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.leaderboard.motions import CIRCLE, KINDS, SPIRAL, SQUARE, TILTED, ZONE
from ffgym.leaderboard.submission.rounds import (
    RADII,
    SEEDS,
    SPEEDS,
    TILTS,
    WIDER,
    Round,
    draw_round,
    read_commitment,
    read_round,
)
from ffgym.leaderboard.tasks import Task, duration_of, make_references
from ffgym.robot import RigidArm, load_robot

ROBOT = load_robot("irb4600_60_205")
AREA = ROBOT.work_area


def written(tmp_path, tree, name="round.json"):
    """File of a round."""
    place = tmp_path / name
    place.write_text(json.dumps(tree))
    return place


def test_a_seed_draws_the_same_machines_and_motions_and_another_seed_others():
    one, same, other = Round(seed=5), Round(seed=5, salt="x"), Round(seed=6)
    assert one.plants == same.plants
    assert one.draw_motions(AREA) == same.draw_motions(AREA)
    assert not set(one.plants) & set(other.plants)
    assert not set(one.draw_motions(AREA)) & set(other.draw_motions(AREA))


def test_more_machines_or_motions_leave_those_before_as_they_are():
    few, many = Round(seed=5, machines=3, motions=2), Round(seed=5, machines=9, motions=7)
    assert many.plants[:3] == few.plants
    assert many.draw_motions(AREA)[:2] == few.draw_motions(AREA)


def test_fresh_rounds_differ():
    assert len({draw_round(machines=1).plants for _ in range(20)}) == 20


def test_the_series_of_machines_is_one_argument():
    for series in ("workcell:", "draw:"):
        assert all(name.startswith(series) for name in Round(seed=1, series=series).plants)
    with pytest.raises(FFGymError, match="Unknown plant"):
        Round(seed=1, series="nothing:")


@pytest.mark.parametrize("seed", range(20))
def test_machines_and_motions_are_none_that_are_public(seed):
    drawn = Round(seed=seed, motions=8)
    assert all(SEEDS[0] <= int(name.partition(":")[2]) < SEEDS[1] for name in drawn.plants)
    corners = np.array(list(AREA.positions.values()))
    for task in drawn.draw_motions(AREA):
        assert np.all(corners.min(axis=0) <= task.centre)
        assert np.all(task.centre <= corners.max(axis=0))
        assert np.linalg.norm(corners - task.centre, axis=1).min() > 0.009
        size = task.radii[0] / (1.0 if task.kind in (CIRCLE, TILTED) else WIDER)
        assert RADII[0] <= size <= RADII[1]
        assert SPEEDS[0] <= task.speed <= SPEEDS[1]


def test_a_drawn_motion_is_a_circle_about_its_centre():
    arm = RigidArm(ROBOT)
    task = Round(seed=5).draw_motions(AREA)[0]
    [reference] = make_references(arm, [task])
    assert np.allclose(arm.tcp_position(reference.q[[0, -1]]), task.centre, atol=1e-6)
    [named] = make_references(arm, [Task("p2", task.speed, task.radii, "positions")])
    assert named.duration == reference.duration
    assert not np.allclose(named.q, reference.q, atol=1e-3)


def test_a_round_of_circles_draws_what_the_first_format_drew():
    drawn = Round(seed=5, machines=2, series="draw:", kinds=[CIRCLE])
    assert drawn.commitment == "6db684151a989d603d06a8d432b76858c063706fddffd6d0f92f28aa2564374c"
    assert drawn.plants == ("draw:713012461", "draw:623727154")
    first, *_, last = drawn.draw_motions(AREA)
    assert first == Task("p4 +22.6 -16.4 mm", 0.0546, (0.00116,), "drawn", centre=(1.3226, 0.1836, 0.6))
    assert (last.position, last.speed, last.radii) == ("p3 -24.4 -24.3 mm", 0.0722, (0.00126,))


def test_kinds_of_motions_are_drawn_in_turn_at_the_same_places():
    circles, mixed = (Round(seed=5, kinds=kinds).draw_motions(AREA) for kinds in ((CIRCLE,), KINDS))
    assert [task.kind for task in mixed] == [*KINDS, *KINDS[:2]]
    assert [(t.centre, t.speed, t.position) for t in mixed] == [(t.centre, t.speed, t.position) for t in circles]
    assert {task.split for task in mixed} == {"drawn", "drawn square", "drawn spiral", "drawn tilted"}
    [tilted] = [task for task in mixed if task.kind == TILTED]
    up = np.array(tilted.normal) @ [0, 0, 1]
    assert TILTS[0] <= np.arccos(up) <= TILTS[1]
    assert np.linalg.norm(tilted.normal) == pytest.approx(1.0)
    with pytest.raises(FFGymError, match="Unknown kind of motion 'star'"):
        Round(seed=5, kinds=("star",))
    with pytest.raises(FFGymError, match="kinds of a round are empty"):
        Round(seed=5, kinds=())


@pytest.mark.parametrize("kind", KINDS)
def test_the_duration_of_a_drawn_motion_is_that_of_its_reference(kind):
    arm, [task] = RigidArm(ROBOT), Round(seed=5, motions=1, kinds=(kind,)).draw_motions(AREA)
    [reference] = make_references(arm, [task])
    assert duration_of(arm, task) == reference.duration


@pytest.mark.parametrize(("kind", "spread"), [(SQUARE, 2 * WIDER), (SPIRAL, 1.75 * WIDER), (TILTED, 2.0)])
def test_a_drawn_motion_has_its_size_about_its_centre(kind, spread):
    arm = RigidArm(ROBOT)
    [circle], [task] = (Round(seed=5, motions=1, kinds=(each,)).draw_motions(AREA) for each in (CIRCLE, kind))
    [reference] = make_references(arm, [task])
    away = arm.tcp_position(reference.q) - task.centre
    # the radius of a spiral of two turns is three quarters of the last one half a turn before
    assert np.ptp(away[:, 0]) == pytest.approx(spread * circle.radii[0], rel=0.02)
    assert np.abs(away @ (task.normal or (0, 0, 1))).max() < 1e-6
    assert np.ptp(away[:, 2]) > 1e-4 if kind == TILTED else np.ptp(away[:, 2]) < 1e-6
    speed = np.linalg.norm(np.diff(away, axis=0), axis=1).max() / ROBOT.servo.control_dt
    assert speed == pytest.approx(task.speed, rel=0.01)


def test_corners_of_a_drawn_square_are_rounded_by_a_part_of_half_a_side():
    arm, [task] = RigidArm(ROBOT), Round(seed=5, motions=1, kinds=(SQUARE,)).draw_motions(AREA)
    [reference] = make_references(arm, [task])
    away, [half] = np.abs(arm.tcp_position(reference.q) - task.centre)[:, :2], task.radii
    on_side = np.isclose(away.max(axis=1), half, rtol=0.0, atol=1e-7)
    assert away.min(axis=1)[on_side].max() == pytest.approx((1 - ZONE) * half, rel=0.05)


def test_a_revealed_round_fits_the_hash_that_was_published_before_it(tmp_path):
    drawn = draw_round(machines=2, motions=3)
    published, revealed = (
        written(tmp_path, drawn.list_published()),
        written(tmp_path, drawn.list_revealed(), "revealed.json"),
    )
    assert "seed" not in published.read_text()
    assert drawn.salt not in published.read_text()
    assert read_round(revealed) == drawn
    assert read_commitment(published) == read_commitment(revealed) == drawn.commitment


def test_anyone_computes_the_hash_with_ten_words_of_python(tmp_path):
    tree = draw_round().list_revealed()
    rest = {key: tree[key] for key in ("seed", "salt", "machines", "motions", "series", "kinds")}
    text = json.dumps(rest, sort_keys=True, separators=(",", ":"))
    assert hashlib.sha256(text.encode()).hexdigest() == tree["commitment"]


@pytest.mark.parametrize(
    "change",
    [
        {"seed": 4},
        {"salt": "00"},
        {"machines": 9},
        {"motions": 1},
        {"series": "draw:"},
        {"commitment": "0"},
        {"kinds": ["square"]},
    ],
)
def test_another_round_than_the_committed_one_is_refused(tmp_path, change):
    with pytest.raises(FFGymError, match="not the round that was committed to"):
        read_round(written(tmp_path, draw_round().list_revealed() | change))


@pytest.mark.parametrize(
    ("tree", "message"),
    [
        (draw_round(machines=1).list_published(), "its seed is published after the round"),
        (draw_round(machines=1).list_revealed() | {"seed": "1"}, "is no round"),
        (draw_round(machines=1).list_revealed() | {"seed": -1}, "is no round"),
        (draw_round(machines=1).list_revealed() | {"more": 1}, "is no round"),
        (draw_round(machines=1).list_revealed() | {"format": 3}, "no file of a round of format 1 or 2"),
        (draw_round(machines=1).list_revealed() | {"format": 1}, "Files of format 1 have no kinds"),
        (draw_round(machines=1).list_revealed() | {"kinds": ["circle"]}, "which files of format 1 have"),
        (draw_round(machines=1, kinds=["circle"]).list_revealed() | {"format": 2}, "is no round"),
        ([], "no file of a round"),
    ],
)
def test_what_is_no_revealed_round_is_refused_in_one_line(tmp_path, tree, message):
    with pytest.raises(FFGymError, match=message):
        read_round(written(tmp_path, tree))


def test_a_file_that_is_no_json_is_refused(tmp_path):
    place = tmp_path / "round.json"
    place.write_text("seed = 1")
    with pytest.raises(FFGymError, match="is not valid JSON"):
        read_round(place)
