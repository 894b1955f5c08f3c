"""The first recording of a machine, which shows every regime, and the circle test of the thesis."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.errors import FFGymError, check_choice, check_shape
from ffgym.paths import RADII, Reference, cartesian_reference, circle_test, joint_reference, schroeder_phases
from ffgym.paths.motions.part import entry
from ffgym.simulation.protocols.protocol import JointProtocol, Protocol, Scheduled, check_names
from ffgym.simulation.protocols.rests import dwell_path
from ffgym.simulation.protocols.stage import ProtocolStage
from ffgym.simulation.protocols.together import large_multisine, own_sines, own_triangles

SLOW, MID, FAST = 0.3, 5.0, 15.0
"""Motor speeds of slow and mid triangle and of the sine [rad/s]; chosen: near the Stribeck speeds of gearboxes, above
them, and where viscous friction is as large as Coulomb friction (12 rad/s on joint 1 of the thesis)."""

RESTS = (0.3, 1.0, 3.0)
"""Rests before restarts [s]."""

CIRCLE = 0.003
"""Radius of the small circles [m], the middle one of the thesis."""

CIRCLES = (("slow", 0.010, 2), ("fast", 0.040, 4))
"""Motions with small circles: name, tool speed [m/s], those of the thesis' tables, and how many circles."""

SMALL = 3.0
"""Motor speed of the small motions that stand for circles on a machine without a work area [rad/s]; chosen: about that
of the fastest joint on the thesis' circles at 10 mm/s."""

HARMONICS = 0.25 * np.arange(1, 9, dtype=np.float64)
"""Frequencies of the multisine [Hz]."""

SWEEP = np.array([0.1, 0.2])
"""Frequencies of the large sweep [Hz]."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class DiagnosisMotions(JointProtocol):
    """Eight short motions of all joints: rest, presliding, dwell, reversals, a ladder of speeds and of loads."""

    name = "diagnosis"
    purpose = "first recording of a machine: every regime in a minute and a half"

    def motions(self, stage: ProtocolStage) -> list[Scheduled]:
        """Make the eight motions."""
        robot, joints = stage.robot, stage.select_joints(self.joints)
        timed = [
            own_triangles(stage, joints, SLOW, 13.0, name="slow_triangle"),
            own_triangles(stage, joints, MID, 10.0, name="mid_triangle"),
            own_sines(stage, joints, FAST, 0.7, 10.0, name="sine"),
            dwell_path(stage, joints, RESTS, speed=2 * SLOW, run=0.6, name="dwell_restart"),
        ]
        phases = schroeder_phases(len(HARMONICS), robot.n_joints)
        return self.schedule_all(
            [
                *(joint_reference(robot, path) for path in timed),
                large_multisine(stage, joints, HARMONICS, phases, 0.03, 10.0, name="multisine"),
                *_small_motions(stage, joints),
                large_multisine(stage, joints, SWEEP, phases[: len(SWEEP)], 0.15, 15.0, name="sweep"),
            ]
        )


def _small_motions(stage: ProtocolStage, joints: tuple[int, ...]) -> list[Reference]:
    """Make small circles at two speeds, or small sines without a work area or if only some joints move."""
    area = stage.robot.work_area
    if area is None or not area.positions or stage.robot.tool is None or len(joints) < stage.robot.n_joints:
        return [
            joint_reference(stage.robot, own_sines(stage, joints, SMALL, frequency, 6.0, name=name))
            for name, frequency in (("slow_small", 0.5), ("fast_small", 2.0))
        ]
    centre = next(iter(area.positions.values()))
    paths = [
        circle_test(centre, speed, radii=(CIRCLE,) * count, normal=area.normal, dt=stage.dt, name=f"{name}_circles")
        for name, speed, count in CIRCLES
    ]
    return [cartesian_reference(stage.arm, path) for path in paths]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Circles(Protocol):
    """Circles of the tool, thesis 2.2.5: one motion for each position and speed, with all radii."""

    name = "circles"
    purpose = "path error of the tool on small circles; to test a feed-forward, not to identify one"

    positions: Sequence[str] = entry("points of the work area; absent is all", default=())
    speeds: Sequence[float] = entry("of the tool", "m/s", default=(0.010, 0.040))
    radii: Sequence[float] = entry("of the circles", "m", default=RADII)

    def __post_init__(self) -> None:
        super().__post_init__()
        check_names("positions", self.positions)

    def motions(self, stage: ProtocolStage) -> list[Scheduled]:
        """Make one motion for each position and speed."""
        area = stage.robot.work_area
        if area is None or stage.robot.tool is None:
            raise FFGymError("it has no work area for a tool. Its joints can be moved: take another protocol.")
        for position in self.positions:
            check_choice("position", position, [*area.positions])
        speeds = check_shape("speeds", self.speeds, (None,))
        references = []
        for position in self.positions or area.positions:
            for speed in speeds:
                path = circle_test(
                    area.positions[position],
                    speed,
                    radii=self.radii,
                    normal=area.normal,
                    dt=stage.dt,
                    name=f"{position}.{speed * 1e3:g}_mm_s",
                )
                references.append(cartesian_reference(stage.arm, path))
        return self.schedule_all(references)
