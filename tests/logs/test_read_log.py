"""A file of another tool becomes a recording as its column map says."""

import hashlib
import json

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from log_samples import CLOCK, LOG, N_ROWS, POSITION, RATIOS, arrays, column_map, refused, write_npz

from ffgym.logs import read_log, read_logs
from ffgym.recordings import write_recording
from ffgym.robot import load_robot


def effort(extra: str, source: str = '"u"') -> str:
    return f'[columns."motor.effort"]\nsource = {source}\n{extra}\n'


def test_numbers_in_si_units_are_taken_to_the_bit(tmp_path):
    path = write_npz(tmp_path)
    recording = read_log(path, column_map(CLOCK, POSITION, effort('unit = "N m"')))
    data = arrays()
    assert recording["timestamp"].tobytes() == data["t"].tobytes()
    assert recording.joint_array("motor.position").tobytes() == data["q"].tobytes()
    assert recording.joint_array("motor.effort").tobytes() == data["u"].tobytes()
    header = recording.header
    assert (header.robot, header.joints, header.segment) == ("press", ("upper", "lower"), "run")
    assert (header.torque_semantics, header.hold) == ("motor_side", "unspecified")
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    assert header.provenance == {"file": "run.npz", "sha256": digest, "columns": "map.toml"}


@given(
    scale=st.floats(-1e3, 1e3).filter(lambda x: abs(x) > 1e-3),
    offset=st.floats(-1e3, 1e3),
    signs=st.lists(st.sampled_from([-1, 1]), min_size=2, max_size=2),
)
@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_scale_offset_unit_and_sign_apply_in_that_order(scale, offset, signs, tmp_path):
    entry = effort(f'unit = "mN m"\nscale = {scale}\noffset = {offset}\nsign = {signs}')
    recording = read_log(write_npz(tmp_path), column_map(CLOCK, POSITION, entry))
    expected = np.array(signs) * (scale * arrays()["u"] + offset) / 1000
    np.testing.assert_allclose(recording.joint_array("motor.effort"), expected, rtol=1e-12, atol=1e-12)


def test_a_gain_may_come_from_another_array(tmp_path):
    path = write_npz(tmp_path, gain=np.array(35.15), gains=np.array([[2.0, 3.0]]))
    for name, gain in (("gain", 35.15), ("gains", np.array([2.0, 3.0]))):
        recording = read_log(path, column_map(CLOCK, POSITION, effort(f'unit = "N m"\nscale = "{name}"')))
        np.testing.assert_array_equal(recording.joint_array("motor.effort"), arrays()["u"] * gain)
    with refused("motor.effort", "scale: the array 't' has 7 numbers, must be one, or 2"):
        read_log(path, column_map(CLOCK, POSITION, effort('unit = "N m"\nscale = "t"')))
    with refused("motor.effort", "scale = [0.42, 0.0] must not be zero"):
        read_log(path, column_map(CLOCK, POSITION, effort('unit = "N m"\nscale = [0.42, 0.0]')))
    with refused("'motor.effort.", "is inf, must be finite"):
        read_log(path, column_map(CLOCK, POSITION, effort('unit = "N m"\nscale = 1e308\noffset = 1e308')))


@pytest.mark.parametrize(
    ("source", "stored"),
    [
        ('["a", "b"]', {"a": arrays()["q"][:, 0], "b": arrays()["q"][:, 1]}),
        ('"q_{joint}"', {"q_upper": arrays()["q"][:, 0], "q_lower": arrays()["q"][:, 1]}),
        ('"q{number}"', {"q1": arrays()["q"][:, 0], "q2": arrays()["q"][:, 1]}),
        ('"x"\naxes = ["part", "time"]', {"x": arrays()["q"].T}),
        ('"x"\npick = [1, 3]', {"x": arrays()["q"][:, [1, 0, 0, 1]]}),
        ('"x"\naxes = ["part", "time"]\npick = [2, 0]', {"x": arrays()["q"].T[[1, 1, 0]]}),
    ],
)
def test_numbers_of_the_joints_may_lie_in_many_ways(source, stored, tmp_path):
    entry = f'[columns."motor.position"]\nsource = {source}\nunit = "rad"'
    recording = read_log(write_npz(tmp_path, q=None, **stored), column_map(CLOCK, entry))
    np.testing.assert_array_equal(recording.joint_array("motor.position"), arrays()["q"])


