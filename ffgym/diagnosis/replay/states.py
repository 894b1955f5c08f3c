"""States of a machine along measured motions, as effects see them."""

from dataclasses import replace

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.replay.bristles import Bristles
from ffgym.diagnosis.replay.springs import Deflection
from ffgym.effects import State, Torques
from ffgym.robot import RobotDescription
from ffgym.simulation.plant import Climate, Machine


def state_of(log: Log, machine: Machine, bristles: Bristles) -> State:
    """States along the measured motion, before anything is known of springs and loads."""
    robot, none = machine.physical, np.zeros_like(log.q)
    drive, friction = robot.drive, robot.friction
    stiff = np.where(drive.is_rigid, 0.0, drive.joint_stiffness)
    return State(
        time=log.t[:, None, None],
        motor_angle=drive.motor_angle(log.q),
        motor_speed=drive.motor_angle(log.dq),
        joint_angle=log.q,
        joint_speed=log.dq,
        deflection=none,
        deflection_rate=none,
        load=none,
        load_at_motor=none,
        joint_stiffness=stiff,
        joint_damping=np.where(drive.is_rigid, 0.0, drive.joint_damping),
        friction_sign=bristles.sign,
        coulomb=friction.coulomb,
        static=friction.static,
        viscous=friction.viscous,
        stribeck_velocity=friction.stribeck_velocity,
        feedback_torque=none if log.feedback is None else log.feedback,
        motor_torque=none,
        peak_torque=drive.peak_torque,
        temperature=_temperature(log, machine),
        running=_running(log, machine),
    )


def bent_state(state: State, bent: Deflection, robot: RobotDescription) -> State:
    """States with the deflections of the joints, and what their springs alone carry."""
    load = -(state.joint_stiffness * bent.angle + state.joint_damping * bent.rate)
    return replace(
        state,
        deflection=bent.angle,
        deflection_rate=bent.rate,
        load=load,
        load_at_motor=robot.drive.motor_torque(load),
    )


def loaded_state(state: State, added: Torques, needed: Array, robot: RobotDescription) -> State:
    """States whose load has what effects add to the springs; that of rigid joints is what links ask for.

    Args:
        state: with the load of the springs alone.
        added: by effects behind the gearboxes.
        needed: torque that links ask for, link side [N m], (T, M, N).
        robot: says which joints are rigid.
    """
    rigid = robot.drive.is_rigid
    if added.spring is None and not rigid.any():
        return state
    load = state.load if added.spring is None else state.load + added.spring
    load = np.where(rigid, needed, load)
    return replace(state, load=load, load_at_motor=robot.drive.motor_torque(load))


def _running(log: Log, machine: Machine) -> Array:
    """Time since the machine was switched on, or its session began [s], (T, M, 1)."""
    before = 0.0 if machine.climate is None else machine.climate.running_since
    times: Array = before + log.started[:, None] + log.t[:, None, None]
    return times


def _temperature(log: Log, machine: Machine) -> Array:
    """[degC], (T, M, N): measured, else by the machine's climate, else that of its default."""
    if log.temperature is not None:
        return log.temperature
    climate, times = machine.climate or Climate(), log.t
    n = log.robot.n_joints
    if machine.climate is None:
        return climate.temperature(times, n)[:, None] + np.zeros((1, len(log.recordings), 1))
    return np.stack([climate.at(climate.running_since + s).temperature(times, n) for s in log.started], axis=1)
