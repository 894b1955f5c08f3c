"""Workcells by name and by seed: what they are, that they stay what they are, and how a day goes by."""

import tomllib
from importlib import resources

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.core.toml import merge_tables
from ffgym.envs.machines import workcell_named
from ffgym.paths import Reference, joint_reference, multisine
from ffgym.robot import ModelOptions, load_robot
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Plant
from ffgym.workcell import INSTANCES, SERIES, draw, workcell
from ffgym.workcell.reading import build, read_tree

COARSE = ModelOptions(looks=False, physics_dt=0.0005)
SEEDS = range(5)


def reference(amplitude=0.01, duration=0.4, like="thesis") -> Reference:
    """All joints swing about the middle of the work area."""
    robot = workcell(like).robot
    return joint_reference(
        robot,
        multisine(
            robot.work_area.home, np.full((1, 6), amplitude), [1.5], np.zeros((1, 6)), duration, ramp=0.2, dwell=0.1
        ),
    )


def recorded(cells, motion):
    return simulate(
        [Run(reference=motion)] * len(cells), machine=[c.machine for c in cells], options=COARSE, n_threads=1
    )


def fingerprint(cell):
    return Plant(cell.machine, 1).fingerprint()


@pytest.mark.parametrize("name", INSTANCES)
def test_a_named_workcell_is_what_its_controller_knows_with_other_physics(name):
    cell = workcell(name)
    assert cell.name == name
    assert cell.title
    controllers = {"thesis_arm": "commissioned_arm", "thesis_drives": "commissioned_arm_drives"}
    known = load_robot(f"irb4600_60_205_{controllers.get(name, 'commissioned')}")
    np.testing.assert_array_equal(cell.robot.friction.coulomb, known.friction.coulomb)
    Plant(cell.machine, 1).check_controller(cell.robot)
    assert cell.machine.effects


def test_named_workcells_and_draws_all_differ():
    cells = [workcell(name) for name in INSTANCES] + [draw(seed, series) for series in SERIES for seed in SEEDS]
    assert len({fingerprint(cell) for cell in cells}) == len(cells)


def test_a_seed_is_one_machine():
    motion = reference()
    first, second = recorded([draw(3), draw(3)], motion)
    assert first.equals(second)
    assert fingerprint(draw(3)) == fingerprint(draw(3))


@pytest.mark.parametrize("series", SERIES)
def test_drawn_machines_follow_their_controller(series):
    motion = reference(like=SERIES[series][0])
    for recording in recorded([draw(seed, series) for seed in SEEDS], motion):
        error = recording.joint_array("reference.position") - recording.joint_array("motor.position")
        assert 1e-4 < np.abs(error).max() < 0.5  # [rad], motor side: where environments stop a robot


def test_machines_of_the_second_series_lose_friction_on_both_sides_and_have_drives_of_their_own():
    cells = [draw(seed, "drives") for seed in SEEDS]
    Plant(cells[0].machine, len(cells)).become(range(len(cells)), [cell.machine for cell in cells])  # one batch
    shares = np.array([cell.machine.robot.friction.arm_share for cell in cells])
    delays = np.array([cell.machine.robot.drive.torque_delay for cell in cells])
    assert np.all((shares[:, :3] >= 0.2) & (shares[:, :3] <= 0.9))
    assert np.all(shares[:, 3:] == 0)
    assert np.all((delays >= 2.5e-4) & (delays <= 1e-3))
    assert len(np.unique(delays)) == delays.size
    assert all(cell.machine.robot.drive.resolver_period > 0 for cell in cells)


def test_measurements_are_the_same_in_every_program_run_and_differ_by_seed():
    cell, motion = workcell("thesis"), reference(duration=0.4)
    first, again, other = (cell.run([Run(reference=motion)], seed=seed, n_threads=1)[0] for seed in (1, 1, 2))
    assert first.equals(again)
    assert not first.equals(other)


def test_a_machine_warms_up_over_the_day_and_turns_more_easily():
    cell, motion = workcell("cold"), reference(amplitude=0.02)
    cells = [cell.at(since) for since in (0.0, 1200.0, 14400.0)]
    recordings = recorded(cells, motion)
    temperature = [recording.joint_array("temperature").mean(axis=0) for recording in recordings]
    assert np.all(np.diff(temperature, axis=0) > 1.0)
    speed = np.abs(recordings[0].joint_array("motor.velocity"))
    fast = speed > 0.8 * speed.max(axis=0)
    for joint in range(cell.robot.n_joints):
        rows = fast[:, joint]
        work = [
            np.sum((r.joint_array("motor.effort") * r.joint_array("motor.velocity"))[rows, joint]) for r in recordings
        ]
        assert work[0] > work[1] > work[2]


def test_a_file_that_is_like_another_changes_what_it_names():
    base = {"a": {"x": {"value": 1, "unit": "m"}, "y": {"value": 2, "unit": "m"}}}
    assert merge_tables(base, {"a": {"x": {"value": 3, "unit": "m"}}}) == {
        "a": {"x": {"value": 3, "unit": "m"}, "y": {"value": 2, "unit": "m"}}
    }


@pytest.mark.parametrize("name", INSTANCES)
def test_every_number_of_a_file_says_where_it_comes_from(name):
    text = (resources.files("ffgym.workcell") / "data" / f"{name}.toml").read_text(encoding="utf-8")

    def sources(tree):
        for value in tree.values():
            if isinstance(value, dict):
                yield from [value["source"]] if "value" in value else sources(value)

    found = list(sources(tomllib.loads(text)))
    assert found or name == "thesis_drives"  # which takes all numbers from other files
    words = ("sourced:", "derived:", "chosen:", "calibrated:", "scripts/calibrate_workcell.py:", "the nominal robot's:")
    assert all(source.startswith(words) for source in found)


def test_every_workcell_file_has_a_name():
    files = {f.name for f in (resources.files("ffgym.workcell") / "data").iterdir()}
    assert files == {f"{name}.toml" for name in INSTANCES}


def test_refusals_name_what_is_there():
    with pytest.raises(FFGymError, match="thesis"):
        workcell("monday")
    with pytest.raises(FFGymError, match="seed"):
        draw(-1)
    with pytest.raises(FFGymError, match="series 'old'"):
        draw(1, "old")
    assert workcell_named("workcell:drives-3").name == "drives-3"
    for name in ("workcell:drives-x", "workcell:-3", "workcell:old-3"):
        with pytest.raises(FFGymError, match="drives-<seed>"):
            workcell_named(name)
    tree = read_tree("thesis")
    with pytest.raises(FFGymError, match=r"Workcell broken: climate.ambient"):
        build("broken", tree | {"climate": {"ambient": {"value": 22.0, "unit": "K", "source": "?"}}})
