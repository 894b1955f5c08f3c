"""The cycle of record, diagnose and extend, with a diagnosis that knows the answers; what that is worth in control."""

import json
import shutil
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.result import Diagnosis, SeparatingMotion
from ffgym.effects import EFFECTS
from ffgym.improvement import Plan, format_improvement, improve, render_improvement
from ffgym.improvement.gain import BASELINE, MODEL
from ffgym.improvement.rounds import improve_in_rounds
from ffgym.robot import RigidArm
from ffgym.simulation import SimulatedRig, sensors_of
from ffgym.simulation.plant import Machine, load_machine
from tests.diagnosis.test_extended import cause

SHORT = '[[step]]\nprotocol = "table_6_1"\nrecords = [14]\nleast = 0.3\njoints = ["j1"]\n'
"""A protocol of one motion that takes a second."""
MORE = SHORT.replace("14", "13")
"""What a diagnosis proposes."""
FOUND = (
    [cause("load_friction", "j2", share=0.1), cause("coulomb_level", "j1", change=0.3)],
    [cause("wrist_coupling", "j5", share=0.2)],
    [],
)
"""What is found, round by round."""


@contextmanager
def quiet(title, unit):
    yield lambda done, total: None


class Knowing:
    """A diagnosis that knows what the machine has, and finds some of it in each round."""

    def __init__(self, found=FOUND):
        self.found, self.asked = found, []

    def __call__(self, machine, recordings, prior, most):
        causes = tuple(self.found[len(machine.effects) and (1 if len(machine.effects) == 2 else 2)])
        self.asked.append([recording.header.segment for recording in recordings])
        proposed = SeparatingMotion(between=("a", "b"), protocol="table_6_1", toml=MORE, expected=1.0)
        return Diagnosis(
            verdict="named" if causes else "none",
            sentence="As asked.",
            robot=machine.robot.name,
            motions=tuple(recording.header.segment for recording in recordings),
            causes=causes,
            separating_motion=proposed if len(causes) == 1 else None,
        )


@pytest.fixture(scope="module")
def rig(arm):
    effects = (
        EFFECTS["load_friction"].on(arm.robot, "j2", share=0.1),
        EFFECTS["coulomb_level"].on(arm.robot, "j1", change=0.3),
        EFFECTS["wrist_coupling"].on(arm.robot, share=0.2 * np.outer(np.eye(6)[4], np.eye(6)[5])),
    )
    machine = Machine(robot=arm.robot, effects=effects)
    return SimulatedRig(arm=arm, machine=machine, sensors=sensors_of(arm.robot), name="cell")


@pytest.fixture(scope="module")
def plan(arm, tmp_path_factory):
    protocol = tmp_path_factory.mktemp("protocol") / "short.toml"
    protocol.write_text(SHORT, encoding="utf-8")
    return Plan(nominal=Machine(robot=arm.robot), robot=arm.robot.name, protocols=(str(protocol),), n_threads=1)


def run(rig, plan, folder, diagnose):
    circle = {"positions": ["p2"], "speeds": [0.1], "radii": [0.001]}
    return improve(rig, plan, folder, diagnose=diagnose, stage=quiet, **circle)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("improved")


@pytest.fixture(scope="module")
def improvement(rig, plan, folder):
    return run(rig, plan, folder, Knowing())


def test_rounds_go_on_until_nothing_is_found(improvement, rig):
    assert [len(each.diagnosis.causes) for each in improvement.rounds] == [2, 1, 0]
    assert improvement.ended == "the last recordings do not falsify the model"
    last = load_machine(improvement.rounds[-1].model)
    assert {effect.name for effect in last.effects} == {effect.name for effect in rig.machine.effects}


def test_the_next_round_records_what_was_proposed_too(improvement):
    motions = [len(each.diagnosis.motions) for each in improvement.rounds]
    assert motions == [1, 1, 2]
    assert (improvement.rounds[1].logs.parent / "next.toml").read_text(encoding="utf-8") == MORE


def test_feed_forward_from_the_extended_model_is_better_on_the_machine_round_by_round(improvement):
    error = {score.law: score.rms_um for score in improvement.gain.scores}
    assert error[MODEL] < error[f"{MODEL}_1"] < error["elastic"] < error[BASELINE]
    last = next(score for score in improvement.gain.scores if score.law == MODEL)
    assert last.against == pytest.approx(1 - error[MODEL] / error[BASELINE])
    assert (last.better_on, last.circles) == (1, 1)


def test_what_is_complete_is_not_made_again(improvement, rig, plan, folder):
    before = {file: file.stat().st_mtime_ns for file in folder.rglob("*.npz")}
    again = Knowing()
    repeated = improve_in_rounds(rig, plan, folder, again, quiet)
    assert again.asked == []
    assert {file: file.stat().st_mtime_ns for file in folder.rglob("*.npz")} == before
    assert [each.diagnosis for each in repeated] == [each.diagnosis for each in improvement.rounds]


def test_what_a_killed_process_left_half_written_in_a_round_goes(improvement, rig, plan, folder, tmp_path):
    copy = shutil.copytree(folder, tmp_path / "copy")
    for place in (copy / "round_1", copy / "round_1" / "logs", copy / "round_2"):
        (place / ".ffgym-0.tmp").touch()
    improve_in_rounds(rig, plan, copy, Knowing(), quiet)
    assert not list(copy.rglob(".ffgym-*"))


def test_a_diagnosis_of_another_model_is_made_again(improvement, rig, plan, folder, tmp_path):
    copy = shutil.copytree(folder, tmp_path / "copy")
    known = replace(plan.nominal, effects=(EFFECTS["torque_offset"].on(rig.robot, offset=0.01),))
    again = Knowing(found=([], [], []))
    (only,) = improve_in_rounds(rig, replace(plan, nominal=known, rounds=1), copy, again, quiet)
    assert only.diagnosis.verdict == "none"
    assert len(again.asked) == 1


def test_a_diagnosis_that_looked_for_fewer_causes_is_made_again(improvement, rig, plan, folder, tmp_path):
    copy = shutil.copytree(folder, tmp_path / "copy")
    again = Knowing()
    improve_in_rounds(rig, replace(plan, most_causes=5, rounds=1), copy, again, quiet)
    assert len(again.asked) == 1


def test_numbers_text_and_page_tell_of_all_laws_and_rounds(improvement):
    document = json.loads(json.dumps(improvement.document()))
    assert len(document["rounds"]) == 3
    assert document["rounds"][0]["diagnosis"]["causes"][0]["effect"] == "load_friction"
    text = format_improvement(improvement)
    assert max(len(line) for line in text.splitlines()) <= 120
    pytest.importorskip("jinja2")
    page = render_improvement(improvement, {"seed": 0})
    for score in improvement.gain.scores:
        assert score.title in text
        assert score.title in page
        assert f"{score.rms_um:.1f}" in page


def test_robots_without_circles_are_refused_before_anything_is_recorded(one_axis, plan, tmp_path):
    rig = SimulatedRig(arm=RigidArm(one_axis))
    with pytest.raises(FFGymError, match="no work area with two positions"):
        improve(rig, replace(plan, nominal=Machine(robot=one_axis)), tmp_path, diagnose=Knowing(), stage=quiet)
    assert list(tmp_path.iterdir()) == []


def test_a_plan_without_rounds_or_protocols_is_none(plan):
    with pytest.raises(FFGymError, match="rounds"):
        replace(plan, rounds=0)
    with pytest.raises(FFGymError, match="most causes"):
        replace(plan, most_causes=0)
    with pytest.raises(FFGymError, match="nothing to record"):
        replace(plan, protocols=())
