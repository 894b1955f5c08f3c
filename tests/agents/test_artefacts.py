import json
import re
import shutil
from dataclasses import replace

import pytest

from ffgym.agents import entrants
from ffgym.agents.adapters import ADAPTERS
from ffgym.agents.artefacts import TRAINED, add_artefacts, locate_artefact, read_manifest
from ffgym.agents.catalogue import list_entries
from ffgym.agents.entrants import ENTRANTS
from ffgym.agents.residual.gains import GAINS, SERVO_GAINS
from ffgym.core.errors import FFGymError
from ffgym.leaderboard.plants import NOMINAL, find_plant
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation import SimulatedRig

NAMES = sorted(path.parent.name for path in TRAINED.glob("*/manifest.json"))


@pytest.fixture
def copied(tmp_path):
    """Artefacts of one agent in a folder that may be damaged."""
    shutil.copytree(TRAINED / "bsn_static", tmp_path / "bsn_static")
    read_manifest.cache_clear()
    yield tmp_path
    read_manifest.cache_clear()


@pytest.mark.parametrize("name", NAMES)
def test_every_file_is_what_its_manifest_says_and_no_other_file_lies_beside(name):
    manifest = read_manifest(name)
    files = {locate_artefact(name, artefact).relative_to(TRAINED / name).as_posix() for artefact in manifest.artefacts}
    there = {path.relative_to(TRAINED / name).as_posix() for path in (TRAINED / name).rglob("*") if path.is_file()}
    assert there == files | {"manifest.json"}


@pytest.mark.parametrize("name", NAMES)
def test_it_was_trained_on_the_physics_of_today_with_five_seeds_for_each_plant(name):
    manifest = read_manifest(name)
    adapters = {adapter.name for adapter in ADAPTERS}
    assert name in ENTRANTS or name in adapters
    # machines that adapters have learned of are drawn about the robot of workcells of the second series
    known = find_plant(NOMINAL).fingerprint
    robot = re.search(r"--robot (\w+)", manifest.command)
    if robot or name in adapters:
        about = robot[1] if robot else "irb4600_60_205_commissioned_arm_drives"
        known = SimulatedRig(arm=RigidArm(load_robot(about))).fingerprint
    seeds = [0] if name in GAINS else [0, 1, 2, 3, 4]  # which a seed does not change
    for plant in {artefact.plant for artefact in manifest.artefacts}:
        own = [artefact for artefact in manifest.artefacts if artefact.plant == plant]
        assert [artefact.seed for artefact in own] == seeds
        physics = known if plant == "any" else find_plant(plant).fingerprint
        assert {artefact.fingerprint for artefact in own} == {physics}
        assert len({artefact.sha256 for artefact in own}) == len(seeds)


def test_an_agent_that_is_declared_in_the_wrong_track_is_refused():
    manifest = read_manifest(SERVO_GAINS)
    wrong = replace(next(entry for entry in list_entries() if entry.name == SERVO_GAINS), feedback=False)
    with pytest.raises(FFGymError, match="declared with feedback=False"):
        entrants._read(wrong, manifest, find_plant(NOMINAL), 0, ())


def test_a_changed_file_is_refused(copied):
    artefact = read_manifest("bsn_static", copied).artefacts[0]
    place = copied / "bsn_static" / artefact.file
    place.write_bytes(place.read_bytes()[:-1] + b"?")
    with pytest.raises(FFGymError, match="its manifest says"):
        locate_artefact("bsn_static", artefact, copied)


def test_a_missing_file_is_told(copied):
    artefact = read_manifest("bsn_static", copied).artefacts[0]
    (copied / "bsn_static" / artefact.file).unlink()
    with pytest.raises(FFGymError, match="no such file"):
        locate_artefact("bsn_static", artefact, copied)


@pytest.mark.parametrize("damage", ["{", "[]", '{"artefacts": []}', '{"artefacts": [{}], "learning_curve": []}'])
def test_a_damaged_manifest_is_told(copied, damage):
    (copied / "bsn_static" / "manifest.json").write_text(damage)
    with pytest.raises(FFGymError, match="is no manifest of trained agents"):
        read_manifest("bsn_static", copied)


def test_a_manifest_with_an_unknown_entry_is_told(copied):
    place = copied / "bsn_static" / "manifest.json"
    place.write_text(json.dumps(json.loads(place.read_text()) | {"more": 1}))
    with pytest.raises(FFGymError, match="more"):
        read_manifest("bsn_static", copied)


def test_new_artefacts_take_the_place_of_old_ones(copied):
    old = read_manifest("bsn_static").artefacts
    new = [replace(each, env_steps=1) for each in old[:2]]
    add_artefacts("bsn_static", "again", new, copied)
    found = read_manifest("bsn_static", copied)
    assert found.command == "again"
    assert found.artefacts == tuple(sorted([*new, *old[2:]], key=lambda each: (each.plant, each.seed)))


def test_what_was_never_trained_has_no_manifest():
    assert read_manifest("nothing") is None


def test_on_drawn_robots_an_agent_is_what_it_learned_on_the_nominal_one():
    learned, fitted = ENTRANTS["bsn_static"], ENTRANTS["model_fitted"]
    plant = find_plant("draw:0")
    [ready] = learned.ready(plant, [2], ())
    assert ready.artefact == learned.artefact("draw:0", 2) == learned.artefact(NOMINAL, 2)
    assert ready.artefact != learned.artefact("workcell:thesis", 2)
    assert ready.robot_seconds > 100
    assert fitted.ready(plant, [0], ()) == [None]  # it knows the workcell alone
