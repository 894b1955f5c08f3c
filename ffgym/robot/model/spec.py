"""One function builds the MuJoCo model of any described robot; everything that simulates uses it.

Each joint is two hinges on one axis (thesis (2.5)-(2.6)): the motor hinge turns by motor angle / gear ratio and carries
rotor inertia, friction and servo; the deflection hinge behind it is the elasticity, and carries the link. Actuators
have `gear` = gear ratio, so that their numbers stay in motor units; a motor that other axes turn too acts on a fixed
tendon whose length is the motor angle. MuJoCo supplies servo (`pid`) and friction (passive `dcmotor` with LuGre
bristles) natively. A spring between two links is a spatial tendon.
"""

from dataclasses import dataclass

import mujoco
import numpy as np

from ffgym.core.errors import check_number
from ffgym.robot.description import RobotDescription
from ffgym.robot.model.looks import add_looks
from ffgym.robot.parts import Spring


def motor_joint(joint: str) -> str:
    """Name of the hinge that the motor turns."""
    return f"{joint}_motor"


def deflection_joint(joint: str) -> str:
    """Name of the hinge that is the elasticity."""
    return f"{joint}_deflection"


def servo_actuator(joint: str) -> str:
    """Name of the servo actuator."""
    return f"{joint}_servo"


def friction_actuator(joint: str) -> str:
    """Name of the friction actuator."""
    return f"{joint}_friction"


def motor_tendon(joint: str) -> str:
    """Name of the tendon whose length is the angle of a motor that other axes turn too."""
    return f"{joint}_motor_angle"


def spring_tendon(spring: str) -> str:
    """Name of the tendon that is a spring between links."""
    return f"{spring}_spring"


_SERVO_INPUTS = mujoco.mjtCtrlInput.mjINPUT_POS | mujoco.mjtCtrlInput.mjINPUT_VEL | mujoco.mjtCtrlInput.mjINPUT_FF


def add_actuators(spec: mujoco.MjSpec, robot: RobotDescription, i: int, *, servo: bool, friction: bool) -> None:
    """Servo and friction of motor i, on its joint, or on a tendon if other joints turn the motor too."""
    if not (servo or friction):
        return
    joint, ratios = robot.joints[i], robot.drive.matrix[i]
    if np.any(np.delete(ratios, i)):
        tendon = spec.add_tendon(name=motor_tendon(joint))
        for j in np.flatnonzero(ratios):
            tendon.wrap_joint(motor_joint(robot.joints[j]), ratios[j])
        motor = _Transmission(kind=mujoco.mjtTrn.mjTRN_TENDON, target=motor_tendon(joint), gear=1.0)
    else:
        motor = _Transmission(kind=mujoco.mjtTrn.mjTRN_JOINT, target=motor_joint(joint), gear=float(ratios[i]))
    if servo:
        _add_servo(spec, robot, i, motor)
    if friction:
        _add_friction(spec, robot, i, motor)


@dataclass(frozen=True, kw_only=True)
class _Transmission:
    """What an actuator acts on, so that its length is the motor angle."""

    kind: mujoco.mjtTrn
    target: str
    gear: float


def _add_servo(spec: mujoco.MjSpec, robot: RobotDescription, i: int, motor: _Transmission) -> None:
    """PID with set-points for position, velocity and feed-forward torque; its integral is clamped."""
    servo, peak = robot.servo, robot.drive.peak_torque[i]
    integral_gain = servo.integral_gain[i]
    actuator = spec.add_actuator(
        name=servo_actuator(robot.joints[i]),
        trntype=motor.kind,
        target=motor.target,
        gear=[motor.gear, 0, 0, 0, 0, 0],
        armature=robot.drive.rotor_inertia[i],
        forcelimited=True,
        forcerange=[-peak, peak],
    )
    actuator.set_to_pid(
        kp=servo.position_gain[i],
        kv=servo.velocity_gain[i],
        ki=integral_gain,
        imax=peak / integral_gain if integral_gain > 0 else 0.0,
        ctrlspec=int(_SERVO_INPUTS),
    )


def _add_friction(spec: mujoco.MjSpec, robot: RobotDescription, i: int, motor: _Transmission) -> None:
    """LuGre friction of motor i: a motor without electrics, whose bristles MuJoCo integrates exactly."""
    f = robot.friction
    actuator = spec.add_actuator(
        name=friction_actuator(robot.joints[i]),
        trntype=motor.kind,
        target=motor.target,
        gear=[motor.gear, 0, 0, 0, 0, 0],
        damping=[f.viscous[i], 0, 0],
    )
    actuator.set_to_dcmotor(
        motorconst=[0, 0],
        resistance=1.0,  # must be positive, acts on nothing: the electrical branch is off
        lugre=[f.bristle_stiffness[i], f.bristle_damping[i], f.coulomb[i], f.static[i], f.stribeck_velocity[i]],
        ctrlspec=int(mujoco.mjtCtrlInput.mjINPUT_NONE),
    )


MASSLESS = 1e-9
"""Mass [kg] and inertia [kg m^2] of the rotor bodies: MuJoCo wants a moving body to weigh something."""


