"""One function builds the MuJoCo model of any described robot; everything that simulates uses it.

Each joint is two hinges on one axis (thesis (2.5)-(2.6)): the motor hinge turns by motor angle / gear ratio and carries
rotor inertia, friction and servo; the deflection hinge behind it is the elasticity, and carries the link. Actuators
have `gear` = gear ratio, so that their numbers stay in motor units; a motor that other axes turn too acts on a fixed
tendon whose length is the motor angle. MuJoCo supplies servo (`ffgym.robot.model.servo`) and friction
(`ffgym.robot.model.friction`) natively; friction behind the elasticity acts on a fixed tendon, whose length is the
angle of the link times the gear ratio. A spring between two links is a spatial tendon.
"""

import warnings
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError, check_number
from ffgym.robot.description import RobotDescription
from ffgym.robot.model.friction import add_friction, bear_arm_friction
from ffgym.robot.model.looks import add_looks
from ffgym.robot.model.names import deflection_joint, motor_joint, motor_tendon
from ffgym.robot.model.servo import add_servo


def _add_actuators(spec: mujoco.MjSpec, robot: RobotDescription, i: int, options: "ModelOptions") -> None:
    """Add servo and friction of motor i, on its joint, or on a tendon if other joints turn the motor too."""
    if not (options.servo or options.friction):
        return
    joint, ratios = robot.joints[i], robot.drive.matrix[i]
    # what the actuators act on, so that their length is the motor angle
    motor: dict[str, Any] = {"trntype": mujoco.mjtTrn.mjTRN_JOINT, "target": motor_joint(joint)}
    gear = float(ratios[i])
    if np.any(np.delete(ratios, i)):
        motor, gear = {"trntype": mujoco.mjtTrn.mjTRN_TENDON, "target": motor_tendon(joint)}, 1.0
        tendon = spec.add_tendon(name=motor_tendon(joint))
        for j in np.flatnonzero(ratios):
            tendon.wrap_joint(motor_joint(robot.joints[j]), ratios[j])
    motor["gear"] = [gear, 0, 0, 0, 0, 0]
    if options.servo:
        add_servo(spec, robot, i, motor)
    if options.friction:
        add_friction(spec, robot, i, motor, flexible=options.flexible)


MASSLESS = 1e-9
"""Mass [kg] and inertia [kg m^2] of the rotor bodies: MuJoCo wants a moving body to weigh something."""


@dataclass(frozen=True, kw_only=True)
class ModelOptions:
    """Options of the model."""

    flexible: bool = True
    """Deflection hinges; False gives one hinge per joint."""
    friction: bool = True
    """LuGre friction on the motors."""
    servo: bool = True
    """Servos, with the rotor inertia that they carry."""
    gravity: bool = True
    """Gravity of the description; False for none."""
    springs: bool = True
    """Springs between links, such as a counterbalance."""
    physics_dt: float | None = None
    """Physics step [s]; None takes the description's."""
    looks: bool = True
    """Geoms, lights and a floor."""

    def __post_init__(self) -> None:
        if self.physics_dt is not None:
            check_number("physics_dt", self.physics_dt, unit="s", low=0.0, open_low=True)


