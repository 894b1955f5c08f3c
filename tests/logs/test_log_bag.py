"""MCAP files and rosbags: joints by name, a tracker with a clock of its own, two senders on one topic."""

import numpy as np
import pytest
from controller_robot import CURRENTS, DRIVES, GEARS, PER_CURRENT, described
from log_samples import LOG, RATIOS, column_map, refused
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from ffgym.logs import parse_columns, read_contents, read_log
from ffgym.logs.entries import fitting_maps

STORE = get_typestore(Stores.ROS2_HUMBLE)
START = 1_789_999_999_963_456_789  # a second ends after ten rows
PERIOD = 4_000_000
N = 20

CLOCK = """
[columns.timestamp]
source = "/joint_states#1:header.stamp"
unit = "ns"
from_first = true
"""

POSITION = """
[columns."motor.position"]
source = "/joint_states#1:position.{joint}"
unit = "rad"
side = "link"
"""

TRACKER = """
[columns."tcp.position"]
source = ["/tracker:pose.position.x", "/tracker:pose.position.y", "/tracker:pose.position.z"]
unit = "m"
"""

TRACKER_TIME = """
[columns."tcp.timestamp"]
source = "/tracker:header.stamp"
unit = "ns"
from_first = true
resample = "gaps"
"""


def message(kind, /, **fields):
    return STORE.types[kind](**fields)


