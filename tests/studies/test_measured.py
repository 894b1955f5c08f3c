"""Published recordings of real machines: found where FFGYM_DATA says, read into the schema."""

import numpy as np
import pytest

from ffgym.errors import FFGymError
from ffgym.studies.measured import measured_folder, read_kr300


def arrays(rows=5):
    t = 0.004 * np.arange(rows)
    joints = np.arange(6) + t[:, None]
    names = ("q_mot_deg", "qd_mot_deg_s", "tau_mot_nm", "q_ref_rad", "qd_ref_rad_s", "qdd_ref_rad_s2")
    return {"t": t} | {name: joints + i for i, name in enumerate(names)}


def write(path, data):
    np.savez(path, **data)
    return path


def test_a_run_becomes_a_recording_in_si_units(tmp_path):
    data = arrays()
    recording = read_kr300(write(tmp_path / "A.npz", data))
    assert recording.header.robot == "kuka_kr300_r2500"
    assert recording.header.segment == "A"
    np.testing.assert_allclose(recording.joint_array("motor.position"), np.radians(data["q_mot_deg"]))
    np.testing.assert_allclose(recording.joint_array("motor.velocity"), np.radians(data["qd_mot_deg_s"]))
    np.testing.assert_array_equal(recording.joint_array("motor.effort"), data["tau_mot_nm"])
    np.testing.assert_array_equal(recording.joint_array("reference.acceleration"), data["qdd_ref_rad_s2"])
    assert recording.header.position_side == "link"
    assert recording.header.torque_semantics == "motor_side"
    assert recording.header.payload == {"mass": 150.0, "com": [0.0, 0.0, 0.1]}


def test_a_file_that_is_none_is_one_error_that_names_it(tmp_path):
    (tmp_path / "text.npz").write_text("no archive", encoding="utf-8")
    short = {name: values for name, values in arrays().items() if name != "tau_mot_nm"}
    narrow = arrays() | {"tau_mot_nm": np.zeros((5, 3))}
    cases = {
        "text.npz": "Cannot read",
        "absent.npz": "Cannot read",
        write(tmp_path / "short.npz", short).name: "tau_mot_nm",
        write(tmp_path / "narrow.npz", narrow).name: "motor.effort .* shape",
    }
    for name, message in cases.items():
        with pytest.raises(FFGymError, match=message):
            read_kr300(tmp_path / name)


@pytest.mark.parametrize("value", [None, "", "/no/such/folder"])
def test_a_missing_folder_is_one_error_that_names_the_variable(value, monkeypatch):
    monkeypatch.delenv("FFGYM_DATA", raising=False)
    if value is not None:
        monkeypatch.setenv("FFGYM_DATA", value)
    with pytest.raises(FFGymError, match="FFGYM_DATA"):
        measured_folder()
