"""A UR10e as its users recorded it, by the plain commands of the documentation: URDF and raw files to a written model.

What must be named, and what must not, and the figures are those of its provenance. They need FFGYM_DATA.
"""

import shutil

import pytest

from ffgym.cli.main import main
from ffgym.diagnosis.diagnosis_file import read_diagnosis
from ffgym.diagnosis.held_out import compare_replays
from ffgym.logs import read_log
from ffgym.logs.quality import condition
from ffgym.robot import load_draft
from ffgym.simulation.plant import load_machine
from tests.ur10e_samples import COLUMNS, DRIVES, FOLDER, needs_data

JOINTS = ("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint")

FITTED = (
    *("20_02_05-20sec_12harm", "20_02_05-20sec_8harm", "20_02_06-20sec_10harm", "20_02_06-20sec_5harm"),
    *("20_02_10-20sec_7harm", "20_02_10-30sec_12harm", "20_02_12-50sec_12harm"),
)
HELD_OUT = ("20_02_12-40sec_12harm", "20_02_19_14harm50sec")


def files(*names):
    return [str(next(FOLDER.glob(f"ur-{name}.csv*"))) for name in names]


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """The folder that the commands wrote."""
    folder = tmp_path_factory.mktemp("ur10e")
    shutil.copy(FOLDER / "ur10e.urdf", folder)
    robot, columns, out = folder / "ur10e.toml", folder / "columns.toml", folder / "found"
    assert main(["robot", "new", str(folder / "ur10e.urdf"), "--no-looks", "--out", str(robot)]) == 0
    robot.write_text(robot.read_text(encoding="utf-8") + DRIVES, encoding="utf-8")
    columns.write_text(COLUMNS, encoding="utf-8")
    command = ["diagnose", *files(*FITTED), "--robot", str(robot), "--columns", str(columns), "--fit"]
    assert main([*command, "--validate", *files(*HELD_OUT), "--out", str(out)]) == 0
    return folder


@needs_data
def test_losses_that_grow_with_load_and_friction_that_bends_are_named_and_no_flexible_mode(found):
    diagnosis = read_diagnosis(found / "found" / "diagnosis.json")
    causes = {(cause.effect, cause.joint): cause for cause in diagnosis.causes}
    assert diagnosis.verdict in ("named", "partly")
    for joint, share in (("shoulder_lift_joint", 0.065), ("elbow_joint", 0.070)):
        (size,) = causes["load_friction", joint].parameters
        assert size.value == pytest.approx(share, abs=0.015)
        assert size.interval[0] < share < size.interval[1]
    (bend,) = causes["nonlinear_viscous", "shoulder_pan_joint"].parameters
    assert bend.interval[1] < 0.0  # grows less than linearly
    effects = {effect for effect, _ in causes}
    assert not effects & {"flexible_load", "base_flexibility", "asymmetry", "coulomb_drift"}
    assert ("load_friction", "wrist_3_joint") not in causes
    assert not [drift for drift in diagnosis.drifts if drift.effect == "coulomb_level"]


@needs_data
def test_the_extended_model_as_it_is_written_foretells_recordings_that_were_left_out(found):
    """Read from its file again, at 5 Hz: 3.14 N m of joint 2 and 1.35 N m of joint 3 before, by plain least squares."""
    robot = load_draft(found / "ur10e.toml").description_for("identification")
    read = [condition(read_log(file, found / "columns.toml", robot=robot)) for file in files(*HELD_OUT)]
    models = [load_machine(found / "found" / name, partial=True) for name in ("nominal.toml", "extended.toml")]
    levels = {level.component: level for level in compare_replays(*models, read, cutoff=5.0)}
    assert levels["shoulder_pan_joint"].after < 0.8 * levels["shoulder_pan_joint"].before
    assert levels["shoulder_lift_joint"].after <= 1.7 < 2.5 < levels["shoulder_lift_joint"].before
    assert levels["elbow_joint"].after <= 0.85 < 1.1 < levels["elbow_joint"].before
    for joint in JOINTS:
        assert levels[joint].after < 1.02 * levels[joint].before


@needs_data
@pytest.mark.slow
def test_a_payload_that_the_model_does_not_know_is_named_against_the_model_of_before(found, tmp_path):
    extended, columns = str(found / "found" / "extended.toml"), str(found / "columns.toml")
    command = ["diagnose", *files("20_01_31-load"), "--robot", extended, "--columns", columns]
    assert main([*command, "--calibration", "0.05", "--out", str(tmp_path)]) == 0
    diagnosis = read_diagnosis(tmp_path / "diagnosis.json")
    payload = next(cause for cause in diagnosis.causes if cause.effect == "payload")
    mass = next(size for size in payload.parameters if size.name == "mass")
    assert mass.value == pytest.approx(2.805, rel=0.3)  # torque per current is known no better than that
    assert payload.held_out_gain > 0.9
