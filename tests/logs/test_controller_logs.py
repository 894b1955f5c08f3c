"""Logs of controllers by the name of a built-in map, in the layout in which each writes them."""

import gzip
import io
import json
from importlib import resources

import numpy as np
import pytest
from controller_robot import CURRENTS, DRIVES, GEARS, JOINTS, PER_CURRENT, RATED, RATEDS, described
from log_samples import refused

from ffgym.cli.main import main
from ffgym.logs import builtin_columns, load_columns, parse_columns, read_contents, read_log
from ffgym.logs.entries import fitting_maps

N = 40
T = 0.004 * np.arange(N)
Q = np.column_stack([np.sin(9 * T), 0.5 * np.cos(7 * T)])
DQ = np.column_stack([9 * np.cos(9 * T), -3.5 * np.sin(7 * T)])
DRIVEN = np.column_stack([2.0 + np.cos(9 * T), np.sin(7 * T)])  # whatever a controller calls torque


def csv(titles: str, *columns: np.ndarray, comma: str = ",") -> str:
    text = io.StringIO()
    np.savetxt(text, np.column_stack(columns), fmt="%.17g", delimiter=comma)
    return titles + "\n" + text.getvalue()


def counted(form: str, first: int, comma: str = ",") -> str:
    return comma.join(form.format(i) for i in (first, first + 1))


RTDE = ("timestamp", "actual_q_{}", "actual_qd_{}", "actual_current_{}", "target_q_{}")
FRANKA = csv(
    "time,success_rate,"
    + ",".join(counted(f"state.{name}[{{}}]", 0) for name in ("q", "q_d", "dq", "tau_J"))
    + ",cmd.q_d[0]",
    *(1000 * (5 + T), np.ones(N), Q, Q, DQ, DRIVEN, Q[:, :1]),
)
FRANKA_BEFORE = csv(
    "duration, success rate, "
    + ",".join(f"{name}[0], {name}[1]" for name in ("q", "q_d", "dq", "tau_J"))
    + ",sent commands,q_d[0], q_d[1]",
    *(1000 * (5 + T), np.ones(N), Q, Q, DQ, DRIVEN, np.zeros((N, 3))),
)
IPOC = 4_208_163_634 + 4 * np.arange(N)