def test_one_joint_may_have_an_entry_of_its_own(tmp_path):
    entries = [
        '[columns."motor.position.upper"]\nsource = "q"\npick = [0]\nunit = "deg"',
        '[columns."motor.position.lower"]\nsource = "q"\npick = [1]\nunit = "rad"',
    ]
    recording = read_log(write_npz(tmp_path), column_map(CLOCK, *entries))
    expected = arrays()["q"] * [np.pi / 180, 1.0]
    np.testing.assert_array_equal(recording.joint_array("motor.position"), expected)
    with refused("motor.position is incomplete: motor.position.lower missing"):
        read_log(write_npz(tmp_path), column_map(CLOCK, entries[0]))


@pytest.mark.parametrize("coupling", [None, [[0.0, 2.0], [-3.0, 0.0]]])
def test_numbers_of_the_other_side_of_the_gearbox_are_converted_without_loss_of_power(coupling, tmp_path):
    log = LOG + (f"coupling = {coupling}\n" if coupling else "")
    matrix = np.diag(RATIOS) + (0 if coupling is None else np.array(coupling))
    speed = '[columns."motor.velocity"]\nsource = "q"\nunit = "rad/s"\nside = "link"'
    recording = read_log(write_npz(tmp_path), column_map(CLOCK, speed, effort('unit = "N m"\nside = "link"'), log=log))
    dq, torque = arrays()["q"], arrays()["u"]
    motor_dq, motor_torque = recording.joint_array("motor.velocity"), recording.joint_array("motor.effort")
    np.testing.assert_allclose(motor_dq, dq @ matrix.T)
    np.testing.assert_allclose(np.sum(motor_dq * motor_torque, axis=1), np.sum(dq * torque, axis=1))


def test_motor_numbers_are_divided_where_the_recording_keeps_the_link_side(tmp_path):
    log = LOG.replace('position_side = "motor"', 'position_side = "link"')
    position = POSITION + 'side = "motor"\n'
    recording = read_log(write_npz(tmp_path), column_map(CLOCK, position, log=log))
    np.testing.assert_allclose(recording.joint_array("motor.position"), arrays()["q"] / RATIOS)


def test_a_sliding_joint_is_in_metres_behind_its_gearbox_only(tmp_path):
    q = arrays()["q"][:, 0]
    log = '[log]\nrobot = "ball_screw"\n'
    column = '[columns."motor.position"]\nsource = "x"\nunit = "mm"\n'
    path = write_npz(tmp_path, x=q)
    recording = read_log(path, column_map(CLOCK, column, log=log))
    np.testing.assert_allclose(recording["motor.position.x"], q / 1000)
    with refused("motor.position", "unit 'mm' does not fit a quantity in rad, must be 'rad', 'deg'"):
        read_log(path, column_map(CLOCK, column + 'side = "motor"', log=log))


def test_columns_of_ones_own_keep_their_si_unit(tmp_path):
    entry = '[columns."user.scales"]\nsource = "q"\nparts = ["a", "b"]\nunit = "deg"\n'
    pressure = '[columns."user.pressure"]\nsource = "t"\nunit = "bar"\n'
    recording = read_log(write_npz(tmp_path), column_map(CLOCK, POSITION, entry, pressure))
    assert recording.header.units == {"user.scales.a": "rad", "user.scales.b": "rad", "user.pressure": "bar"}
    np.testing.assert_array_equal(recording["user.scales.b"], np.radians(arrays()["q"][:, 1]))


