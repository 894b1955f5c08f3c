"""Motions of several joints at once, each in its own rhythm, so that what one does is not taken for another's."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ffgym.core.types import Array
from ffgym.paths import JointPath, Reference, multisine, triangle
from ffgym.paths.circles import DWELL
from ffgym.paths.excitations import PEAK
from ffgym.recordings import Phase
from ffgym.simulation.protocols.stage import Stage, shrunk

FEWEST_PERIODS = 3
"""Periods of the first joint's triangle; the next ones have one more each. Chosen: each half of a recording has one,
and of six joints most reversals are alone."""

REVERSAL = 0.2
"""Time of a triangle's reversal [s]."""

APART = 0.15
"""Each joint's sine has a frequency higher by this share of the first one's than the joint before; chosen: after ten
seconds at 1 Hz two neighbours have had every phase to each other."""

FADE = 0.8
"""Time in which small sines fade in and out [s]."""


def own_triangles(stage: Stage, joints: Sequence[int], motor_speed: float, duration: float, *, name: str) -> JointPath:
    """To and fro of `joints` at one speed of their motors [rad/s], or as fast as they may; hardly two turn together."""
    speed = stage.joint_side(np.minimum(motor_speed, stage.motor_speed))
    periods = {joint: FEWEST_PERIODS + i for i, joint in enumerate(joints)}
    times = np.array([duration / periods.get(j, 1) for j in range(stage.robot.n_joints)])
    size = stage.only(joints, speed * (times / 2 - REVERSAL + 2 * PEAK * REVERSAL) / 2)
    centre = stage.about(stage.rest, size)
    paths = [
        triangle(
            centre, stage.only([j], size), times[j], periods[j], ramp=REVERSAL, dwell=DWELL, dt=stage.dt, name=name
        )
        for j in joints
    ]
    return _superposed(paths, centre)


def _superposed(paths: Sequence[JointPath], centre: Array) -> JointPath:
    """Motions about one centre that last equally long, all at once."""
    first = paths[0]
    count = min(len(path.t) for path in paths)  # the last sample may be beyond the end of some
    q, dq, ddq = (np.sum([getattr(path, part)[:count] for path in paths], axis=0) for part in ("q", "dq", "ddq"))
    start, end = first.phases[0].end, first.phases[-1].start
    moving = Phase(label="triangles", kind="motion", start=start, end=end)
    phases = (first.phases[0], moving, first.phases[-1])
    q = q - (len(paths) - 1) * centre
    return JointPath(name=first.name, t=first.t[:count], q=q, dq=dq, ddq=ddq, phases=phases)


def own_sines(
    stage: Stage, joints: Sequence[int], motor_speed: float, frequency: float, duration: float, *, name: str
) -> JointPath:
    """A sine of each of the `joints` at its own frequency, from `frequency` [Hz] on, up to one motor speed [rad/s]."""
    frequencies = frequency * (1 + APART * np.arange(len(joints), dtype=np.float64))
    speed = stage.only(joints, stage.joint_side(np.minimum(motor_speed, stage.motor_speed)))
    amplitude = np.zeros((len(joints), stage.robot.n_joints))
    amplitude[np.arange(len(joints)), joints] = speed[list(joints)] / (2 * np.pi * frequencies)
    centre = stage.about(stage.rest, amplitude.sum(axis=0))
    phases = np.zeros_like(amplitude)
    return multisine(centre, amplitude, frequencies, phases, duration, ramp=FADE, dwell=DWELL, dt=stage.dt, name=name)


def large_multisine(
    stage: Stage, joints: Sequence[int], frequencies: Array, phases: Array, reach: float, duration: float, *, name: str
) -> Reference:
    """Sums of sines of amplitudes inverse to their frequencies, as large as ranges, speeds and torques allow.

    Args:
        stage: the robot.
        joints: which joints move.
        frequencies: [Hz], shape (F,).
        phases: [rad], shape (F, N).
        reach: farthest way from the centre, as a share of each joint's range.
        duration: with fades [s].
        name: name of the motion.
    """
    way = stage.only(joints, reach * stage.span)
    centre = stage.about(stage.rest, way)
    ramp = fade_of(frequencies)
    unit = stage.only(joints, 1.0) / frequencies[:, None]
    one = multisine(centre, unit, frequencies, phases, duration, ramp=ramp, dwell=DWELL, dt=stage.dt, name=name)
    off = one.q - centre
    farthest, fastest = np.abs(off).max(axis=0), np.abs(one.dq).max(axis=0)
    size = np.minimum(_ratio(way, farthest), _ratio(stage.joint_side(stage.motor_speed), fastest))
    return shrunk(stage, replace(one, q=centre + size * off, dq=size * one.dq, ddq=size * one.ddq))


def fade_of(frequencies: Array) -> float:
    """Time in which large sines of these frequencies [Hz] fade in and out [s]: slow, so that it takes little torque."""
    return float(0.25 / np.min(frequencies))


def _ratio(most: Array, has: Array) -> Array:
    """How far a joint's motion may be enlarged; zero for one that does not move."""
    return np.divide(most, has, out=np.zeros_like(has), where=has > 0)
