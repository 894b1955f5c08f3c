"""Robots by chance: one to seven axes, heavy and light, rigid and elastic, with motors and servos that fit them."""

import numpy as np

from ffgym.core.types import Array
from ffgym.robot.description import RobotDescription
from ffgym.robot.drive import Drive
from ffgym.robot.friction import LuGreParameters
from ffgym.robot.parts import Kinematics, Links, Sensors, Servo, Tool, WorkArea
from scripts.exam.independent.arm import bodies_of, inverse_dynamics, mass_and_bias

_GRAVITY = np.array([0.0, 0.0, -9.81])

_LINE = "zyyxyxz"
"""Axes of an arm, base first, of which a robot has the first; of one or two axes, others are drawn, too."""

_LEAST = 0.02
"""Least inertia of a rotor behind its gearbox, over the largest of the arm; chosen: motors of wrists are not as small
as what they carry."""

_POSES = 8
"""Poses over which the load of a joint is taken."""


def draw_robot(n: int, *, elastic: bool, rng: np.random.Generator) -> RobotDescription:
    """Description of a robot of `n` joints; all of them rigid, or all elastic."""
    kinematics, bodies, tool = _arm(n, rng)
    home = rng.uniform(-0.4, 0.4, n)
    if n > 2:
        home[1:3] += (0.5, -0.9)
    motors = _motors(kinematics, bodies, tool, home, elastic, rng)
    return _describe(kinematics, bodies, tool, home, *motors, rng)


def _arm(n: int, rng: np.random.Generator) -> tuple[Kinematics, Links, Tool]:
    axes = rng.choice(list("zyx"), size=n) if n < 3 else np.array(list(_LINE[:n]))
    size = np.exp(rng.uniform(np.log(0.4), np.log(1.3)))
    position, mass, com, inertia = [], [], [], []
    for i in range(n):
        far = i in (0, 1, 2, 3) or n < 3
        length = size * (rng.uniform(0.35, 0.7) if far else rng.uniform(0.05, 0.2))
        along = np.array([1.0, 0.0, 0.25]) if i % 2 else np.array([0.5, 0.0, 0.8])
        position.append(length * along if i else np.array([0.0, 0.0, 0.5]))
        weight = 60 * size**2 * 0.55**i * rng.uniform(0.6, 1.4)
        reach = size * (0.45 if far else 0.12)
        mass.append(weight)
        com.append(reach * np.array([rng.uniform(0.3, 0.6), rng.uniform(-0.1, 0.1), rng.uniform(-0.1, 0.2)]))
        inertia.append(_inertia(weight, reach, rng))
    kinematics = Kinematics(
        position=np.array(position),
        axis=np.array([rng.choice([-1.0, 1.0]) * np.eye(3)["xyz".index(str(a))] for a in axes]),
        range=np.tile([-3.0, 3.0], (n, 1)),
        max_speed=np.exp(rng.uniform(np.log(1.2), np.log(3.0), n)) / np.sqrt(size),
    )
    links = Links(mass=np.array(mass), com=np.array(com), inertia=np.array(inertia))
    weight = 4 * size**2 * rng.uniform(0.5, 2.0)
    tool = Tool(
        rotation=np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]),
        position=np.array([size * (0.45 if n < 3 else 0.1), 0.0, 0.0]),
        tcp=np.array([rng.uniform(-0.05, 0.05), rng.uniform(-0.05, 0.05), size * 0.15]),
        mass=weight,
        com=np.array([0.0, 0.0, size * 0.08]),
        inertia=_inertia(weight, 0.1 * size, rng),
    )
    return kinematics, links, tool


def _inertia(mass: float, reach: float, rng: np.random.Generator) -> Array:
    """Inertia of a box about as long as twice the reach, in the order of descriptions."""
    a, b, c = (2 * reach * np.array([1.0, 0.35, 0.35]) * rng.uniform(0.7, 1.3, 3)) ** 2
    return mass / 12 * np.array([b + c, a + c, a + b, 0.0, 0.0, 0.0])


