"""Arms from files against the same files as Pinocchio reads them, by parsers that have nothing in common."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ffgym.robot import RigidArm
from tests.oracle.comparing import ROUNDING, relative
from tests.robot.arm_file.arm_file_samples import ARMS, FILES, described
from tests.robot.arm_file.random_arms import arms, urdf

MISREAD = {
    "ur_like.xml": "of the bodies in the world, Pinocchio takes the first alone, here a table",
    "seven_axes.xml": "Pinocchio gives shapes the mass of water where a class of defaults has their mass",
}
"""Files that Pinocchio 4.1 reads otherwise than MJCF says, and why; tests/robot/arm_file has MuJoCo read them."""


def read_by_pinocchio(path, robot):
    """Model of a file, with all joints but those of the robot held at zero, without drives, in the robot's gravity.

    Pinocchio names joints without a name in its own way; they are then taken in their order.
    """
    read = pin.buildModelFromUrdf if path.suffix == ".urdf" else pin.buildModelFromMJCF
    model = read(str(path))
    names = list(model.names)[1:]
    if set(robot.joints) <= set(names):
        held = [model.getJointId(name) for name in names if name not in robot.joints]
        model = pin.buildReducedModel(model, held, np.zeros(model.nq))
    model.armature = np.zeros(model.nv)
    model.gravity.linear = robot.gravity  # its reader of MJCF takes 9.81 m/s^2 whatever a file says
    return model


def check_same(path, joints, frame, seed, n_poses=5):
    """Dynamics, and the way of a frame, at random states."""
    robot = described(path, joints, frame)
    arm, model = RigidArm(robot), read_by_pinocchio(path, robot)
    data = model.createData()
    q, dq, ddq = np.random.default_rng(seed).uniform(-3, 3, (3, n_poses, robot.n_joints))
    q[0] = 0.0
    torque = [pin.rnea(model, data, *state).copy() for state in zip(q, dq, ddq, strict=True)]
    bias = [pin.nonLinearEffects(model, data, *state).copy() for state in zip(q, dq, strict=True)]
    # large terms may cancel: shares are of what the whole weight asks for at a metre
    least = 10.0 * robot.bodies.mass.sum()
    assert relative(arm.inverse_dynamics(q, dq, ddq, gravity=True), torque, least) < ROUNDING
    assert relative(arm.equations_of_motion(q, dq, gravity=True)[1], bias, least) < ROUNDING
    if model.existFrame(frame):
        place = model.getFrameId(frame)
        poses = np.array([_pose(model, data, one, place) for one in q])
        # its reader of MJCF leaves out where the base stands: the pose at zero tells
        own = np.tile(np.eye(4), (n_poses, 1, 1))
        own[:, :3, 3], own[:, :3, :3] = arm.tcp_pose(q)
        base = own[0] @ np.linalg.inv(poses[0])
        assert path.suffix != ".urdf" or np.allclose(base, np.eye(4), rtol=0, atol=50 * ROUNDING)
        np.testing.assert_allclose(own, base @ poses, rtol=0, atol=50 * ROUNDING)


def _pose(model, data, q, frame):
    pin.framesForwardKinematics(model, data, q)
    return data.oMf[frame].homogeneous.copy()


@pytest.mark.parametrize("name", [name for name in ARMS if name not in MISREAD])
def test_an_arm_moves_and_weighs_as_pinocchio_reads_its_file(name):
    check_same(FILES / name, *ARMS[name], seed=1, n_poses=20)


@settings(max_examples=40)
@given(arm=arms, seed=st.integers(0, 2**32 - 1))
def test_any_chain_in_urdf_moves_and_weighs_as_pinocchio_reads_its_file(tmp_path_factory, arm, seed):
    path = tmp_path_factory.mktemp("urdf") / "arm.urdf"
    path.write_text(urdf(arm), encoding="utf-8")
    check_same(path, None, f"b{len(arm) - 1}", seed)
