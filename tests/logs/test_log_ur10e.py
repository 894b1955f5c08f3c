"""The UR10e as a user brings it: files without titles, packed, currents, its URDF, and two tables about its drives."""

import gzip

import numpy as np
import pytest

from ffgym.cli.main import main
from ffgym.logs import load_columns, read_log
from ffgym.robot import load_draft
from tests.ur10e_samples import COLUMNS, DRIVES, FOLDER, PER_CURRENT, SPEEDS, needs_data

pytestmark = needs_data


@pytest.fixture(scope="module")
def user(tmp_path_factory):
    """Folder with what a user writes: a description begun by `ffgym robot new`, and a column map."""
    folder = tmp_path_factory.mktemp("ur10e")
    robot = folder / "arm.toml"
    assert main(["robot", "new", str(FOLDER / "ur10e.urdf"), "--no-looks", "--out", str(robot)]) == 0
    robot.write_text(robot.read_text(encoding="utf-8") + DRIVES, encoding="utf-8")
    (folder / "map.toml").write_text(COLUMNS + SPEEDS, encoding="utf-8")
    return folder


def test_its_urdf_and_two_tables_are_enough_for_a_fit(user):
    draft = load_draft(user / "arm.toml")
    assert not draft.lacks("identification")
    np.testing.assert_allclose(draft.quantities["kinematics.max_speed"].value[0], 3.14)


def test_its_files_are_read_as_they_were_recorded(user):
    path = FOLDER / "ur-20_02_05-20sec_8harm.csv.gz"
    recording = read_log(path, load_columns(user / "map.toml"), robot=str(user / "arm.toml"))
    with gzip.open(path) as file:
        table = np.loadtxt(file, delimiter=",")
    np.testing.assert_array_equal(recording.joint_array("motor.position"), table[:, 1:7])
    np.testing.assert_allclose(recording.joint_array("motor.effort"), table[:, 13:19] * PER_CURRENT)
    assert recording.header.segment == "ur-20_02_05-20sec_8harm"
    ran = np.gradient(recording.joint_array("motor.position"), recording.t - recording.t[0], axis=0)
    told = recording.joint_array("motor.velocity")
    assert np.corrcoef(ran[::5, 0], told[::5, 0])[0, 1] > 0.99


@pytest.mark.parametrize("needs", ["position", "torque"])
def test_it_is_judged_although_its_description_lacks_most(user, needs, capsys):
    path = FOLDER / "ur-20_02_05-20sec_8harm.csv.gz"
    command = ["log", "check", str(path), "--robot", str(user / "arm.toml"), "--columns", str(user / "map.toml")]
    main([*command, "--needs", needs])
    printed = capsys.readouterr()
    assert "nothing is judged that hangs on masses" in printed.out
    assert f"{path}: " in printed.out
