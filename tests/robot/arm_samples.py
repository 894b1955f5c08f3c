"""Serial arms of many kinds for tests: known ones with round numbers, and random ones."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from ffgym.robot import RobotDescription
from ffgym.robot.drive import Drive
from ffgym.robot.friction import LuGreParameters
from ffgym.robot.parts import Kinematics, Links, Sensors, Servo, Tool, WorkArea

X, Y, Z = np.eye(3)
DOWN = np.diag([1.0, -1.0, -1.0])
"""Orientation of a tool that points down."""


def make_arm(name, types, position, axis, *, tcp=(0.0, 0.0, 0.1), flange=None, home=None, limits=None):
    """Arm with the given chain; masses, drives and friction are round numbers.

    Args:
        name: of the robot.
        types: a letter per joint, 'R' turns and 'P' slides.
        position: origin of each joint in the previous link frame [m], shape (N, 3).
        axis: of each joint, shape (N, 3).
        tcp: in tool0 [m].
        flange: orientation of tool0 in the last link frame; None is none.
        home: joint positions that seed the inverse kinematics; None is a work area without.
        limits: joint range (N, 2); None is +-3 rad, or 1 m.
    """
    n, axis = len(types), np.asarray(axis, dtype=np.float64)
    slides = np.array([kind == "P" for kind in types])
    ends = np.where(slides, 1.0, 3.0)
    return RobotDescription(
        name=name,
        title=name,
        joints=tuple(f"j{i + 1}" for i in range(n)),
        links=tuple(f"link{i + 1}" for i in range(n)),
        kinematics=Kinematics(
            position=np.asarray(position, dtype=np.float64),
            axis=axis / np.linalg.norm(axis, axis=1, keepdims=True),
            range=np.stack([-ends, ends], axis=1) if limits is None else np.asarray(limits, dtype=np.float64),
            max_speed=np.where(slides, 1.0, 3.0),
            types=tuple("slide" if slide else "hinge" for slide in slides),
        ),
        base_mass=10.0,
        base_com=np.zeros(3),
        bodies=Links(
            mass=np.linspace(12.0, 3.0, n),
            com=np.tile([0.05, 0.02, 0.1], (n, 1)),
            inertia=np.tile([0.2, 0.25, 0.15, 0.01, 0.02, -0.01], (n, 1)),
        ),
        tool=Tool(rotation=np.eye(3) if flange is None else np.asarray(flange), tcp=np.asarray(tcp, dtype=np.float64)),
        drive=Drive(
            gear_ratio=np.where(slides, 600.0, 100.0),
            rotor_inertia=np.full(n, 5e-4),
            joint_stiffness=np.where(slides, 5e6, 5e4),
            joint_damping=np.where(slides, 4e3, 40.0),
            peak_torque=np.full(n, 20.0),
        ),
        friction=LuGreParameters(
            coulomb=np.full(n, 0.1),
            static=np.full(n, 0.12),
            viscous=np.full(n, 0.002),
            stribeck_velocity=np.full(n, 0.5),
            bristle_stiffness=np.full(n, 20.0),
            bristle_damping=np.full(n, 0.05),
        ),
        servo=Servo(
            position_gain=np.full(n, 2.0),
            velocity_gain=np.full(n, 0.06),
            integral_gain=np.full(n, 10.0),
            control_dt=0.004,
        ),
        sensors=Sensors(encoder_bits=16, tracker_noise=0.0, tracker_period=0.0),
        physics_dt=0.00025,
        gravity=np.array([0.0, 0.0, -9.81]),
        work_area=None if home is None else WorkArea(positions={}, home=np.asarray(home, dtype=np.float64)),
    )


def two_link():
    """Two bars in the vertical x-z plane; they hang along x at q = 0."""
    return make_arm("two_link", "RR", [Z, 0.5 * X], [Y, Y], tcp=0.4 * X, home=[-1.0, 1.5])


def three_link():
    """Three bars in the vertical x-z plane: one to spare for a position, none for a pose in the plane."""
    return make_arm("three_link", "RRR", [Z, 0.5 * X, 0.4 * X], [Y, Y, Y], tcp=0.3 * X, home=[-1.0, 1.2, 0.8])


def scara():
    """Two bars in the horizontal plane, a slide down and a turn about it; the tool always points down."""
    return make_arm(
        "scara", "RRPR", [0.6 * Z, 0.4 * X, 0.3 * X, 0 * Z], [Z, Z, -Z, -Z], tcp=0.1 * Z, flange=DOWN,
        home=[0.4, 0.9, 0.1, 0.0],
    )  # fmt: skip


def five_axis():
    """Base, shoulder, elbow and wrist that turns and rolls: any position, but not any orientation."""
    return make_arm(
        "five_axis", "RRRRR", [0.2 * Z, 0.2 * Z, 0.5 * Z, 0.4 * X, 0.1 * X], [Z, Y, Y, Y, X], tcp=0.1 * Z,
        flange=[[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]], home=[0.1, 0.3, 0.2, 0.9, 0.0],
    )  # fmt: skip


def ur_like():
    """Six hinges in the order of a UR5e, rounded to cm: offset wrist, no spherical one."""
    return make_arm(
        "ur_like", "RRRRRR", [0.16 * Z, 0.13 * Y, 0.43 * X - 0.13 * Y, 0.39 * X, 0.13 * Y, -0.1 * Z],
        [Z, Y, Y, Y, -Z, Y], tcp=[0.0, 0.0, 0.12], flange=Rotation.from_euler("x", -90, degrees=True).as_matrix(),
        home=[0.2, -1.2, 1.5, 1.2, -1.5, 0.1], limits=np.tile([-2 * np.pi, 2 * np.pi], (6, 1)),
    )  # fmt: skip


def seven_axis():
    """Shoulder, elbow and wrist of an anthropomorphic arm with seven hinges, rounded to cm."""
    return make_arm(
        "seven_axis", "RRRRRRR", [0.16 * Z, 0.2 * Z, 0.2 * Z, 0.2 * Z, 0.2 * Z, 0.2 * Z, 0.1 * Z],
        [Z, Y, Z, -Y, Z, Y, Z], tcp=0.05 * Z, home=[0.2, 0.6, 0.1, 1.4, 0.1, 0.9, 0.0],
    )  # fmt: skip


def on_a_track():
    """`ur_like` on a rail: a slide before six hinges."""
    arm = ur_like()
    k = arm.kinematics
    return make_arm(
        "on_a_track", "PRRRRRR", [0.2 * Z, *k.position], [X, *k.axis], tcp=arm.tool.tcp, flange=arm.tool.rotation,
        home=[0.0, *arm.work_area.home],
    )  # fmt: skip


def gantry():
    """Three slides along x, y and z, and the tool down."""
    return make_arm("gantry", "PPP", [Z, 0 * X, 0 * X], [X, Y, Z], flange=DOWN, home=[0.1, 0.0, 0.2])


def cylindrical():
    """Slide up, turn about it, slide out: PRP."""
    return make_arm("cylindrical", "PRP", [0.3 * Z, 0.2 * X, 0.2 * X], [Z, Z, X], tcp=0.1 * X, home=[0.2, 0.5, 0.3])


ARMS = {
    make.__name__: make
    for make in (two_link, three_link, scara, five_axis, ur_like, seven_axis, on_a_track, gantry, cylindrical)
}
"""Every known arm by name, to be called."""


def random_arm(types, seed):
    """Arm with the joints `types`, e.g. 'RRPR', and random axes, offsets, masses, inertias and tool."""
    rng, n = np.random.default_rng(seed), len(types)
    arm = make_arm(
        f"random_{types}", types, rng.uniform(-0.5, 0.5, (n, 3)), rng.normal(size=(n, 3)),
        tcp=rng.uniform(-0.3, 0.3, 3), flange=Rotation.random(random_state=seed).as_matrix(), home=np.zeros(n),
    )  # fmt: skip
    bodies = [_random_body(rng) for _ in range(n + 1)]
    masses, coms, inertias = (np.array(part) for part in zip(*bodies, strict=True))
    tool = replace(arm.tool, position=rng.uniform(-0.1, 0.1, 3), mass=masses[n], com=coms[n], inertia=inertias[n])
    return replace(arm, bodies=Links(mass=masses[:n], com=coms[:n], inertia=inertias[:n]), tool=tool)


def _random_body(rng):
    """Mass [kg], centre of mass [m] and inertia [kg m^2] of five random points."""
    points, weights = rng.uniform(-0.3, 0.3, (5, 3)), rng.uniform(0.5, 3.0, 5)
    com = weights @ points / weights.sum()
    away = points - com
    moment = np.einsum("k,ki,kj->ij", weights, away, away)
    tensor = np.trace(moment) * np.eye(3) - moment
    return weights.sum(), com, [tensor[i] for i in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
