"""Where each joint's quantities stand in MuJoCo's arrays."""

from dataclasses import dataclass

import mujoco
import numpy as np

from ffgym.core.types import BoolArray, IntArray
from ffgym.robot import RobotDescription
from ffgym.robot.model.spec import deflection_joint, friction_actuator, motor_joint, servo_actuator


@dataclass(frozen=True, kw_only=True, eq=False)
class Addresses:
    """Addresses of each joint's quantities; hinges have the same address in `qpos` and in `qvel`."""

    motor_qpos: IntArray
    deflection_qpos: IntArray
    """One per elastic joint."""
    is_elastic: BoolArray
    extra_qpos: IntArray
    """Joints that neither turn with a motor nor are its elasticity: those of effects."""
    extra_joint: IntArray
    """The same as numbers of joints."""
    integral: IntArray
    has_integral: BoolArray
    bristle: IntArray
    has_bristle: BoolArray

    @classmethod
    def of(cls, model: mujoco.MjModel, robot: RobotDescription) -> "Addresses":
        """Look the names up once."""
        names = {model.joint(i).name for i in range(model.njnt)}
        elastic = np.array([deflection_joint(j) in names for j in robot.joints])
        integral = np.array([_activation(model, servo_actuator(j)) for j in robot.joints])
        bristle = np.array([_activation(model, friction_actuator(j)) for j in robot.joints])
        own = {motor_joint(j) for j in robot.joints} | {deflection_joint(j) for j in robot.joints}
        extra = [i for i in range(model.njnt) if model.joint(i).name not in own]
        return cls(
            extra_qpos=model.jnt_qposadr[extra].astype(int),
            extra_joint=np.array(extra, dtype=int),
            motor_qpos=np.array([int(model.joint(motor_joint(j)).qposadr[0]) for j in robot.joints]),
            deflection_qpos=np.array(
                [
                    int(model.joint(deflection_joint(j)).qposadr[0])
                    for j, e in zip(robot.joints, elastic, strict=True)
                    if e
                ],
                dtype=int,
            ),
            is_elastic=elastic,
            integral=integral,
            has_integral=integral >= 0,
            bristle=bristle,
            has_bristle=bristle >= 0,
        )


def _activation(model: mujoco.MjModel, actuator: str) -> int:
    """Address of an actuator's activation, -1 if it has none or does not exist."""
    names = {model.actuator(i).name for i in range(model.nactuator)}
    return int(model.actuator(actuator).actadr[0]) if actuator in names else -1