def header(ns):
    stamp = message("builtin_interfaces/msg/Time", sec=ns // 10**9, nanosec=ns % 10**9)
    return message("std_msgs/msg/Header", stamp=stamp, frame_id="base")


def joints(ns, names, position):
    fields = {"position": np.array(position, dtype=float), "velocity": np.zeros(0), "effort": np.zeros(0)}
    return message("sensor_msgs/msg/JointState", header=header(ns), name=list(names), **fields)


def pose(ns, x):
    position = message("geometry_msgs/msg/Point", x=x, y=2 * x, z=-x)
    turn = message("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0)
    inner = message("geometry_msgs/msg/Pose", position=position, orientation=turn)
    return message("geometry_msgs/msg/PoseStamped", header=header(ns), pose=inner)


def angles(i):
    return {"upper": np.sin(0.1 * i), "lower": np.cos(0.1 * i)}


@pytest.fixture(scope="module", params=list(StoragePlugin), ids=lambda plugin: plugin.name)
def bag(request, tmp_path_factory):
    """Arm at 250 Hz in changing order of its joints, gripper on the same topic, tracker at a third of the rate."""
    folder = tmp_path_factory.mktemp("bags") / "run"
    with Writer(folder, version=9, storage_plugin=request.param) as writer:
        states = writer.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=STORE)
        tracker = writer.add_connection("/tracker", "geometry_msgs/msg/PoseStamped", typestore=STORE)

        def write(connection, ns, sent):
            writer.write(connection, ns + 700, STORE.serialize_cdr(sent, sent.__msgtype__))

        for i in range(N):
            ns = START + i * PERIOD
            names = ("upper", "lower") if i % 2 else ("lower", "upper")
            write(states, ns, joints(ns, names, [angles(i)[name] for name in names]))
            if i % 5 == 0:
                write(states, ns + 900, joints(ns, ["finger"], [0.01]))
            if i % 3 == 0:
                write(tracker, ns + 1000, pose(ns + 1_000_000, 0.1 * i))
    return folder


def test_joints_are_found_by_name_in_any_order(bag):
    recording = read_log(bag, column_map(CLOCK, POSITION))
    np.testing.assert_allclose(recording.t, 0.004 * np.arange(N), rtol=1e-15)
    expected = np.array([[angles(i)["upper"], angles(i)["lower"]] for i in range(N)]) * RATIOS
    np.testing.assert_array_equal(recording.joint_array("motor.position"), expected)


def test_a_single_file_of_the_bag_will_do(bag):
    (file,) = [file for file in bag.iterdir() if file.suffix in (".mcap", ".db3")]
    assert set(read_contents(file)) == set(read_contents(bag))


def test_senders_of_different_joints_on_one_topic_are_streams_of_their_own(bag):
    contents = read_contents(bag)
    assert contents["/joint_states#1:position.upper"].shape == (N,)
    assert contents["/joint_states#2:position.finger"].shape == (4,)
    assert "/joint_states#1:effort" not in contents.arrays


def test_samples_of_another_clock_need_a_word(bag):
    with refused("'tcp.position'", "clock of '/tracker'", "resample = 'gaps', 'linear' or 'hold'"):
        read_log(bag, column_map(CLOCK, POSITION, TRACKER))


def test_gaps_put_each_sample_into_the_nearest_row_and_nothing_between(bag):
    recording = read_log(bag, column_map(CLOCK, POSITION, TRACKER + 'resample = "gaps"', TRACKER_TIME))
    x = recording["tcp.position.x"]
    expected = np.where(np.arange(N) % 3 == 0, 0.1 * np.arange(N), np.nan)
    np.testing.assert_array_equal(x, expected)
    seen = np.isfinite(x)
    np.testing.assert_allclose(recording["tcp.timestamp"][seen] - recording.t[seen], 1e-3)
    assert recording.header.filters[0] == "tcp.position: samples of another clock, each put into the nearest row"


def test_interpolation_is_said_and_happens_in_time(bag):
    recording = read_log(bag, column_map(CLOCK, POSITION, TRACKER + 'resample = "linear"'))
    inside = (recording.t >= 1e-3) & (recording.t <= 0.073)
    expected = 0.1 * (recording.t - 1e-3) / 0.004
    np.testing.assert_allclose(recording["tcp.position.x"][inside], expected[inside], atol=1e-9)
    assert np.isnan(recording["tcp.position.x"][~inside]).all()
    assert recording.header.filters == ("tcp.position: samples of another clock, interpolated linearly",)


def test_rows_without_samples_are_dropped_only_if_the_map_says_so(bag):
    entry = '[columns."user.x"]\nsource = "/tracker:pose.position.x"\nunit = "m"\nresample = "linear"\n'
    with refused("'user.x'", "has no sample for 2 of 20 rows, the first of them 0. trim = true"):
        read_log(bag, column_map(CLOCK, POSITION, entry))

    recording = read_log(bag, column_map(CLOCK, POSITION, entry, log=LOG + "trim = true\n"))
    np.testing.assert_allclose(recording.t, 0.004 * np.arange(1, 19))


def test_the_clock_of_the_recorder_will_do_too(bag):
    clock = CLOCK.replace("header.stamp", "log_time")
    tracker = TRACKER + 'resample = "hold"'
    recording = read_log(bag, column_map(clock, POSITION, tracker))
    np.testing.assert_allclose(recording.t, 0.004 * np.arange(N), rtol=1e-15)
    assert np.isnan(recording["tcp.position.x"][0])  # the tracker's first message came 1 us later
    np.testing.assert_allclose(recording["tcp.position.x"][1:5], [0.0, 0.0, 0.0, 0.3])


def test_a_joint_that_nobody_sends_is_one_error(bag):
    with refused("There is no '/joint_states#1:velocity.upper' in the file. Closest: /joint_states#1:position.upper"):
        read_log(bag, column_map(CLOCK, POSITION.replace("position.{", "velocity.{")))


@pytest.mark.parametrize("suffix", [".mcap", ".db3", ".bag"])
def test_what_is_no_bag_is_one_error(suffix, tmp_path):
    path = tmp_path / f"run{suffix}"
    with refused(f"run{suffix}: no such file"):
        read_contents(path)
    path.touch()
    with refused(f"run{suffix}: the file is empty"):
        read_contents(path)
    path.write_bytes(b"no bag" * 99)
    with refused(f"run{suffix}: Not an MCAP file or rosbag, or damaged"):
        read_contents(path)


@pytest.fixture(scope="module", params=[False, True], ids=["arm alone", "arm and gripper"])
def full_bag(request, tmp_path_factory):
    """Arm with efforts, its joints in changing order, maybe a gripper on the same topic."""
    folder = tmp_path_factory.mktemp("bags") / "run"
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        states = writer.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=STORE)
        for i in range(N):
            ns, names = START + i * PERIOD, ("j1", "j2") if i % 2 else ("j2", "j1")
            values = {"j1": (0.1 * i, 0.2, 5.0 + i), "j2": (-0.1 * i, 0.3, 7.0 - i)}
            sent = [np.array([values[name][k] for name in names]) for k in range(3)]
            fields = dict(zip(("position", "velocity", "effort"), sent, strict=True))
            state = message("sensor_msgs/msg/JointState", header=header(ns), name=list(names), **fields)
            writer.write(states, ns + 700, STORE.serialize_cdr(state, state.__msgtype__))
            if request.param:
                finger = joints(ns, ["finger"], [0.01])
                writer.write(states, ns + 900, STORE.serialize_cdr(finger, finger.__msgtype__))
    return folder


def test_joint_states_of_any_robot_are_read_by_the_built_in_map(full_bag, tmp_path):
    robot = described(tmp_path, DRIVES, CURRENTS)
    recording = read_log(full_bag, "ros_joint_states", robot=robot)
    i = np.arange(N)
    np.testing.assert_allclose(recording.t, 0.004 * i, rtol=1e-15)
    np.testing.assert_allclose(recording.joint_array("motor.position"), np.column_stack([0.1 * i, -0.1 * i]))
    np.testing.assert_allclose(recording.joint_array("motor.velocity")[:, 1], 0.3)
    np.testing.assert_allclose(recording.joint_array("motor.effort"), np.column_stack([5.0 + i, 7.0 - i]))
    assert recording.header.torque_semantics == "link_side"
    assert fitting_maps(read_contents(full_bag)) == ["ros_joint_states"]
    current = '[log]\nbase = "ros_joint_states"\ntorque_semantics = "current"\n[columns."motor.effort"]\nunit = "A"'
    sent = read_log(full_bag, parse_columns(current), robot=robot).joint_array("motor.effort")
    np.testing.assert_allclose(sent, np.column_stack([5.0 + i, 7.0 - i]) * PER_CURRENT / GEARS)
