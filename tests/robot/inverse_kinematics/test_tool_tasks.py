"""Arms of all kinds follow what their tool is asked to do, and their speeds and accelerations are derivatives."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from ffgym.paths import cartesian_reference
from ffgym.robot import RigidArm, solve_pose
from ffgym.robot.inverse_kinematics import joint_rates, rotation_error
from ffgym.robot.inverse_kinematics.newton import mobility
from tests.robot.arm_samples import ARMS, random_arm
from tests.robot.tool_motions import joint_motion, slope, tool_path

few = settings(max_examples=15)
seeds = st.integers(0, 2**32 - 1)


def followed(arm, path):
    """Reference of a path, after checking that the tool follows it and that rates are derivatives."""
    reference = cartesian_reference(arm, path)
    where, turned = arm.tcp_pose(reference.q)
    np.testing.assert_allclose(where, path.position, rtol=0, atol=1e-9)
    twist = np.einsum("tij,tj->ti", arm.jacobian(reference.q), reference.dq)
    np.testing.assert_allclose(twist[:, :3], path.velocity, rtol=0, atol=1e-8)
    if path.rotation is not None:
        np.testing.assert_allclose(rotation_error(path.rotation, turned), 0, atol=1e-9)
        np.testing.assert_allclose(twist[:, 3:], path.angular_velocity, rtol=0, atol=1e-8)
    bound = 1e-6 * (1 + np.abs(reference.ddq).max())
    np.testing.assert_allclose(slope(reference.q), reference.dq[3:-3], rtol=0, atol=bound)
    np.testing.assert_allclose(slope(reference.dq), reference.ddq[3:-3], rtol=0, atol=20 * bound)
    return reference


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("turning", [True, False])
def test_every_arm_follows_poses_and_positions(name, turning):
    arm = RigidArm(ARMS[name]())
    motion = joint_motion(arm.robot.work_area.home)
    reference = followed(arm, tool_path(arm, motion, turning=turning))
    if mobility(arm, turning=turning) == arm.robot.n_joints:
        np.testing.assert_allclose(reference.q, motion[1], rtol=0, atol=1e-7)


@few
@given(
    st.sampled_from([("RRR", False), ("RRPR", True), ("PRP", False), ("RRRRR", True), ("RRRRRR", True)]), seeds, seeds
)
def test_arms_without_joints_to_spare_make_the_motion_that_made_the_path(kind, seed, motion_seed):
    types, turning = kind
    arm, motion = comfortable_arm(types, seed, motion_seed, turning)
    reference = followed(arm, tool_path(arm, motion, turning=turning))
    np.testing.assert_allclose(reference.q, motion[1], rtol=0, atol=1e-6)


@few
@given(
    st.sampled_from([("RRRRRRR", True), ("PRRRRRR", True), ("RRRR", False), ("RRRRRR", False), ("PRRP", False)]),
    seeds,
    seeds,
)
def test_arms_with_joints_to_spare_follow_and_come_back_to_where_they_were(kind, seed, motion_seed):
    types, turning = kind
    arm, motion = comfortable_arm(types, seed, motion_seed, turning)
    reference = followed(arm, tool_path(arm, motion, turning=turning))
    np.testing.assert_allclose(reference.q[0], motion[1][0], rtol=0, atol=1e-8)  # the seed makes the first pose
    np.testing.assert_allclose(reference.q[-1], reference.q[0], rtol=0, atol=1e-7)


def comfortable_arm(types, seed, motion_seed, turning):
    """A random arm and a small motion of it, away from singularities and joint limits; else another example."""
    robot = random_arm(types, seed)
    home = np.random.default_rng(motion_seed).uniform(-0.8, 0.8, robot.n_joints)
    robot = replace(robot, work_area=replace(robot.work_area, home=home))
    arm, motion = RigidArm(robot), joint_motion(home, spread=0.03, seed=motion_seed)
    sizes = np.linalg.svd(arm.jacobian(motion[1])[:, : 6 if turning else 3], compute_uv=False)
    assume(np.all(sizes[:, -1] > sizes[:, 0] / 30))
    return arm, motion


@pytest.mark.parametrize(("name", "turning"), [("seven_axis", True), ("on_a_track", True), ("ur_like", False)])
def test_joints_to_spare_move_least_at_the_seed(name, turning):
    arm = RigidArm(ARMS[name]())
    reference = followed(arm, tool_path(arm, joint_motion(arm.robot.work_area.home, seed=3), turning=turning))
    jacobian, speed = arm.jacobian(reference.q[:1])[0, : 6 if turning else 3], arm.robot.kinematics.max_speed
    least = speed * (np.linalg.pinv(jacobian * speed) @ (jacobian @ reference.ddq[0]))
    np.testing.assert_allclose(reference.ddq[0], least, atol=1e-9 * np.abs(least).max())


@pytest.mark.parametrize(("name", "turning"), [("seven_axis", True), ("on_a_track", False), ("three_link", False)])
def test_no_neighbour_with_the_same_pose_is_nearer_to_the_seed(name, turning):
    arm = RigidArm(ARMS[name]())
    home, speed = arm.robot.work_area.home, arm.robot.kinematics.max_speed
    reference = followed(arm, tool_path(arm, joint_motion(home, seed=5), turning=turning))
    pose, rank = arm.tcp_pose(reference.q), mobility(arm, turning=turning)

    def distance(q):
        return np.sum(((q - home) / speed) ** 2)

    for row in (100, 250, 400):
        q = reference.q[row]
        free = np.linalg.svd(arm.jacobian(q[None])[0, : 6 if turning else 3])[2][rank:]
        np.testing.assert_allclose(free @ ((q - home) / speed**2), 0, atol=1e-9)
        for aside in (*free, *-free):
            start = q + 0.05 * aside
            other = solve_pose(arm, pose[0][row], pose[1][row] if turning else None, start)
            assert distance(other) > distance(q)


@pytest.mark.parametrize("name", ["seven_axis", "ur_like", "scara", "five_axis"])
def test_a_path_in_one_block_is_the_same_as_sample_by_sample(name):
    arm = RigidArm(ARMS[name]())
    path = tool_path(arm, joint_motion(arm.robot.work_area.home), turning=True)
    whole = cartesian_reference(arm, path)
    for row in (1, 255, 256, 257):
        alone = cartesian_reference(
            arm, replace(path, t=path.t[:2], **{
                name: getattr(path, name)[[row, row]]
                for name in ("position", "velocity", "acceleration", "rotation", "angular_velocity",
                             "angular_acceleration")
            })
        )  # fmt: skip
        np.testing.assert_allclose(alone.q[0], whole.q[row], rtol=0, atol=1e-8)
        np.testing.assert_allclose(alone.ddq[0], whole.ddq[row], rtol=0, atol=1e-6)


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("turning", [True, False])
def test_rates_of_a_sample_have_the_same_bits_alone_and_among_others(name, turning):
    arm = RigidArm(ARMS[name]())
    home, rng = arm.robot.work_area.home, np.random.default_rng(0)
    q = home + rng.uniform(-0.1, 0.1, (300, len(home)))
    twist, change = rng.normal(size=(2, 300, 6 if turning else 3))
    together = joint_rates(arm, q, home, twist, change)
    for row in (0, 299):
        alone = joint_rates(arm, q[[row]], home, twist[[row]], change[[row]])
        np.testing.assert_array_equal(np.concatenate(alone), [part[row] for part in together])
