"""Distance of the physics step from the limit of small steps: docs/physics.md, in about half a minute."""

from collections.abc import Sequence
from dataclasses import replace

import mujoco
import numpy as np
from scipy.integrate import solve_ivp

from ffgym.core.types import Array
from ffgym.paths import RADII, SPEEDS
from ffgym.robot import ModelOptions, RigidArm, RobotDescription, load_robot, solve_path
from ffgym.simulation.plant import Plant, PlantState
from ffgym.studies import CircleStudy, circle_study
from scripts.tables.page import Contents, markdown

STEPS = tuple(0.002 / 2**k for k in range(6))
"""Physics steps of the LuGre table [s]."""
ENERGY_STEPS = tuple(0.0005 / 2**k for k in range(5))
"""Physics steps of the energy table [s]; an undamped arm is unstable above 1 ms, 2 / (2 pi 300 Hz)."""
TORQUE, FREQUENCY = 1.0, 2.0
"""Sinusoidal motor torque of the LuGre table [N m], [Hz]: about twice the breakaway torque."""
BENT = 2e-3
"""Size of the deflection that the energy table starts from [rad]."""
METRICS = ("rms_mm", "max_mm", "rms_3d_mm", "max_3d_mm", "motor_rms_rad")


def convergence(
    robot: str = "irb4600_60_205",
    steps: Sequence[float] = STEPS,
    energy_steps: Sequence[float] = ENERGY_STEPS,
    duration: float = 1.0,
    positions: Sequence[str] | None = None,
    speeds: Sequence[float] = SPEEDS,
    radii: Sequence[float] = RADII,
) -> Contents:
    """All tables of the page: LuGre friction on one axis over a duration [s], energy, and circles, on a robot.

    Physics steps [s] are each half the one before; circles at all positions if none are given.
    """
    described = load_robot(robot)
    halved = ModelOptions(physics_dt=described.physics_dt / 2, looks=False)
    coarse, fine = (
        circle_study(described, positions=positions, speeds=speeds, radii=radii, options=options)
        for options in (None, halved)
    )
    head = ("speed [mm/s]", "metric", "median change [%]", "worst change [%]", "worst law", "largest change")
    changes = [_change(coarse, fine, speed, metric) for speed in speeds for metric in METRICS]
    errors, drift = lugre_errors(load_robot("one_axis"), steps, duration), energy_drift(described, energy_steps)
    lugre = [
        [f"{step * 1e3:g}", f"{dq * 1e3:.4g}", f"{z * 1e6:.4g}", *orders]
        for step, (dq, z), orders in zip(steps, errors, _orders(errors), strict=True)
    ]
    energies = [
        [f"{step * 1e3:g}", f"{energy:.3g}", f"{100 * energy / swing:.2g}", order]
        for step, (energy, swing), (order, _) in zip(energy_steps, drift, _orders(drift), strict=True)
    ]
    of_lugre = ("speed error [mrad/s]", "bristle error [µrad]", "order (speed)", "order (bristle)")
    of_energy = ("energy drift [J]", "share of the spring energy [%]", "order")
    return Contents(
        parts={
            "lugre": markdown(("physics_dt [ms]", *of_lugre), lugre),
            "energy": markdown(("physics_dt [ms]", *of_energy), energies),
            "circles": markdown(head, changes),
        }
    )


def free_of_servo(robot: RobotDescription) -> RobotDescription:
    """Copy whose servos pass the feed-forward torque on and do nothing else that could be seen."""
    nothing = np.zeros(robot.n_joints)
    servo = replace(robot.servo, position_gain=nothing + 1e-12, velocity_gain=nothing, integral_gain=nothing)
    return replace(robot, servo=servo)


def lugre_errors(robot: RobotDescription, steps: Sequence[float], duration: float) -> Array:
    """Largest error of motor speed [rad/s] and bristle deflection [rad] of a one-axis robot, shape (steps, 2).

    The motor gets a sinusoidal torque; truth is Radau's implicit Runge-Kutta method at a relative tolerance of 1e-10.
    """
    robot = free_of_servo(robot)
    t = np.arange(1.0, round(duration / max(steps)) + 1) * max(steps)
    truth = _lugre_truth(robot, t)
    errors = []
    for step in steps:
        plant = Plant(robot, 1, options=ModelOptions(physics_dt=step, looks=False))
        plant.rest(np.zeros((1, 1)))
        n = round(duration / step)
        controls = np.zeros((1, n, plant.model.nu))
        _, _, torque = plant.split_controls(controls)
        torque[0, :, 0] = TORQUE * np.sin(2 * np.pi * FREQUENCY * np.arange(n) * step)
        state = plant.unpack(*plant.advance(controls))
        every = slice(round(max(steps) / step) - 1, None, round(max(steps) / step))
        seen = np.stack([state.motor_velocity[0, every, 0], state.bristle[0, every, 0]], axis=1)
        errors.append(np.abs(seen - truth).max(axis=0))
    return np.array(errors)


