"""Protocols that move one joint at a time: friction curves, sines of the thesis, slow triangles."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape, check_whole
from ffgym.core.types import Array
from ffgym.paths import Reference, joint_reference, speed_ladder, triangle
from ffgym.paths.circles import DWELL
from ffgym.paths.excitations import joint_path
from ffgym.paths.motion import Segment, standstill
from ffgym.paths.motions.part import entry
from ffgym.published import FRICTION_RECORDS, FrictionRecord
from ffgym.simulation.protocols.protocol import JointProtocol, Scheduled
from ffgym.simulation.protocols.stage import ProtocolStage, load_ladder

SPEEDS = tuple(np.geomspace(0.01, 14.0, 15).round(4).tolist())
"""Motor speeds [rad/s]: the interval of the thesis (6.1.1); geometric, so that they are dense near zero, as there."""

RAMP = 0.2
"""Time of each change of speed [s]."""

TURNS = 2.0
"""Motor turns at constant speed, where the time allows; chosen: whole turns, over which a ripple averages out."""

SHORTEST = 0.5
"""Least time at constant speed [s]; chosen: several times the decay of the servo (about 0.1 s)."""

BRISTLES = 5.0
"""Least way at constant speed, in units of f_s / sigma_0; chosen: bristles that bend have slipped all but for e^-5."""

MOST_POSES = 20
"""Largest number of load poses of a joint; more are surely a slip."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SpeedLadder(JointProtocol):
    """Each joint alone at constant speeds, forwards and back over the same positions, thesis (6.2)-(6.3)."""

    name = "speed_ladder"
    purpose = (
        "static friction (f_c, f_s, f_v, v_s) of each joint, thesis 6.1.1; with poses, its load dependence; with a "
        "tracker or link encoders, the share of friction behind the elasticity"
    )

    speeds: Sequence[float] = entry("of the motor; those that a joint cannot run are left out", "rad/s", default=SPEEDS)
    longest: float = entry("time after which a slow run turns back, if bristles have slipped by then", "s", default=6.0)
    poses: int = entry("poses of the arm that load the motor differently", default=1)

    def motions(self, stage: ProtocolStage) -> list[Scheduled]:
        """Make one motion for each joint and pose."""
        speeds = check_shape("speeds", self.speeds, (None,))
        longest = check_number("longest", self.longest, unit="s", low=SHORTEST, high=3600.0)
        poses = check_whole("poses", self.poses, low=1, high=MOST_POSES)
        if not len(speeds) or (speeds <= 0).any():
            raise FFGymError(f"speeds = {speeds.tolist()} rad/s must be > 0, at least one.")
        return self.schedule_all(
            [
                reference
                for joint in stage.select_joints(self.joints)
                for reference in _ladders(stage, joint, np.sort(speeds), longest, poses)
            ]
        )


def _ladders(stage: ProtocolStage, joint: int, motor_speeds: Array, longest: float, count: int) -> list[Reference]:
    """Make ladders of one joint, one for each pose."""
    n, name = stage.robot.n_joints, stage.robot.joints[joint]
    # travel in some turns of the motor, within half the span of the joint
    room = 0.5 * stage.span[joint]
    turns = TURNS * 2 * np.pi * stage.joint_side(1.0)[joint]
    travel = min(turns, room)
    link_speeds = motor_speeds * stage.joint_side(1.0)[joint]
    # speeds that the motor reaches, and for which the joint has room
    runs = link_speeds[(motor_speeds <= stage.motor_speed[joint]) & (link_speeds * (SHORTEST + RAMP) <= room)]
    if not len(runs):
        raise FFGymError(f"joint {name} has no room for {motor_speeds.min():g} rad/s of its motor for {SHORTEST} s.")
    # the slowest speed needs time until the bristles have slid
    bent = BRISTLES * stage.presliding[joint] / motor_speeds[0]
    way = max(travel, runs[-1] * SHORTEST) + runs[-1] * RAMP
    # poses under different loads, each in the middle of its travel
    half = stage.only([joint], way / 2)
    poses = load_ladder(stage, joint, count, half)
    velocities = np.outer(runs, stage.only([joint], 1.0))
    travels = np.full(n, max(travel, runs[-1] * SHORTEST))
    return [
        joint_reference(
            stage.robot,
            speed_ladder(
                pose - half,
                velocities,
                travels,
                longest=max(longest, bent),
                ramp=RAMP,
                dt=stage.dt,
                name=name if len(poses) == 1 else f"{name}.pose_{i}",
            ),
        )
        for i, pose in enumerate(poses, start=1)
    ]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Table61(JointProtocol):
    """Sines of the motor speed, dq_ref = A sin(2 pi f t), one joint at a time, over whole periods.

    Record 11 has A = 10 rad/s, see `ffgym.published.FRICTION_RECORDS`.
    """

    name = "table_6_1"
    purpose = "dynamic friction (sigma_0, sigma_1) of each joint, thesis table 6.1 and (6.13)"

    records: Sequence[int] = entry("numbers of the records; absent is all fifteen", default=())
    least: float = entry("shortest time of a sine", "s", default=6.0)
    periods: int = entry("fewest periods", default=3)

    def motions(self, stage: ProtocolStage) -> list[Scheduled]:
        """Make one motion for each joint and record."""
        least = check_number("least", self.least, unit="s", low=0.0, high=3600.0)
        periods = check_whole("periods", self.periods, low=1, high=1000)
        known = {record.number: record for record in FRICTION_RECORDS}
        numbers = check_shape("records", self.records, (None,)).tolist()
        unknown = [number for number in numbers if number not in known]
        if unknown or len(set(numbers)) < len(numbers):
            raise FFGymError(f"records = {numbers} must be numbers from 1 to {len(known)}, each of them once.")
        chosen = [known[number] for number in numbers or known]
        return self.schedule_all(
            [
                _sine(stage, joint, record, max(periods, int(np.ceil(least * record.frequency))))
                for joint in stage.select_joints(self.joints)
                for record in chosen
            ]
        )