def test_a_time_series_of_mujocos_system_identification_is_split_by_signal(tmp_path):
    data = np.column_stack([arrays()["u"], arrays()["q"]])
    mapping = json.dumps({"torque": [0, [0, 1]], "upper_qpos": [2, [2]], "lower_qpos": [2, [3]]})
    np.savez(tmp_path / "series.npz", times=arrays()["t"], data=data, signal_mapping=np.array(mapping))
    clock = CLOCK.replace('"t"', '"times"')
    position = POSITION.replace('"q"', '"{joint}_qpos"')
    recording = read_log(tmp_path / "series.npz", column_map(clock, position, effort('unit = "N m"', '"torque"')))
    np.testing.assert_array_equal(recording.joint_array("motor.position"), arrays()["q"])
    np.testing.assert_array_equal(recording.joint_array("motor.effort"), arrays()["u"])
    for wrong in ("[", '{"a": [0, [9]]}', "[1]"):
        np.savez(tmp_path / "series.npz", times=arrays()["t"], data=data, signal_mapping=np.array(wrong))
        with refused("series.npz: signal_mapping does not fit data (7, 4)"):
            read_log(tmp_path / "series.npz", column_map(clock, position))


def test_the_map_may_name_the_motion_and_its_payload(tmp_path):
    log = LOG + 'segment = "sweep"\npayload = { mass = 2.5 }\nfilters = ["50 Hz"]\n'
    header = read_log(write_npz(tmp_path), column_map(CLOCK, POSITION, log=log)).header
    assert (header.segment, header.payload, header.filters) == ("sweep", {"mass": 2.5}, ("50 Hz",))


def test_what_is_optional_and_absent_is_left_out_and_said(tmp_path):
    entry = effort('unit = "N m"\noptional = true')
    recording = read_log(write_npz(tmp_path, u=None), column_map(CLOCK, POSITION, entry))
    assert not recording.has("motor.effort")
    assert recording.header.provenance["left_out"] == ["motor.effort"]
    with refused("There is no 'u' in the file", "It holds t (7,), q (7, 2)"):
        read_log(write_npz(tmp_path, u=None), column_map(CLOCK, POSITION, effort('unit = "N m"')))


def test_meta_holds_values_and_arrays_of_the_file(tmp_path):
    meta = '[meta]\ngain = { source = "gain" }\ncell = 3\nwhere = { source = "absent", optional = true }\n'
    recording = read_log(write_npz(tmp_path, gain=np.array(2.5)), column_map(CLOCK, POSITION, meta))
    assert recording.header.meta == {"gain": 2.5, "cell": 3}


