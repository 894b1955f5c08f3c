"""Torques of all that a rigid arm can be wrong in: one column for each of its base parameters."""

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.identification.rigid_body.arm_terms import Bodies
from ffgym.diagnosis.identification.rigid_body.base import base_parameters
from ffgym.diagnosis.identification.rigid_body.link_motion import rigid_motion
from ffgym.diagnosis.identification.rigid_body.motor_terms import RotorInertia
from ffgym.diagnosis.replay import Replay
from ffgym.diagnosis.signatures.parts import Parts

_TERMS = (Bodies(), RotorInertia())


def base_torques(run: Replay) -> dict[str, Parts]:
    """Motor torque that each base parameter of bodies and rotors adds along a replay, by the parameter's name.

    Together they span all torques that other masses, centres of mass, inertias and rotors would give a rigid arm. Each
    is as large as the torque of the motor on which it is largest, so that one number says how far all are left open.
    """
    robot, log = run.robot, run.log
    motion = rigid_motion(robot, *(x.reshape(-1, robot.n_joints) for x in (log.q, log.dq, log.ddq)))
    base = base_parameters(robot, _TERMS)
    own, taken, k = set(base.own.tolist()), _rms(run.torque), 0
    found: dict[str, Parts] = {}
    for term in _TERMS:
        for part in term.columns(robot, motion):
            for i in range(part.shape[1]):
                if k + i in own and (parts := _parts(run, part[:, i].reshape(log.q.shape), taken)):
                    found[base.labels[k + i]] = parts
            k += part.shape[1]
    return found


def _parts(run: Replay, torque: Array, taken: Array) -> Parts:
    """A column at the size of what motors take; nothing if it is none on all of them."""
    moved = taken > 0
    size = float(np.max(_rms(torque)[moved] / taken[moved], initial=0.0))
    if size == 0.0:
        return {}
    rows = run.log.sampling(torque / size)
    return {("torque", j): rows[..., j] for j in range(run.robot.n_joints)}


def _rms(torque: Array) -> Array:
    """Of each motor over all samples, (N,)."""
    rms: Array = np.sqrt(np.mean(torque**2, axis=(0, 1)))
    return rms
