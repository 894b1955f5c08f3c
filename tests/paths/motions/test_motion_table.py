"""Tables of poses and joint positions: units, times, curves, and errors that name file, row and column."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ffgym.core.errors import FFGymError
from ffgym.paths.motions import load_motion
from ffgym.paths.motions.table_part import parse_table
from ffgym.robot import RigidArm

JOINTS, UNITS = ("a", "b"), ("rad", "m")
POINT = np.array([1.3, -0.2, 0.6])
DT = 0.004


def table(text):
    return parse_table(text, "points.csv", JOINTS, UNITS)


def csv(names, rows):
    return "\n".join([names, *(",".join(repr(float(x)) for x in row) for row in rows)]) + "\n"


def written(tmp_path, text):
    path = tmp_path / "points.csv"
    path.write_text(text)
    return path


def test_units_are_converted_and_columns_may_come_in_any_order():
    made = table("# a comment\nb_mm,t_ms,a_deg\n1000,0,180\n2000,10,90\n3000,20,90\n4000,30,0\n")
    np.testing.assert_allclose(made.t, [0, 0.01, 0.02, 0.03])
    np.testing.assert_allclose(made.joints, [[np.pi, 1], [np.pi / 2, 2], [np.pi / 2, 3], [0, 4]])
    poses = table("x_mm,y_m,z_m,roll_deg,pitch_deg,yaw_rad\n1000,2,3,90,0,0\n")
    np.testing.assert_allclose(poses.positions, [[1, 2, 3]])
    np.testing.assert_allclose(poses.rotations[0], [[1, 0, 0], [0, 0, -1], [0, 1, 0]], atol=1e-12)
    turned = table("x_m,y_m,z_m,qw,qx,qy,qz\n0,0,0,0,0,0,1\n")
    np.testing.assert_allclose(turned.rotations[0], np.diag([-1, -1, 1]), atol=1e-12)


def test_joint_values_in_time_are_followed_by_a_smooth_curve(one_axis, tmp_path):
    t = np.linspace(0, 2, 201)
    q = 0.3 * np.sin(np.pi * t / 2) ** 2
    text = csv(f"t_s,{one_axis.joints[0]}_deg", np.column_stack([t + 5, np.rad2deg(q)]))
    reference = load_motion(RigidArm(one_axis), written(tmp_path, text)).reference
    moving = (reference.t >= 0.3) & (reference.t <= 2.3)
    tau = reference.t[moving] - 0.3
    np.testing.assert_allclose(reference.q[moving, 0], 0.3 * np.sin(np.pi * tau / 2) ** 2, atol=1e-7)
    np.testing.assert_allclose(reference.dq[moving, 0], 0.15 * np.pi * np.sin(np.pi * tau), atol=1e-4)
    bent = 0.15 * np.pi**2 * np.cos(np.pi * tau)
    np.testing.assert_allclose(reference.ddq[moving, 0][1:], bent[1:], atol=0.01)
    assert [p.kind for p in reference.phases] == ["standstill", "motion", "standstill"]


def test_poses_in_time_are_followed_with_their_orientation(arm, irb4600, tmp_path):
    t = np.sort(np.r_[np.linspace(0, 1, 51), np.linspace(0.005, 0.995, 40)])  # not uniform
    swing = np.sin(np.pi * t / 2) ** 2
    points = POINT + 0.05 * swing[:, None] * [1, 0.5, 0.2]
    turn = Rotation.from_rotvec(0.3 * swing[:, None] * [0, 0, 1.0])
    quaternions = (turn * Rotation.from_matrix(irb4600.work_area.tool_rotation)).as_quat(scalar_first=True)
    text = csv("t_s,x_m,y_m,z_m,qw,qx,qy,qz", np.column_stack([t, points, quaternions]))
    reference = load_motion(arm, written(tmp_path, text)).reference
    position, rotation = (part[0] for part in arm.tcp_pose(reference.q[-1:]))
    np.testing.assert_allclose(position, points[-1], atol=1e-8)
    np.testing.assert_allclose(rotation, Rotation.from_quat(quaternions[-1], scalar_first=True).as_matrix(), atol=1e-8)
    hermite = reference.q[:-1] + DT / 2 * (reference.dq[:-1] + reference.dq[1:])
    np.testing.assert_allclose(reference.q[1:], hermite, atol=2e-5)


def test_a_table_that_moves_at_its_ends_keeps_its_speed_there(one_axis, tmp_path):
    t = np.linspace(0, 1, 101)
    text = csv(f"t_s,{one_axis.joints[0]}_rad", np.column_stack([t, 0.2 * t]))
    reference = load_motion(RigidArm(one_axis), written(tmp_path, text)).reference
    np.testing.assert_allclose(reference.dq, 0.2, rtol=1e-9)
    assert [p.kind for p in reference.phases] == ["motion"]


def turning_table(irb4600, t, angle, shift=0.0, signs=1.0):
    """A tool that turns about a leaning axis at one point, as a table."""
    turn = Rotation.from_rotvec(np.outer(angle, [0.3, 0.4, np.sqrt(0.75)]))
    quaternions = (turn * Rotation.from_matrix(irb4600.work_area.tool_rotation)).as_quat(scalar_first=True)
    points = POINT + np.outer(shift * t, [1, 0, 0])
    quaternions = quaternions * np.reshape(signs, (-1, 1))
    return csv("t_s,x_m,y_m,z_m,qw,qx,qy,qz", np.column_stack([t, points, quaternions]))


def turned_by(arm, reference):
    """Angular velocity of tool0 [rad/s], from the joints."""
    return np.einsum("tij,tj->ti", arm.jacobian(reference.q), reference.dq)[:, 3:]


def test_an_orientation_that_starts_and_ends_at_rest_does_so(arm, irb4600, tmp_path):
    t = np.linspace(0, 1.002, 101)  # ends between two samples
    angle = 0.1 * (1 - np.cos(2 * np.pi * t / t[-1]))
    signs = np.where(np.arange(len(t)) % 3, 1, -1)  # of a log that knows both signs of a quaternion
    text = turning_table(irb4600, t, angle, signs=signs)
    reference = load_motion(arm, written(tmp_path, text)).reference
    assert [p.kind for p in reference.phases] == ["standstill", "motion", "standstill"]
    moving = (reference.t >= 0.3) & (reference.t <= 1.3)
    tau = reference.t[moving] - 0.3
    rate = 0.1 * 2 * np.pi / t[-1] * np.sin(2 * np.pi * tau / t[-1])
    along = np.outer(rate, [0.3, 0.4, np.sqrt(0.75)])
    np.testing.assert_allclose(turned_by(arm, reference)[moving], along, atol=2e-4)
    hermite = reference.dq[:-1] + DT / 2 * (reference.ddq[:-1] + reference.ddq[1:])
    assert np.abs(reference.dq[1:] - hermite)[76:320].max() < 1e-4


def test_a_table_that_ends_at_speed_between_two_samples_ends_with_the_one_before(arm, irb4600, tmp_path):
    t = np.linspace(0, 0.99, 100)
    text = turning_table(irb4600, t, 0.2 * t, shift=0.05)
    reference = load_motion(arm, written(tmp_path, text)).reference
    assert reference.duration == pytest.approx(0.988)
    np.testing.assert_allclose(
        turned_by(arm, reference), np.tile([0.06, 0.08, 0.2 * np.sqrt(0.75)], (248, 1)), rtol=1e-4
    )
    steps = np.diff(reference.q, axis=0) - DT / 2 * (reference.dq[:-1] + reference.dq[1:])
    assert np.abs(steps).max() < 1e-7


def test_joint_rows_without_times_are_points_of_a_curve(arm, irb4600, corners, tmp_path):
    rows = np.stack([corners[name] for name in ("p1", "p2", "p3")])
    text = csv(",".join(f"{joint}_rad" for joint in irb4600.joints), rows)
    reference = load_motion(arm, written(tmp_path, text)).reference
    np.testing.assert_allclose(reference.q[[0, -1]], rows[[0, -1]], atol=1e-9)
    assert np.abs(reference.q - rows[1]).max(axis=1).min() < 0.02


BAD = {
    "empty": ("", "points.csv: The CSV file has no row of column names"),
    "no rows": ("x_m,y_m,z_m\n", "points.csv: There are 0 rows"),
    "text": ("x_m,y_m,z_m\n1,2,three\n", "points.csv: Line 2, column 'z_m': 'three' is not a number"),
    "ragged": ("x_m,y_m,z_m\n1,2\n", "Line 2 has 2 cells, must have 3"),
    "semicolons": ("x_m;y_m;z_m\n1;2;3\n", "must be by commas"),
    "twice": ("x_m,x_m,z_m\n1,2,3\n", "more than once"),
    "twice in other units": ("x_m,x_mm,z_m\n1,2,3\n", "Column 'x_mm' says 'x' a second time"),
    "nan": ("x_m,y_m,z_m\n1,2,3\n1,nan,3\n", "Row 2, column 'y_m' is nan, must be a finite number"),
    "inf": ("x_m,y_m,z_m\n1,2,inf\n", "Row 1, column 'z_m' is inf"),
    "a place that is none": ("x_m,y_m,z_m\n1,2,3\n1300,-200,600\n", "Row 2, column 'x_m' is 1300 in SI .*another unit"),
    "an angle that is none": ("a_deg,b_m\n1e9,2\n", "Row 1, column 'a_deg' is 1.74533e.07 in SI .*another unit"),
    "missing column": ("x_m,z_m\n1,2\n", "Columns x, y, z belong together; y is missing"),
    "missing joint": ("a_rad\n1\n", "Columns a, b belong together; b is missing"),
    "unknown joint": ("a_rad,c_rad\n1,2\n", "Unknown column 'c_rad'. A table may have t_s or t_ms"),
    "no unit": ("x,y,z\n1,2,3\n", "Unknown column 'x'"),
    "unknown unit": ("x_inch,y_m,z_m\n1,2,3\n", "Column 'x_inch' must be x_m or x_mm"),
    "wrong unit": ("a_m,b_m\n1,2\n", "Column 'a_m' must be a_rad or a_deg"),
    "degrees of a slide": ("a_rad,b_deg\n1,2\n", "Column 'b_deg' must be b_m or b_mm"),
    "both": ("x_m,y_m,z_m,a_rad,b_m\n1,2,3,4,5\n", "give poses or joint positions, not both"),
    "neither": ("t_s\n1\n", "There are neither x, y, z nor joint positions .a, b."),
    "half a quaternion": ("x_m,y_m,z_m,qw,qx\n1,2,3,1,0\n", "qy, qz is missing"),
    "two orientations": ("x_m,y_m,z_m,qw,roll_deg\n1,2,3,1,0\n", "give one of them"),
    "quaternion": ("x_m,y_m,z_m,qw,qx,qy,qz\n1,2,3,1,1,0,0\n", "Row 1: the quaternion .* must have norm 1"),
    "time stands still": ("t_s,a_rad,b_m\n0,1,1\n1,1,1\n1,2,2\n3,3,3\n", "Row 3, column 't': 1 s is not after 1 s"),
    "time runs back": ("t_s,a_rad,b_m\n0,1,1\n2,1,1\n1,2,2\n3,3,3\n", "Row 3, column 't': 1 s is not after 2 s"),
    "clock jumps": (
        "t_s,a_rad,b_m\n" + "".join(f"{t},1,1\n" for t in (0, 1, 2, 3, 9)),
        "Row 5, .* the clock jumps by 6 s",
    ),
    "few rows": ("t_s,a_rad,b_m\n0,1,1\n1,1,1\n2,2,2\n", "There are 3 rows, must be at least 4"),
}


@pytest.mark.parametrize(("text", "message"), BAD.values(), ids=BAD.keys())
def test_what_is_wrong_in_a_table_is_one_line_with_file_row_and_column(text, message):
    with pytest.raises(FFGymError, match=message) as caught:
        table(text)
    assert str(caught.value).startswith("points.csv: ")
    assert "\n" not in str(caught.value)


def test_points_of_a_curve_must_be_apart(arm, tmp_path):
    path = written(tmp_path, csv("x_m,y_m,z_m", [POINT, POINT + 0.1, POINT + 0.1]))
    with pytest.raises(FFGymError, match="row 3 repeats the row before"):
        load_motion(arm, path)
