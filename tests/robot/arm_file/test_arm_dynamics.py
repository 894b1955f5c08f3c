"""A description moves and weighs as the file it was read from, as MuJoCo itself reads that file.

Pinocchio reads files in tests/oracle.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ffgym.robot import RigidArm
from ffgym.robot.arm_file import read_arm
from tests.robot.arm_file.arm_file_samples import ARMS, FILES, Original, described
from tests.robot.arm_file.random_arms import arms, mjcf


def check_same(path, joints, frame, seed, n_poses=5):
    """Kinematics and dynamics of the description against MuJoCo with the original file, at random states."""
    robot = described(path, joints, frame)
    ours, theirs = RigidArm(robot), Original(path, robot.joints)
    weight = robot.bodies.mass.sum()
    rng = np.random.default_rng(seed)
    q, dq, ddq = rng.uniform(-3, 3, (3, n_poses, robot.n_joints))
    inertia, torque, gravity = (
        ours.mass_matrix(q),
        ours.inverse_dynamics(q, dq, ddq, gravity=True),
        ours.gravity_torque(q),
    )
    for i in range(n_poses):
        expected = theirs.mass_matrix(q[i])
        scale = np.abs(expected).max() + weight * 1.0**2  # rounding is that of terms that may cancel, at arms of 1 m
        np.testing.assert_allclose(inertia[i], expected, rtol=0, atol=1e-12 * scale)
        bias = theirs.bias(q[i], dq[i])
        force = np.abs(bias).max() + 10 * scale
        np.testing.assert_allclose(torque[i], expected @ ddq[i] + bias, rtol=0, atol=1e-11 * force)
        np.testing.assert_allclose(gravity[i], theirs.bias(q[i], 0 * dq[i]), rtol=0, atol=1e-12 * force)
    if frame:
        position, rotation = ours.tcp_pose(q)
        for i in range(n_poses):
            point, turn = theirs.pose(frame, q[i])
            np.testing.assert_allclose(position[i], point, rtol=0, atol=1e-12)
            np.testing.assert_allclose(rotation[i], turn, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", ARMS)
def test_an_arm_moves_and_weighs_as_its_file(name):
    check_same(FILES / name, *ARMS[name], seed=1, n_poses=20)


@settings(max_examples=60)
@given(arm=arms, seed=st.integers(0, 2**32 - 1))
def test_any_chain_in_mjcf_moves_and_weighs_as_its_file(tmp_path_factory, arm, seed):
    path = tmp_path_factory.mktemp("mjcf") / "arm.xml"
    path.write_text(mjcf(arm), encoding="utf-8")
    frames = [f"s{i}" for i in range(last_joint(arm), len(arm)) if arm[i].has_frame] + [f"b{len(arm) - 1}"]
    check_same(path, None, frames[0], seed)


@settings(max_examples=30)
@given(arm=arms, seed=st.integers(0, 2**32 - 1), data=st.data())
def test_any_part_of_a_chain_moves_and_weighs_as_its_file_with_the_others_at_zero(tmp_path_factory, arm, seed, data):
    path = tmp_path_factory.mktemp("part") / "arm.xml"
    path.write_text(mjcf(arm), encoding="utf-8")
    joints = [f"j{i}" for i, body in enumerate(arm) if body.joint]
    chosen = data.draw(st.lists(st.sampled_from(joints), min_size=1, unique=True).map(sorted))
    check_same(path, chosen, f"b{len(arm) - 1}", seed)


def test_frames_of_all_links_are_parallel_to_the_world_at_zero_with_origins_on_the_axes():
    robot = described(FILES / "kr_like.xml")
    theirs = Original(FILES / "kr_like.xml", robot.joints)
    theirs.move(np.zeros(6), np.zeros(6))
    np.testing.assert_allclose(np.cumsum(robot.kinematics.position, axis=0), theirs.data.xanchor, atol=1e-15)
    np.testing.assert_allclose(robot.kinematics.axis, theirs.data.xaxis, atol=1e-15)


def test_what_is_welded_to_a_link_is_part_of_it():
    arm = read_arm(FILES / "ur_like.xml", ARMS["ur_like.xml"][0], looks=False)
    assert arm.quantities["links.mass"].value[-1] == pytest.approx(0.1889 + 0.8 + 0.05 + 0.05)
    assert arm.quantities["base.mass"].value == pytest.approx(4.0)


def test_the_table_beside_an_arm_is_no_part_of_its_base():
    arm = read_arm(FILES / "ur_like.xml", ARMS["ur_like.xml"][0], looks=False)
    np.testing.assert_allclose(arm.quantities["base.com"].value, 0, atol=1e-15)


def last_joint(arm):
    """Index of the last body with a joint."""
    return max(i for i, body in enumerate(arm) if body.joint)