def build_spec(robot: RobotDescription, options: ModelOptions | None = None) -> mujoco.MjSpec:
    """Build the MuJoCo model of the robot, editable; `spec.compile()` gives the MjModel.

    Args:
        robot: the description.
        options: what to leave out or to change; None builds everything.
    """
    options = options or ModelOptions()
    spec = mujoco.MjSpec()
    spec.modelname = robot.name
    spec.compiler.degree = False
    # fixed step, semi-implicit Euler, no contact
    spec.option.timestep = robot.physics_dt if options.physics_dt is None else options.physics_dt
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.gravity = robot.gravity if options.gravity else np.zeros(3)
    spec.option.disableflags = mujoco.mjtDisableBit.mjDSBL_CONTACT
    # serial chain from the base to the tool
    base = spec.worldbody.add_body(name="base")
    _set_inertial(base, robot.base_mass, robot.base_com, np.zeros(6))
    body = base
    # each joint with its motor, gearbox spring and link
    for i in range(robot.n_joints):
        body = _add_joint(body, robot, i, options)
    if robot.tool is not None:  # in the tool0 frame, with sites for tool0 and the TCP
        quat = np.zeros(4)
        mujoco.mju_mat2Quat(quat, robot.tool.rotation.flatten())
        tool = body.add_body(name="tool", pos=robot.tool.position, quat=quat)
        _set_inertial(tool, robot.tool.mass, robot.tool.com, robot.tool.inertia)
        tool.add_site(name="tool0", size=[0.004, 0.004, 0.004])
        tool.add_site(name="tcp", pos=robot.tool.tcp, size=[0.004, 0.004, 0.004], rgba=[0.1, 0.4, 1, 1])
    for i in range(robot.n_joints):
        _add_actuators(spec, robot, i, options)
    for spring in robot.springs if options.springs else ():  # pulls with a force that is a cubic of its elongation
        tendon = spec.add_tendon(
            name=f"{spring.name}_spring", stiffness=spring.stiffness, springlength=[spring.length, spring.length]
        )
        for end, joined, point in zip(("start", "end"), spring.bodies, (spring.start, spring.end), strict=True):
            site = spec.body(joined).add_site(name=f"{spring.name}_{end}", pos=point, size=[0.01, 0.01, 0.01])
            tendon.wrap_site(site.name)
    if options.looks:
        add_looks(spec, robot)
    bear_arm_friction(spec, robot)
    return spec


def compile_model(robot: RobotDescription, options: ModelOptions | None = None) -> mujoco.MjModel:
    """Compile the MuJoCo model of the robot.

    Raises:
        FFGymError: if its masses and lengths are such that MuJoCo cannot invert the inertia.
    """
    spec = build_spec(robot, options)
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        try:
            return spec.compile()
        except UserWarning as warning:
            raise FFGymError(
                f"Robot {robot.name!r} cannot be simulated: {str(warning).partition('.')[0]}. Is a mass, an inertia or "
                f"a length in another unit?"
            ) from warning


def _add_joint(parent: mujoco.MjsBody, robot: RobotDescription, i: int, options: ModelOptions) -> mujoco.MjsBody:
    """Add motor hinge, deflection hinge and link of joint i; returns the link. A sliding joint slides on both sides."""
    joint, link, drive = robot.joints[i], robot.links[i], robot.drive
    sliding = robot.kinematics.is_sliding[i]
    hinge: dict[str, Any] = {
        "type": mujoco.mjtJoint.mjJNT_SLIDE if sliding else mujoco.mjtJoint.mjJNT_HINGE,
        "axis": robot.kinematics.axis[i],
    }
    elastic = options.flexible and not drive.is_rigid[i]
    body = parent.add_body(name=f"{link}_rotor" if elastic else link, pos=robot.kinematics.position[i])
    body.add_joint(name=motor_joint(joint), limited=True, range=robot.kinematics.range[i], **hinge)
    if elastic:
        _set_inertial(body, MASSLESS, np.zeros(3), np.array([MASSLESS, MASSLESS, MASSLESS, 0, 0, 0]))
        body = body.add_body(name=link)
        stiffness, damping = [drive.joint_stiffness[i], 0, 0], [drive.joint_damping[i], 0, 0]
        body.add_joint(name=deflection_joint(joint), stiffness=stiffness, damping=damping, **hinge)
    _set_inertial(body, robot.bodies.mass[i], robot.bodies.com[i], robot.bodies.inertia[i])
    return body


def _set_inertial(body: mujoco.MjsBody, mass: float, com: np.ndarray, inertia: np.ndarray) -> None:
    """Mass [kg], centre of mass [m] and inertia [kg m^2] (xx, yy, zz, xy, xz, yz) about it."""
    body.explicitinertial = True
    body.mass = mass
    body.ipos = com
    if np.any(inertia):
        body.fullinertia = inertia