LAYOUTS = {
    "ur_rtde blanks": (
        "ur_rtde",
        csv(
            " ".join(counted(name, 0, " ") if "{" in name else name for name in RTDE),
            *(40 + T, Q, DQ, DRIVEN, Q),
            comma=" ",
        ),
        DRIVEN * PER_CURRENT / GEARS,
    ),
    "ur_rtde commas": (
        "ur_rtde",
        csv("timestamp," + counted("actual_q_{}", 0) + "," + counted("actual_current_{}", 0), 40 + T, Q, DRIVEN),
        DRIVEN * PER_CURRENT / GEARS,
    ),
    "kuka_rsi": (
        "kuka_rsi",
        csv(
            "Timestamp,IPOC," + counted("AIPos.A{}", 1) + "," + counted("MACur.A{}", 1),
            *(T, IPOC, np.degrees(Q), DRIVEN),
        ),
        DRIVEN / 100 * RATED,
    ),
    "kuka_rsi received": (
        "kuka_rsi",
        csv(
            "Receive.IPOC," + counted("Receive.AIPos.A{}", 1) + "," + counted("Receive.MACur.A{}", 1),
            *(IPOC, np.degrees(Q), DRIVEN),
        ),
        DRIVEN / 100 * RATED,
    ),
    "kuka_fri": (
        "kuka_fri",
        csv("index,time," + ",".join(counted(f"{name}{{}}", 1) for name in ("mp", "ip", "mt")), *(T, T, Q, Q, DRIVEN)),
        DRIVEN,
    ),
    "abb_egm": (
        "abb_egm",
        csv(
            "TIMESTAMP," + ",".join(counted(f"{name}_RJ{{}}", 1) for name in ("R_FB_POS", "R_PL_POS", "TORQUE")),
            *(1000 * T + 7, np.degrees(Q), np.degrees(Q), DRIVEN),
        ),
        DRIVEN,
    ),
    "libfranka": ("libfranka", FRANKA, DRIVEN),
    "libfranka before 2024": ("libfranka", FRANKA_BEFORE, DRIVEN),
    "ros_joint_states_csv": (
        "ros_joint_states_csv",
        csv(
            "__time,"
            + ",".join(f"/joint_states/{joint}/{of}" for of in ("position", "effort") for joint in JOINTS[::-1]),
            *(1.7e9 + T, Q[:, ::-1], DRIVEN[:, ::-1]),
        ),
        DRIVEN,
    ),
}  # fmt: skip
"""Name of the map, text of a file in the controller's layout, and the torque that must come out."""


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_log_of_a_controller_is_read_by_the_name_of_its_map(layout, tmp_path):
    name, text, torque = LAYOUTS[layout]
    path = tmp_path / "run.csv"
    path.write_text(text, encoding="utf-8")
    recording = read_log(path, name, robot=described(tmp_path, DRIVES, CURRENTS, RATEDS))
    assert recording.header.position_side == "link"
    tolerance = 1e-6 if "ros" in layout else 1e-9  # a float64 holds times since 1970 to 0.2 us
    np.testing.assert_allclose(recording.t - recording.t[0], T, atol=tolerance)
    np.testing.assert_allclose(recording.joint_array("motor.position"), Q, atol=1e-12)
    np.testing.assert_allclose(recording.joint_array("motor.effort"), torque, rtol=1e-12)
    if recording.has("motor.velocity"):
        np.testing.assert_allclose(recording.joint_array("motor.velocity"), DQ, atol=1e-12)
    if recording.has("reference.position"):
        np.testing.assert_allclose(recording.joint_array("reference.position"), Q, atol=1e-12)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_the_map_that_fits_a_file_is_named(layout, tmp_path, capsys):
    name, text, _ = LAYOUTS[layout]
    path = tmp_path / "run.csv"
    path.write_text(text, encoding="utf-8")
    assert fitting_maps(read_contents(path)) == [name]
    assert main(["log", "columns", str(path)]) == 0
    assert f"built-in map: {name} fits: ffgym log convert {path} --columns {name}" in capsys.readouterr().out