@pytest.mark.parametrize(
    ("t", "rows", "words"),
    [
        ([0, 1, 2, 2, 3, 4, 5.0], [0, 1, 2, 4, 5, 6], "1 with the time of another row, the first in row 3"),
        ([0, 1, 1, 2, 2, 3, 4.0], [0, 1, 3, 5, 6], "2 with the time of another row, the first in row 2"),
        ([0, 1, 2, 0.5, 3, 4, 5.0], [0, 1, 2, 4, 5, 6], "1 that go back in time, the first in row 3"),
        ([0, 9, 2, 3, 4, 5, 6.0], [0, 2, 3, 4, 5, 6], "1 that go back in time, the first in row 1"),
    ],
)
def test_rows_whose_time_repeats_or_goes_back_are_dropped_and_told(t, rows, words, tmp_path):
    clock = CLOCK.replace('"ms"', '"s"')
    recording = read_log(write_npz(tmp_path, t=np.array(t, dtype=float)), column_map(clock, POSITION))
    assert recording.t.tolist() == [t[row] for row in rows]
    assert np.array_equal(recording.joint_array("motor.position"), arrays()["q"][rows])
    assert words in recording.header.meta["conditioning"][0]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"q": np.zeros((N_ROWS, 3))}, ["'q' has shape (7, 3) and so 3 parts, must be 2", "another robot"]),
        (
            {"q": np.zeros((N_ROWS - 1, 2))},
            ["'motor.position'", "has 6 rows, but timestamp has 7", "clock and resample"],
        ),
        ({"q": np.zeros((3, N_ROWS, 2))}, ["'q' has shape (3, 7, 2); say which axis is what"]),
        ({"q": np.zeros(N_ROWS)}, ["'q' has shape (7,) and so 1 parts, must be 2"]),
        ({"q": np.full((N_ROWS, 2), "left")}, ["'q' is not numbers", "is 'left'", "decimal, units_row and first_row"]),
        ({"q": np.zeros((N_ROWS, 2), dtype=complex)}, ["'q' is complex128, must be real numbers"]),
        ({"q": np.where(np.arange(N_ROWS)[:, None] == 4, np.nan, np.zeros((1, 2)))}, ["row 4 is nan, must be finite"]),
        ({"q": np.full((N_ROWS, 2), np.inf)}, ["row 0 is inf"]),
        (
            {"t": np.array([0, 1, 2, 1, 0, 2, 1.0])},
            ["timestamp must increase strictly, but row 3 is 1.0 s after 2.0 s"],
        ),
        ({"t": arrays()["t"][::-1]}, ["timestamp must increase strictly, but row 1"]),
        ({"t": np.zeros((N_ROWS, 2))}, ["'timestamp'", "'t' has shape (7, 2) and so 2 parts, must be 1"]),
        ({"t": 1e12 + arrays()["t"]}, ["timestamp row 0 is", "Convert it to seconds"]),
        ({"t": None}, ["There is no 't' in the file", "It holds q (7, 2), u (7, 2)"]),
    ],
)
def test_what_does_not_fit_is_one_error_that_names_file_map_and_entry(changes, words, tmp_path):
    with refused("run.npz with map.toml: ", *words):
        read_log(write_npz(tmp_path, **changes), column_map(CLOCK, POSITION))


def test_a_map_may_leave_the_robot_to_its_reader(tmp_path):
    q = np.tile(arrays()["q"][:, :1], 6)
    free, bound = (
        column_map(CLOCK, POSITION, log=""),
        column_map(CLOCK, POSITION, log='[log]\nrobot = "irb4600_60_205"'),
    )
    path = write_npz(tmp_path, q=q)
    assert read_log(path, free, robot="irb4600_60_205").equals(read_log(path, bound))
    assert read_log(path, bound, robot=load_robot("irb4600_60_205")).equals(read_log(path, bound))
    with refused("map.toml names no robot: pass robot="):
        read_log(path, free)
    with refused("map.toml is for robot 'irb4600_60_205', not for 'kuka_kr300_r2500'"):
        read_log(path, bound, robot="kuka_kr300_r2500")
    with refused("map.toml is for robot 'press', not for 'irb4600_60_205'"):
        read_log(path, column_map(CLOCK, POSITION), robot="irb4600_60_205")


def test_a_description_is_found_beside_the_map(tmp_path, one_axis_text):
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "mine.toml").write_text(one_axis_text.replace('"one_axis"', '"mine"'), encoding="utf-8")
    (tmp_path / "maps" / "map.toml").write_text('[log]\nrobot = "mine.toml"\n' + CLOCK + POSITION, encoding="utf-8")
    recording = read_log(write_npz(tmp_path, q=arrays()["t"]), tmp_path / "maps" / "map.toml")
    assert recording.header.robot == "mine"


def test_recordings_need_no_map(tmp_path):
    recording = read_log(write_npz(tmp_path), column_map(CLOCK, POSITION))
    write_recording(recording, tmp_path / "own.csv")
    assert read_log(tmp_path / "own.csv").equals(recording)
    with refused("run.npz: This NPZ file has no 'header' entry"):
        read_logs(tmp_path / "run.npz")
    with refused("header belongs to a recording"):
        read_log(tmp_path / "run.npz", column_map(CLOCK, POSITION), header=recording.header)
    with refused("robot belongs to a column map"):
        read_log(tmp_path / "own.csv", robot="press")