def _lugre_truth(robot: RobotDescription, t: Array) -> Array:
    """Motor speed and bristle deflection at times `t`, shape (T, 2)."""
    friction, ratio = robot.friction, robot.drive.gear_ratio[0]
    inertia = robot.drive.rotor_inertia[0] + robot.bodies.inertia[0, 2] / ratio**2

    def rates(time: float, state: Array) -> list[float]:
        dq, z = state[:1], state[1:]
        torque = TORQUE * np.sin(2 * np.pi * FREQUENCY * time)
        return [(torque - friction.torque(z, dq)[0]) / inertia, friction.bristle_rate(z, dq)[0]]

    span = (0.0, float(t[-1]))
    solution = solve_ivp(rates, span, [0.0, 0.0], method="Radau", rtol=1e-10, atol=1e-12, t_eval=t)
    return np.asarray(solution.y.T)


def energy_drift(robot: RobotDescription, steps: Sequence[float], duration: float = 0.2) -> Array:
    """Largest change of total energy, and the swing of its spring part [J], shape (steps, 2).

    The arm has no friction, damping or servo; it starts at rest with every spring bent, swings and falls under gravity.
    """
    undamped = replace(robot.drive, joint_damping=np.zeros(robot.n_joints))
    robot = replace(free_of_servo(robot), drive=undamped)
    arm = RigidArm(robot)
    if robot.work_area is None:
        start = np.zeros((1, robot.n_joints))
    else:
        area = robot.work_area
        start = solve_path(arm, next(iter(area.positions.values()))[None], area.tool_rotation, area.home)
    drifts = []
    for step in steps:
        plant = Plant(robot, 1, options=ModelOptions(friction=False, physics_dt=step, looks=False))
        plant.rest(start)
        signs = np.resize([1.0, -1.0, 1.0, 1.0, -1.0, 1.0], robot.n_joints)
        plant.batch.qpos[:, plant.addresses.deflection_qpos] += BENT * signs
        first = plant.batch.qpos.copy(), plant.batch.qvel.copy()
        qpos, qvel, _ = plant.advance(np.zeros((1, round(duration / step), plant.model.nu)))
        rows = slice(None, None, max(1, round(0.00025 / step)))
        total, springs = _energies(plant, np.vstack([first[0], qpos[0, rows]]), np.vstack([first[1], qvel[0, rows]]))
        drifts.append([np.abs(total - total[0]).max(), np.ptp(springs)])
    return np.array(drifts)


def _energies(plant: Plant, qpos: Array, qvel: Array) -> tuple[Array, Array]:
    """Total energy and energy of the springs [J] at states (T, nq), (T, nv)."""
    model, data = plant.model, mujoco.MjData(plant.model)
    total = np.empty(len(qpos))
    for row in range(len(qpos)):
        data.qpos, data.qvel = qpos[row], qvel[row]
        mujoco.mj_forward(model, data)
        mujoco.mj_energyPos(model, data)
        mujoco.mj_energyVel(model, data)
        total[row] = data.energy.sum()
    state: PlantState = plant.unpack(qpos, qvel, np.zeros((len(qpos), model.na)))
    drive = plant.robot.drive
    deflection = state.link_position - state.motor_position / drive.gear_ratio
    elastic = np.where(drive.is_rigid, 0.0, drive.joint_stiffness)
    return total, 0.5 * (elastic * deflection**2).sum(axis=1)


def _change(coarse: CircleStudy, fine: CircleStudy, speed: float, metric: str) -> list[str]:
    """One row: relative change over all laws, positions, radii (and joints), and the largest absolute one."""
    pairs = [
        (a.agent, x, y)
        for a, b in zip(coarse.cells, fine.cells, strict=True)
        if a.speed_mm_s == round(speed * 1e3, 6)
        for x, y in zip(np.atleast_1d(getattr(a, metric)), np.atleast_1d(getattr(b, metric)), strict=True)
    ]
    difference = np.array([abs(x - y) for _, x, y in pairs])
    relative = difference / np.array([y for _, _, y in pairs])
    unit = "mrad" if metric.endswith("rad") else "µm"
    return [
        f"{speed * 1e3:g}",
        metric,
        f"{100 * np.median(relative):.3g}",
        f"{100 * relative.max():.3g}",
        pairs[int(np.argmax(relative))][0],
        f"{1e3 * difference.max():.2g} {unit}",
    ]


def _orders(errors: Array) -> list[list[str]]:
    """Observed order of each column from one row to the next, empty in the first row."""
    orders = np.log2(errors[:-1] / errors[1:])
    return [[""] * errors.shape[1], *([f"{order:.2f}" for order in row] for row in orders)]
