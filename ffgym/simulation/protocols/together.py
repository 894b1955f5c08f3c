"""Motions of several joints at once, each in its own rhythm, and the protocols that are made of one of them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape, check_whole
from ffgym.core.types import Array
from ffgym.paths import JointPath, Reference, multisine, triangle
from ffgym.paths.circles import DWELL
from ffgym.paths.excitations import PEAK
from ffgym.paths.motions.part import entry
from ffgym.recordings import Phase
from ffgym.simulation.protocols.protocol import JointProtocol, Scheduled
from ffgym.simulation.protocols.stage import ProtocolStage, shrunk

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


def own_triangles(
    stage: ProtocolStage, joints: Sequence[int], motor_speed: float, duration: float, *, name: str
) -> JointPath:
    """Make triangles of `joints` at one speed of their motors [rad/s], or at their limits; hardly two turn together."""
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
    return _superpose(paths, centre)


def _superpose(paths: Sequence[JointPath], centre: Array) -> JointPath:
    """Superpose motions about one centre that last equally long."""
    first = paths[0]
    count = min(len(path.t) for path in paths)  # the last sample may be beyond the end of some
    q, dq, ddq = (np.sum([getattr(path, part)[:count] for path in paths], axis=0) for part in ("q", "dq", "ddq"))
    start, end = first.phases[0].end, first.phases[-1].start
    moving = Phase(label="triangles", kind="motion", start=start, end=end)
    phases = (first.phases[0], moving, first.phases[-1])
    q = q - (len(paths) - 1) * centre
    return JointPath(name=first.name, t=first.t[:count], q=q, dq=dq, ddq=ddq, phases=phases)


def own_sines(
    stage: ProtocolStage, joints: Sequence[int], motor_speed: float, frequency: float, duration: float, *, name: str
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
    stage: ProtocolStage,
    joints: Sequence[int],
    frequencies: Array,
    phases: Array,
    reach: float,
    duration: float,
    *,
    name: str,
) -> Reference:
    """Sums of sines of amplitudes inverse to their frequencies, as large as ranges, speeds and torques allow.

    Of `frequencies` (F,) [Hz] and `phases` (F, N) [rad]; joints go at most `reach` of their range from the centre.
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
    """Compute the factor by which each joint's motion may grow; zero for a joint at rest."""
    return np.divide(most, has, out=np.zeros_like(has), where=has > 0)


MOST = 100
"""Largest number of motions, sines and periods; more are surely a slip."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Excitation(JointProtocol):
    """Harmonics with random phases on all joints at once, as large as joint ranges, speeds and torques allow.

    Reference:
        Swevers, Ganseman, Tukel, De Schutter, Van Brussel (1997), IEEE Trans. Robotics and Automation 13(5), 730-740:
        periodic excitation by a sum of harmonics.
    """

    name = "excitation"
    purpose = "inertial parameters of the links; the last motion may validate"

    count: int = entry("how many motions, with different phases", default=3)
    base: float = entry("lowest frequency, of which the others are multiples", "Hz", default=0.1)
    harmonics: int = entry("how many sines on each joint", default=10)
    periods: int = entry("how many periods of the lowest frequency", default=2)
    reach: float = entry("farthest way of a joint to either side, as a share of its range", default=0.15)
    seed: int = entry("of the phases", default=0)

    def motions(self, stage: ProtocolStage) -> list[Scheduled]:
        """Make one motion for each set of phases."""
        count = check_whole("count", self.count, low=1, high=MOST)
        harmonics = check_whole("harmonics", self.harmonics, low=1, high=MOST)
        periods = check_whole("periods", self.periods, low=1, high=MOST)
        base = check_number("base", self.base, unit="Hz", low=0.0, open_low=True)
        reach = check_number("reach", self.reach, low=0.0, high=0.5, open_low=True)
        frequencies = base * np.arange(1, harmonics + 1, dtype=np.float64)
        joints, duration = stage.select_joints(self.joints), periods / base + 2 * fade_of(frequencies)
        shape = (harmonics, stage.robot.n_joints)
        generators = np.random.default_rng(check_whole("seed", self.seed, low=0)).spawn(count)
        return self.schedule_all(
            [
                large_multisine(
                    stage, joints, frequencies, rng.uniform(0, 2 * np.pi, shape), reach, duration, name=f"phases_{i}"
                )
                for i, rng in enumerate(generators, start=1)
            ]
        )


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class WarmUp(JointProtocol):
    """The same sines of all joints at times that double, while the machine works in between and warms up."""

    name = "warm_up"
    purpose = "change of friction with temperature; let the machine work between the recordings"

    times: Sequence[float] = entry(
        "starts of the motion, since the first one", "s", default=(0.0, 300.0, 600.0, 1200.0, 2400.0, 4800.0, 9600.0)
    )
    speed: float = entry("largest speed of the motors", "rad/s", default=60.0)
    frequency: float = entry("of the first joint's sine", "Hz", default=0.3)
    duration: float = entry("of the motion", "s", default=10.0)

    def motions(self, stage: ProtocolStage) -> list[Scheduled]:
        """Make one motion for each time."""
        times = check_shape("times", self.times, (None,))
        joints = stage.select_joints(self.joints)
        speed = check_number("speed", self.speed, unit="rad/s", low=0.0, open_low=True)
        frequency = check_number("frequency", self.frequency, unit="Hz", low=0.0, open_low=True)
        path = own_sines(stage, joints, speed, frequency, self.duration, name="0")
        reference = shrunk(stage, path)
        if not len(times) or times[0] != 0 or (np.diff(times) < reference.duration).any():
            raise FFGymError(
                f"times = {times.tolist()} s must begin with 0 and lie at least {reference.duration:g} s apart, as the "
                f"motion takes so long."
            )
        pauses = [self.pause, *(np.diff(times) - reference.duration)]
        return [
            Scheduled(reference=replace(reference, name=f"at_{time:g}_s"), pause=pause)
            for time, pause in zip(times, pauses, strict=True)
        ]
