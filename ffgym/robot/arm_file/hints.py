"""What a model says about the drives of its joints: MuJoCo's joint and actuator parameters, and what URDF adds."""

import mujoco
import numpy as np

from ffgym.core.types import IntArray
from ffgym.robot.arm_file.arm_file import JointHints
from ffgym.robot.arm_file.chain import Chain
from ffgym.robot.arm_file.source import Source


def joint_hints(model: mujoco.MjModel, chain: Chain, source: Source) -> tuple[JointHints, ...]:
    """Hints for each joint of the chain."""
    return tuple(_hints(model, j, name, source) for j, name in zip(chain.joints, chain.names, strict=True))


def _hints(model: mujoco.MjModel, joint: int, name: str, source: Source) -> JointHints:
    dof = int(model.jnt_dofadr[joint])
    actuators = _actuators(model, joint)
    servo = _servo_gains(model, actuators)
    return JointHints(
        effort=_effort(model, joint, actuators),
        speed=source.speeds.get(name),
        damping=_positive(model.dof_damping[dof]),
        friction=_positive(model.dof_frictionloss[dof]),
        armature=_positive(
            model.dof_armature[dof] + sum(_gear(model, a) ** 2 * model.actuator_armature[a] for a in actuators)
        ),
        gear_ratio=source.gear_ratios.get(name, _gear_ratio(model, actuators)),
        position_gain=_positive(servo[0]),
        velocity_gain=_positive(servo[1]),
    )


def _actuators(model: mujoco.MjModel, joint: int) -> IntArray:
    """Actuators that act on a joint and on nothing else."""
    kinds = (mujoco.mjtTrn.mjTRN_JOINT.value, mujoco.mjtTrn.mjTRN_JOINTINPARENT.value)
    return np.flatnonzero(np.isin(model.actuator_trntype, kinds) & (model.actuator_trnid[:, 0] == joint))


def _gear(model: mujoco.MjModel, actuator: int) -> float:
    return float(model.actuator_gear[actuator, 0])


def _gear_ratio(model: mujoco.MjModel, actuators: IntArray) -> float | None:
    """The gear of the only actuator; 1, which MuJoCo sets where nothing is said, is none."""
    ratio = _gear(model, actuators[0]) if len(actuators) == 1 else 1.0
    return None if ratio in (0.0, 1.0) else ratio


def _effort(model: mujoco.MjModel, joint: int, actuators: IntArray) -> float | None:
    """Largest torque of a joint: its own limit, else what its actuators give at their force limits."""
    if model.jnt_actfrclimited[joint]:
        return _positive(np.abs(model.jnt_actfrcrange[joint]).max())
    if not len(actuators) or not np.all(model.actuator_forcelimited[actuators]):
        return None
    return _positive(sum(abs(_gear(model, a)) * np.abs(model.actuator_forcerange[a]).max() for a in actuators))


def _servo_gains(model: mujoco.MjModel, actuators: IntArray) -> tuple[float, float]:
    """K_p and K_v, seen from the joint, of servos with force = gain ctrl - K_p position - K_v velocity."""
    affine = [a for a in actuators if model.actuator_biastype[a] == mujoco.mjtBias.mjBIAS_AFFINE.value]
    kp, kv = (sum(-(_gear(model, a) ** 2) * model.actuator_biasprm[a, i] for a in affine) for i in (1, 2))
    return float(kp), float(kv)


def _positive(value: float) -> float | None:
    return float(value) if value > 0 else None