@dataclass(frozen=True, kw_only=True)
class ModelOptions:
    """What to build."""

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
    """MuJoCo model of the robot, editable; `spec.compile()` gives the MjModel.

    Args:
        robot: the description.
        options: what to leave out or to change; None builds everything.
    """
    options = options or ModelOptions()
    spec = mujoco.MjSpec()
    spec.modelname = robot.name
    spec.compiler.degree = False
    _set_options(spec, robot, options)
    base = spec.worldbody.add_body(name="base")
    _set_inertial(base, robot.base_mass, robot.base_com, np.zeros(6))
    body = base
    for i in range(robot.n_joints):
        body = _add_joint(body, robot, i, options)
    if robot.tool is not None:
        _add_tool(body, robot)
    for i in range(robot.n_joints):
        add_actuators(spec, robot, i, servo=options.servo, friction=options.friction)
    if options.springs:
        for spring in robot.springs:
            _add_spring(spec, spring)
    if options.looks:
        add_looks(spec, robot)
    return spec


def compile_model(robot: RobotDescription, options: ModelOptions | None = None) -> mujoco.MjModel:
    """Compiled MuJoCo model of the robot."""
    return build_spec(robot, options).compile()


def _set_options(spec: mujoco.MjSpec, robot: RobotDescription, options: ModelOptions) -> None:
    spec.option.timestep = robot.physics_dt if options.physics_dt is None else options.physics_dt
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.gravity = robot.gravity if options.gravity else np.zeros(3)
    spec.option.disableflags = mujoco.mjtDisableBit.mjDSBL_CONTACT


def _add_joint(parent: mujoco.MjsBody, robot: RobotDescription, i: int, options: ModelOptions) -> mujoco.MjsBody:
    """Motor hinge, deflection hinge and link of joint i; returns the link. A sliding joint slides on both sides."""
    joint, link, drive = robot.joints[i], robot.links[i], robot.drive
    axis = robot.kinematics.axis[i]
    elastic = options.flexible and not drive.is_rigid[i]
    if elastic:
        parent = parent.add_body(name=f"{link}_rotor", pos=robot.kinematics.position[i])
        _set_inertial(parent, MASSLESS, np.zeros(3), np.array([MASSLESS, MASSLESS, MASSLESS, 0, 0, 0]))
        _add_motor_hinge(parent, robot, i)
        body = parent.add_body(name=link)
        body.add_joint(
            name=deflection_joint(joint),
            type=_joint_type(robot, i),
            axis=axis,
            stiffness=[drive.joint_stiffness[i], 0, 0],
            damping=[drive.joint_damping[i], 0, 0],
        )
    else:
        body = parent.add_body(name=link, pos=robot.kinematics.position[i])
        _add_motor_hinge(body, robot, i)
    _set_inertial(body, robot.bodies.mass[i], robot.bodies.com[i], robot.bodies.inertia[i])
    return body


def _add_motor_hinge(body: mujoco.MjsBody, robot: RobotDescription, i: int) -> None:
    body.add_joint(
        name=motor_joint(robot.joints[i]),
        type=_joint_type(robot, i),
        axis=robot.kinematics.axis[i],
        limited=True,
        range=robot.kinematics.range[i],
    )


def _joint_type(robot: RobotDescription, i: int) -> mujoco.mjtJoint:
    return mujoco.mjtJoint.mjJNT_SLIDE if robot.kinematics.is_sliding[i] else mujoco.mjtJoint.mjJNT_HINGE


def _add_tool(flange: mujoco.MjsBody, robot: RobotDescription) -> None:
    """Tool body in the tool0 frame, with sites for tool0 and the TCP."""
    assert robot.tool is not None
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, robot.tool.rotation.flatten())
    tool = flange.add_body(name="tool", pos=robot.tool.position, quat=quat)
    _set_inertial(tool, robot.tool.mass, robot.tool.com, robot.tool.inertia)
    tool.add_site(name="tool0", size=[0.004, 0.004, 0.004])
    tool.add_site(name="tcp", pos=robot.tool.tcp, size=[0.004, 0.004, 0.004], rgba=[0.1, 0.4, 1, 1])


def _set_inertial(body: mujoco.MjsBody, mass: float, com: np.ndarray, inertia: np.ndarray) -> None:
    """Mass [kg], centre of mass [m] and inertia [kg m^2] (xx, yy, zz, xy, xz, yz) about it."""
    body.explicitinertial = True
    body.mass = mass
    body.ipos = com
    if np.any(inertia):
        body.fullinertia = inertia


def _add_spring(spec: mujoco.MjSpec, spring: Spring) -> None:
    """Tendon that pulls two bodies together with a force that is a cubic of its elongation."""
    ends = zip(("start", "end"), spring.bodies, (spring.start, spring.end), strict=True)
    tendon = spec.add_tendon(
        name=spring_tendon(spring.name), stiffness=spring.stiffness, springlength=[spring.length, spring.length]
    )
    for end, body, point in ends:
        site = spec.body(body).add_site(name=f"{spring.name}_{end}", pos=point, size=[0.01, 0.01, 0.01])
        tendon.wrap_site(site.name)
