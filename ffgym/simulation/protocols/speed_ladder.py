"""Constant speeds in both directions, one joint at a time: friction curves."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape, check_whole
from ffgym.core.types import Array
from ffgym.paths import Reference, joint_reference, speed_ladder
from ffgym.paths.motions.part import entry
from ffgym.simulation.protocols.protocol import JointProtocol, Scheduled
from ffgym.simulation.protocols.stage import Stage, load_ladder

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
"""Most load poses of a joint; more are surely a slip."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SpeedLadder(JointProtocol):
    """Each joint alone at constant speeds, forwards and back over the same positions, thesis (6.2)-(6.3)."""

    name: ClassVar[str] = "speed_ladder"
    purpose: ClassVar[str] = (
        "static friction (f_c, f_s, f_v, v_s) of each joint, thesis 6.1.1; with poses, its load dependence"
    )

    speeds: Sequence[float] = entry("of the motor; those that a joint cannot run are left out", "rad/s", default=SPEEDS)
    longest: float = entry("time after which a slow run turns back, if bristles have slipped by then", "s", default=6.0)
    poses: int = entry("poses of the arm that load the motor differently", default=1)

    def motions(self, stage: Stage) -> list[Scheduled]:
        """One for each joint and pose."""
        speeds = check_shape("speeds", self.speeds, (None,))
        longest = check_number("longest", self.longest, unit="s", low=SHORTEST, high=3600.0)
        poses = check_whole("poses", self.poses, low=1, high=MOST_POSES)
        if not len(speeds) or (speeds <= 0).any():
            raise FFGymError(f"speeds = {speeds.tolist()} rad/s must be > 0, at least one.")
        return self.paused(
            [
                reference
                for joint in stage.moved(self.joints)
                for reference in _ladders(stage, joint, np.sort(speeds), longest, poses)
            ]
        )


def _ladders(stage: Stage, joint: int, motor_speeds: Array, longest: float, count: int) -> list[Reference]:
    """Ladders of one joint, one for each pose."""
    n, name = stage.robot.n_joints, stage.robot.joints[joint]
    room = 0.5 * stage.span[joint]
    turns = TURNS * 2 * np.pi * stage.joint_side(1.0)[joint]
    travel = min(turns, room)
    link_speeds = motor_speeds * stage.joint_side(1.0)[joint]
    runs = link_speeds[(motor_speeds <= stage.motor_speed[joint]) & (link_speeds * (SHORTEST + RAMP) <= room)]
    if not len(runs):
        raise FFGymError(f"joint {name} has no room for {motor_speeds.min():g} rad/s of its motor for {SHORTEST} s.")
    bent = BRISTLES * stage.presliding[joint] / motor_speeds[0]
    way = max(travel, runs[-1] * SHORTEST) + runs[-1] * RAMP
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