def _sine(stage: ProtocolStage, joint: int, record: FrictionRecord, periods: int) -> Reference:
    """Make a path with speed A sin(2 pi f t) of one motor: the joint starts and ends at rest, at one end of its way."""
    omega = 2 * np.pi * record.frequency
    half_way = stage.only([joint], stage.joint_side(record.amplitude / omega))
    start = stage.about(stage.rest, half_way) - half_way

    def evaluate(tau: Array) -> tuple[Array, Array, Array]:
        phase = omega * tau[:, None]
        return (
            start + half_way * (1 - np.cos(phase)),
            half_way * omega * np.sin(phase),
            half_way * omega**2 * np.cos(phase),
        )

    duration = periods / record.frequency
    label = f"{record.amplitude:g} rad/s at {record.frequency:g} Hz"
    segments = [
        standstill("rest 0", start, DWELL),
        Segment(label=label, kind="motion", duration=duration, evaluate=evaluate),
        standstill("rest 1", start, DWELL),
    ]
    name = f"{stage.robot.joints[joint]}.record_{record.number:02d}"
    return joint_reference(stage.robot, joint_path(name, segments, stage.dt))


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SlowTriangles(JointProtocol):
    """Triangles of the motor angle, one joint at a time: what bristles do before they slip, and at reversals."""

    name = "slow_triangles"
    purpose = (
        "friction before sliding and at reversals: bristle stiffness, hysteresis; with a tracker or link encoders, the "
        "share of friction behind the elasticity"
    )

    sizes: Sequence[float] = entry("amplitudes, in units of f_s / sigma_0 of the description", default=(0.5, 2.0, 8.0))
    sliding: float = entry("amplitude of the last triangle, motor side", "rad", default=1.0)
    period: float = entry("time of one to and fro; the last triangle takes twice as long", "s", default=4.0)
    periods: int = entry("how many of each", default=3)
    speeds: Sequence[float] = entry(
        "of the motor in more triangles of the last amplitude; two or more tell the delay of tracker or link encoder",
        "rad/s",
        default=(),
    )

    def motions(self, stage: ProtocolStage) -> list[Scheduled]:
        """Make one motion for each joint, amplitude and speed."""
        sizes = check_shape("sizes", self.sizes, (None,))
        if (sizes <= 0).any():
            raise FFGymError(f"sizes = {sizes.tolist()} must be > 0.")
        sliding = check_number("sliding", self.sliding, unit="rad", low=0.0, open_low=True)
        speeds = check_shape("speeds", self.speeds, (None,))
        if (speeds <= 0).any():
            raise FFGymError(f"speeds = {speeds.tolist()} rad/s must be > 0.")
        slope = check_number("period", self.period, unit="s", low=0.0, open_low=True)
        references = []
        for joint in stage.select_joints(self.joints):
            label = stage.robot.joints[joint]
            motor_angles = [*sizes * stage.presliding[joint], sliding, *[sliding] * len(speeds)]
            names = [*(f"{label}.bristles_x{size:g}" for size in sizes), f"{label}.sliding"]
            names += [f"{label}.sliding_at_{speed:g}" for speed in speeds]
            # from one end to the other in half a period; reversals take a little more
            periods = [*[slope] * len(sizes), 2 * slope, *4 * sliding / speeds]
            for angle, name, period in zip(motor_angles, names, periods, strict=True):
                size = stage.only([joint], stage.joint_side(angle))
                centre = stage.about(stage.rest, size)
                path = triangle(centre, size, period, self.periods, dt=stage.dt, name=name)
                references.append(joint_reference(stage.robot, path))
        return self.schedule_all(references)
