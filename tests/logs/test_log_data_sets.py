"""Column maps of published data sets, on arrays of their layout and, where they are, on the data themselves."""

import os
from pathlib import Path

import numpy as np
import pytest

from ffgym.logs import builtin_columns, read_log, read_logs
from ffgym.robot import load_robot

needs_data = pytest.mark.skipif(
    not os.environ.get("FFGYM_DATA"), reason="set FFGYM_DATA to the folder with the published recordings"
)


def kr300_arrays(rows=5):
    t = 0.004 * np.arange(rows)
    joints = np.arange(6) + t[:, None]
    names = ("q_mot_deg", "qd_mot_deg_s", "tau_mot_nm", "q_ref_rad", "qd_ref_rad_s", "qdd_ref_rad_s2")
    return {"t": t} | {name: joints + i for i, name in enumerate(names)}


def test_a_run_of_the_kr300_is_in_si_units_behind_the_gearbox(tmp_path):
    data = kr300_arrays() | {"q_se_deg": np.ones((5, 3))}
    np.savez(tmp_path / "A.npz", **data)
    recording = read_log(tmp_path / "A.npz", "kuka_kr300_2020")
    header = recording.header
    assert (header.robot, header.segment) == ("kuka_kr300_r2500", "A")
    assert (header.position_side, header.torque_semantics, header.hold) == ("link", "motor_side", "sampled")
    assert header.payload == {"mass": 150.0, "com": [0.0, 0.0, 0.1]}
    np.testing.assert_array_equal(recording.joint_array("motor.position"), data["q_mot_deg"] * (np.pi / 180))
    np.testing.assert_array_equal(recording.joint_array("motor.velocity"), data["qd_mot_deg_s"] * (np.pi / 180))
    np.testing.assert_array_equal(recording.joint_array("motor.effort"), data["tau_mot_nm"])
    np.testing.assert_array_equal(recording.joint_array("reference.acceleration"), data["qdd_ref_rad_s2"])
    assert recording.unit("link.position.a3") == "rad"
    assert np.isnan(recording.joint_array("link.position")[:, 3:]).all()
    assert header.provenance["left_out"] == [*(f"link.velocity.a{i}" for i in (1, 2, 3)), "user.controller_feedforward"]


@needs_data
@pytest.mark.parametrize("run", ["A", "C"])
def test_the_runs_of_the_kr300_are_read_to_the_bit(run):
    path = Path(os.environ["FFGYM_DATA"]) / "kuka_kr300_2020" / f"{run}.npz"
    recording = read_log(path, "kuka_kr300_2020")
    with np.load(path) as data:
        assert recording.joint_array("motor.position").tobytes() == (data["q_mot_deg"] * (np.pi / 180)).tobytes()
        assert recording.joint_array("motor.effort").tobytes() == data["tau_mot_nm"].tobytes()
    assert len(recording) == 2501
    low, high = load_robot("kuka_kr300_r2500").kinematics.range.T
    q = recording.joint_array("motor.position")
    assert np.all((low < q) & (q < high))


@needs_data
def test_the_hours_of_the_kr300_are_motions_of_their_own():
    path = Path(os.environ["FFGYM_DATA"]) / "kuka_kr300_2021_10hz" / "recordings.npz"
    recordings = read_logs(path, "kuka_kr300_2021_10hz")
    assert len(recordings) == 10
    assert recordings[0].header.meta == {"start_time": "20:29", "session_start": 0.0}
    assert recordings[4].header.meta == {"start_time": "21:32", "session_start": 3780.0}
    assert recordings[0].header.payload is None
    with np.load(path) as data:
        for i, recording in enumerate(recordings):
            assert recording.joint_array("motor.effort").tobytes() == data["tau_mot_nm"][i].tobytes()
            np.testing.assert_allclose(recording.dt, 0.1)


@needs_data
@pytest.mark.parametrize(("run", "pulses"), [("emps_id", False), ("emps_pulses", True)])
def test_the_force_of_the_ball_screw_is_its_voltage_times_the_gain_of_its_drive(run, pulses):
    path = Path(os.environ["FFGYM_DATA"]) / "emps" / f"{run}.npz"
    recording = read_log(path, "emps")
    with np.load(path) as data:
        assert recording["motor.effort.x"].tobytes() == (data["vir"] * data["gtau"]).tobytes()
        assert recording["motor.position.x"].tobytes() == data["qm"].tobytes()
        assert recording.header.meta["kp_per_s"] == data["kp"]
    assert recording.has("user.pulse") is pulses
    assert recording.header.torque_semantics == "link_side"


def test_the_three_data_sets_have_maps():
    assert {"emps", "kuka_kr300_2020", "kuka_kr300_2021_10hz"} <= set(builtin_columns())