def test_a_file_of_nobody_known_fits_no_map(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text(csv("time,q1,q2,i1,i2", T, Q, DRIVEN), encoding="utf-8")
    assert fitting_maps(read_contents(path)) == []


def test_every_map_of_a_controller_says_where_its_layout_comes_from():
    for name in builtin_columns():
        text = (resources.files("ffgym.logs") / "data" / f"{name}.toml").read_text(encoding="utf-8")
        assert load_columns(name).robot or "\n# Layout: " in text, name


def test_currents_without_the_robot_s_torque_per_current_are_one_clear_error(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text(LAYOUTS["ur_rtde blanks"][1], encoding="utf-8")
    with refused("ur_rtde.toml", "'A'", "drive.torque_per_current", "two_link has none", "scale = <N m/A>"):
        read_log(path, "ur_rtde", robot=described(tmp_path, DRIVES))


def test_the_constants_that_made_torques_are_kept(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text(LAYOUTS["ur_rtde blanks"][1], encoding="utf-8")
    meta = read_log(path, "ur_rtde", robot=described(tmp_path, DRIVES, CURRENTS)).header.meta
    np.testing.assert_allclose(meta["drive_torque_per_current"], PER_CURRENT / GEARS)


HEADERLESS = """
[log]
position_side = "link"
torque_semantics = "current"
[file]
names_row = 0
[columns.timestamp]
source = "1"
unit = "s"
[columns."motor.position"]
source = "{number+1}"
unit = "rad"
[columns."motor.effort"]
source = "{index+4}"
unit = "mA"
scale = [1.0, 2.0]
sign = [1, -1]
"""


def test_columns_without_names_are_counted_and_a_packed_file_is_read(tmp_path):
    rows = csv("", T, Q, 1000 * DRIVEN / [1.0, -2.0]).lstrip("\n")
    path = tmp_path / "run.csv.gz"
    path.write_bytes(gzip.compress(rows.encode()))
    robot = described(tmp_path, DRIVES, CURRENTS)
    (tmp_path / "map.toml").write_text(HEADERLESS, encoding="utf-8")
    recording = read_log(path, tmp_path / "map.toml", robot=robot)
    assert recording.header.segment == "run"
    np.testing.assert_allclose(recording.joint_array("motor.position"), Q)
    np.testing.assert_allclose(recording.joint_array("motor.effort"), DRIVEN * PER_CURRENT / GEARS)
    path.write_bytes(path.read_bytes()[:-20])
    with refused("run.csv.gz", "no whole gzip file"):
        read_log(path, tmp_path / "map.toml", robot=robot)


def test_a_map_begins_with_another_and_changes_what_it_says(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text(LAYOUTS["kuka_rsi"][1], encoding="utf-8")
    ampere = parse_columns('[log]\nbase = "kuka_rsi"\n[columns."motor.effort"]\nunit = "A"\n')
    recording = read_log(path, ampere, robot=described(tmp_path, DRIVES, CURRENTS))
    np.testing.assert_allclose(recording.joint_array("motor.effort"), DRIVEN * PER_CURRENT / GEARS)
    with refused("base = 'kuka_rsy' is unknown"):
        parse_columns('[log]\nbase = "kuka_rsy"')
    (tmp_path / "a.toml").write_text('[log]\nbase = "a.toml"')
    with refused("must be the name of another column map"):
        load_columns(tmp_path / "a.toml")


DUTY = """
[log]
position_side = "link"
torque_semantics = "command"
[columns.timestamp]
source = "entries.t"
unit = "ms"
[columns."motor.position"]
source = ["entries.count1", "entries.count2"]
twos_complement = 16
counts_per_turn = 4096
unit = "count"
[columns."motor.effort"]
source = "entries.duty"
times = "entries.volts"   # V: duty x supply is the voltage at the motor
scale = [0.02, 0.03]      # N m/V: torque constant over resistance
unit = "N m"
"""
COUNTS = np.array([[65535, 3], [0, 65000], [2, 32767]])


@pytest.mark.parametrize("suffix", ["json", "jsonl"])
def test_json_logs_counts_in_twos_complement_and_duty_cycles_are_read(suffix, tmp_path):
    rows = [
        {"t": 5.0 * i, "count1": int(c[0]), "count2": int(c[1]), "duty": [0.5, -0.1 * i], "volts": 12.0 + i}
        for i, c in enumerate(COUNTS)
    ]
    path = tmp_path / f"run.{suffix}"
    columns = DUTY if suffix == "json" else DUTY.replace("entries.", "")
    path.write_text(json.dumps({"mass": 2, "entries": rows}) if suffix == "json" else "\n".join(map(json.dumps, rows)))
    recording = read_log(path, parse_columns(columns), robot=described(tmp_path, DRIVES))
    signed = np.array([[-1, 3], [0, 65000 - 65536], [2, 32767]])
    np.testing.assert_allclose(recording.joint_array("motor.position"), signed * 2 * np.pi / 4096)
    volts = (12.0 + np.arange(3))[:, None]
    duty = np.array([[0.5, -0.1 * i] for i in range(3)])
    np.testing.assert_allclose(recording.joint_array("motor.effort"), duty * volts * [0.02, 0.03])


def test_an_object_of_lists_is_read_and_broken_json_refused(tmp_path):
    path = tmp_path / "run.json"
    path.write_text(json.dumps({"arm": {"t": [0.0, 0.1], "q": [[1, 2], [3, None]], "ragged": [[1], [2, 3]]}}))
    contents = read_contents(path)
    np.testing.assert_array_equal(contents["arm.q"], [[1, 2], [3, np.nan]])
    assert "arm.ragged" in contents.skipped
    path.write_text('{"t": [0, 1')
    with refused("run.json", "no valid JSON"):
        read_contents(path)


def test_numbers_that_have_their_sign_already_are_no_twos_complement(tmp_path):
    path = tmp_path / "run.json"
    path.write_text(
        json.dumps(
            {"entries": {"t": [0, 1], "count1": [-1, 1], "count2": [0, 0], "duty": [[0, 0]] * 2, "volts": [1, 1]}}
        )
    )
    with refused("twos_complement = 16: -1 is no whole number from 0 to 65535"):
        read_log(path, parse_columns(DUTY), robot=described(tmp_path, DRIVES))
