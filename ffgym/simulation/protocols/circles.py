"""The circle test of the thesis as a protocol."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, final

from ffgym.core.errors import FFGymError, check_choice, check_shape
from ffgym.paths import RADII, cartesian_reference, circle_test
from ffgym.paths.motions.part import entry
from ffgym.simulation.protocols.protocol import Protocol, Scheduled, check_names
from ffgym.simulation.protocols.stage import Stage


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Circles(Protocol):
    """Circles of the tool, thesis 2.2.5: one motion for each position and speed, with all radii."""

    name: ClassVar[str] = "circles"
    purpose: ClassVar[str] = "path error of the tool on small circles; to test a feed-forward, not to identify one"

    positions: Sequence[str] = entry("points of the work area; absent is all", default=())
    speeds: Sequence[float] = entry("of the tool", "m/s", default=(0.010, 0.040))
    radii: Sequence[float] = entry("of the circles", "m", default=RADII)

    def __post_init__(self) -> None:
        super().__post_init__()
        check_names("positions", self.positions)

    def motions(self, stage: Stage) -> list[Scheduled]:
        """One for each position and speed."""
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
        return self.paused(references)