def _motors(
    kinematics: Kinematics, bodies: Links, tool: Tool, home: Array, elastic: bool, rng: np.random.Generator
) -> tuple[Drive, LuGreParameters]:
    n = len(home)
    carried, holding = _load(kinematics, bodies, tool, home, rng)
    ratio = np.exp(rng.uniform(np.log(40), np.log(160), n)) * rng.choice([-1.0, 1.0, 1.0], n)
    rotor = np.maximum(carried * rng.uniform(0.4, 2.0, n), _LEAST * carried.max()) / ratio**2
    lively = kinematics.max_speed * 2 * np.pi * 1.5 * (carried + ratio**2 * rotor)
    needed = (holding + lively) / np.abs(ratio)
    coulomb = needed * rng.uniform(0.05, 0.2, n)
    fastest = kinematics.max_speed * np.abs(ratio)
    frequency = rng.uniform(9, 20) * np.exp(0.25 * np.arange(n)) if elastic else np.full(n, np.inf)
    stiffness = (2 * np.pi * frequency) ** 2 * carried
    damping = 2 * rng.uniform(0.02, 0.08, n) * np.sqrt(np.where(elastic, stiffness, 0.0) * carried)
    total = rotor + carried / ratio**2
    bristle = coulomb / rng.uniform(0.004, 0.012, n)
    drive = Drive(
        gear_ratio=ratio,
        rotor_inertia=rotor,
        joint_stiffness=stiffness,
        joint_damping=damping,
        peak_torque=4 * needed,
    )
    friction = LuGreParameters(
        coulomb=coulomb,
        static=coulomb * rng.uniform(1.0, 1.25, n),
        viscous=coulomb * rng.uniform(0.4, 2.0, n) / fastest,
        stribeck_velocity=fastest * np.exp(rng.uniform(np.log(0.002), np.log(0.03), n)),
        bristle_stiffness=bristle,
        bristle_damping=0.6 * np.sqrt(bristle * total),
    )
    return drive, friction


def _load(
    kinematics: Kinematics, links: Links, tool: Tool, home: Array, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Mean diagonal of the mass matrix [kg m^2], and largest torque of gravity [N m], over some poses, shape (N,)."""
    n, one = len(home), np.ones(len(home))
    fake = Drive(
        gear_ratio=one, rotor_inertia=one, joint_stiffness=one * np.inf, joint_damping=0 * one, peak_torque=one
    )
    friction = LuGreParameters(
        coulomb=one, static=one, viscous=one, stribeck_velocity=one, bristle_stiffness=one, bristle_damping=one
    )
    bodies = bodies_of(_describe(kinematics, links, tool, home, fake, friction, rng), _POSES)
    q = home + rng.uniform(-0.6, 0.6, (_POSES, n))
    still = np.zeros_like(q)
    matrix, _ = mass_and_bias(bodies, q, still)
    holding = inverse_dynamics(bodies, q, still, still)
    return np.einsum("bii->bi", matrix).mean(axis=0), np.abs(holding).max(axis=0)


def _describe(
    kinematics: Kinematics,
    links: Links,
    tool: Tool,
    home: Array,
    drive: Drive,
    friction: LuGreParameters,
    rng: np.random.Generator,
) -> RobotDescription:
    n = len(home)
    inertia = drive.rotor_inertia * np.where(drive.is_rigid, 2.0, 1.0)  # of rigid joints with what they carry
    speed = 250 * inertia
    return RobotDescription(
        name="drawn",
        title=f"Robot of {n} axes, drawn",
        joints=tuple(f"a{i + 1}" for i in range(n)),
        links=tuple(f"link{i + 1}" for i in range(n)),
        kinematics=kinematics,
        base_mass=100.0,
        base_com=np.zeros(3),
        bodies=links,
        tool=tool,
        drive=drive,
        friction=friction,
        servo=Servo(position_gain=50 * speed, velocity_gain=speed, integral_gain=400 * speed, control_dt=0.004),
        sensors=Sensors(encoder_bits=18, tracker_noise=2e-5, tracker_period=0.001),
        physics_dt=0.00025,
        gravity=_GRAVITY,
        work_area=WorkArea(positions={}, home=home) if rng.random() < 0.7 else None,
    )
