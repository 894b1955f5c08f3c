"""Recordings of arms whose truth is known: rigid ones by inverse dynamics, whole machines by simulation."""

from dataclasses import replace

import numpy as np

from ffgym.paths import joint_reference, multisine
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, log_header, motor_torque
from ffgym.simulation import Run, TorqueSensor, sensors_of, simulate

FREQUENCIES = 0.1 * np.arange(1, 6)


def swing(robot, seed, duration=20.0):
    """Sines on all joints, as large as 80 % of speeds and half of the ranges allow."""
    rng = np.random.default_rng(seed)
    low, high = robot.kinematics.range.T
    centre = (low + high) / 2 if robot.work_area is None else robot.work_area.home
    phases = rng.uniform(0, 2 * np.pi, (len(FREQUENCIES), robot.n_joints))
    amplitude = rng.normal(size=phases.shape)

    def path():
        return multisine(centre, amplitude, FREQUENCIES, phases, duration, ramp=1.0, dt=robot.servo.control_dt)

    sizes = np.stack([
        np.abs(path().dq).max(axis=0) / (0.8 * robot.kinematics.max_speed),
        np.abs(path().q - centre).max(axis=0) / (0.5 * np.minimum(high - centre, centre - low)),
    ])  # fmt: skip
    amplitude /= sizes.max(axis=0)
    return path()


def rigid(robot):
    """The robot with rigid joints."""
    n = robot.n_joints
    return replace(robot, drive=replace(robot.drive, joint_stiffness=np.full(n, np.inf), joint_damping=np.zeros(n)))


def recorded(robot, path, noise=0.0, seed=0, extra=None, segment=""):
    """What a rigid robot would log on a path: motor torque with white noise, a share of each motor's RMS torque.

    Args:
        robot: with rigid joints.
        path: joint motion.
        noise: standard deviation over RMS torque.
        seed: of the noise.
        extra: function of the path that gives more torque, motor side (T, N).
        segment: name of the motion.
    """
    torque = motor_torque(RigidArm(robot), path.q, path.dq, path.ddq).total
    if extra is not None:
        torque = torque + extra(path)
    torque += np.random.default_rng(seed).normal(size=torque.shape) * noise * np.sqrt(np.mean(torque**2, axis=0))
    position = path.q if robot.logs.position == "link" else robot.drive.motor_angle(path.q)
    effort = robot.drive.joint_torque(torque) if robot.logs.torque == "link_side" else torque
    columns = {"timestamp": path.t}
    for j, joint in enumerate(robot.joints):
        columns |= {f"motor.position.{joint}": position[:, j], f"motor.effort.{joint}": effort[:, j]}
    return Recording(columns, log_header(robot, segment=segment))


def simulated(robot, seeds, noise=0.005, duration=20.0):
    """Recordings of simulated machines, elastic joints and LuGre friction, with resolvers and noise on the torque."""
    runs = [Run(reference=joint_reference(robot, swing(robot, seed, duration))) for seed in seeds]
    sensors = (*sensors_of(robot), TorqueSensor(noise=noise * robot.drive.peak_torque))
    return simulate(runs, sensors=sensors, seed=seeds[0], record_dt=0.002)


def mistaken(robot, size=0.3, seed=0):
    """The robot as someone describes it who is off by a factor of about exp(+-size) in masses, rotors and friction."""
    rng = np.random.default_rng(seed)
    n, bodies = robot.n_joints, robot.bodies

    def factors():
        return np.exp(rng.normal(scale=size, size=n))

    mass = factors()
    links = replace(
        bodies,
        mass=bodies.mass * mass,
        com=bodies.com * factors()[:, None],
        inertia=bodies.inertia * (mass * factors())[:, None],
    )
    drive = replace(robot.drive, rotor_inertia=robot.drive.rotor_inertia * factors())
    friction = robot.friction.scale(coulomb=np.full(n, 1.4), static=np.full(n, 1.4), viscous=np.full(n, 0.7))
    return replace(robot, bodies=links, drive=drive, friction=friction)
