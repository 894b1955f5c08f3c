"""One function builds the MuJoCo model of any described robot; everything that simulates uses it.

Each joint is two hinges on one axis (thesis (2.5)-(2.6)): the motor hinge turns by motor angle / gear ratio and carries
rotor inertia, friction and servo; the deflection hinge behind it is the elasticity, and carries the link. Actuators
have `gear` = gear ratio, so that their numbers stay in motor units. MuJoCo supplies servo (`pid`) and friction (passive
`dcmotor` with LuGre bristles) natively.
"""

from dataclasses import dataclass

import mujoco
import numpy as np

from ffgym.errors import check_number
from ffgym.robot.description import RobotDescription
from ffgym.robot.looks import add_looks

MASSLESS = 1e-9
"""Mass [kg] and inertia [kg m^2] of the rotor bodies: MuJoCo wants a moving body to weigh something."""

_SERVO_INPUTS = mujoco.mjtCtrlInput.mjINPUT_POS | mujoco.mjtCtrlInput.mjINPUT_VEL | mujoco.mjtCtrlInput.mjINPUT_FF


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
    physics_dt: float | None = None
    """Physics step [s]; None takes the description's."""
    looks: bool = True
    """Geoms, lights and a floor."""

    def __post_init__(self) -> None:
        if self.physics_dt is not None:
            check_number("physics_dt", self.physics_dt, unit="s", low=0.0, open_low=True)


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
        body = _add_joint(spec, body, robot, i, options)
    if robot.tool is not None:
        _add_tool(body, robot)
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


def _add_joint(
    spec: mujoco.MjSpec, parent: mujoco.MjsBody, robot: RobotDescription, i: int, options: ModelOptions
) -> mujoco.MjsBody:
    """Motor hinge, deflection hinge and link of joint i; returns the link."""
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
            axis=axis,
            stiffness=[drive.joint_stiffness[i], 0, 0],
            damping=[drive.joint_damping[i], 0, 0],
        )
    else:
        body = parent.add_body(name=link, pos=robot.kinematics.position[i])
        _add_motor_hinge(body, robot, i)
    _set_inertial(body, robot.bodies.mass[i], robot.bodies.com[i], robot.bodies.inertia[i])
    if options.servo:
        _add_servo(spec, robot, i)
    if options.friction:
        _add_friction(spec, robot, i)
    return body


def _add_motor_hinge(body: mujoco.MjsBody, robot: RobotDescription, i: int) -> None:
    limits = robot.kinematics.range[i]
    body.add_joint(name=motor_joint(robot.joints[i]), axis=robot.kinematics.axis[i], limited=True, range=limits)


def _add_servo(spec: mujoco.MjSpec, robot: RobotDescription, i: int) -> None:
    """PID with set-points for position, velocity and feed-forward torque; its integral is clamped."""
    servo, peak = robot.servo, robot.drive.peak_torque[i]
    integral_gain = servo.integral_gain[i]
    actuator = spec.add_actuator(
        name=servo_actuator(robot.joints[i]),
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        target=motor_joint(robot.joints[i]),
        gear=[robot.drive.gear_ratio[i], 0, 0, 0, 0, 0],
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


def _add_friction(spec: mujoco.MjSpec, robot: RobotDescription, i: int) -> None:
    """LuGre friction of motor i: a motor without electrics, whose bristles MuJoCo integrates exactly."""
    f = robot.friction
    actuator = spec.add_actuator(
        name=friction_actuator(robot.joints[i]),
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        target=motor_joint(robot.joints[i]),
        gear=[robot.drive.gear_ratio[i], 0, 0, 0, 0, 0],
        damping=[f.viscous[i], 0, 0],
    )
    actuator.set_to_dcmotor(
        motorconst=[0, 0],
        resistance=1.0,  # must be positive, acts on nothing: the electrical branch is off
        lugre=[f.bristle_stiffness[i], f.bristle_damping[i], f.coulomb[i], f.static[i], f.stribeck_velocity[i]],
        ctrlspec=int(mujoco.mjtCtrlInput.mjINPUT_NONE),
    )


def _add_tool(flange: mujoco.MjsBody, robot: RobotDescription) -> None:
    """Tool body in the tool0 frame, with sites for tool0 and the TCP."""
    assert robot.tool is not None
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, robot.tool.rotation.flatten())
    tool = flange.add_body(name="tool", quat=quat)
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
