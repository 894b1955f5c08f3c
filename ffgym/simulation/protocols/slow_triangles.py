"""Slow to and fro of one joint at a time, within the bristles and beyond."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, final

from ffgym.core.errors import FFGymError, check_number, check_shape
from ffgym.paths import joint_reference, triangle
from ffgym.paths.motions.part import entry
from ffgym.simulation.protocols.protocol import JointProtocol, Scheduled
from ffgym.simulation.protocols.stage import Stage


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SlowTriangles(JointProtocol):
    """Triangles of the motor angle, one joint at a time: what bristles do before they slip, and at reversals."""

    name: ClassVar[str] = "slow_triangles"
    purpose: ClassVar[str] = "friction before sliding and at reversals: bristle stiffness, hysteresis"

    sizes: Sequence[float] = entry("amplitudes, in units of f_s / sigma_0 of the description", default=(0.5, 2.0, 8.0))
    sliding: float = entry("amplitude of the last triangle, motor side", "rad", default=1.0)
    period: float = entry("time of one to and fro; the last triangle takes twice as long", "s", default=4.0)
    periods: int = entry("how many of each", default=3)

    def motions(self, stage: Stage) -> list[Scheduled]:
        """One for each joint and amplitude."""
        sizes = check_shape("sizes", self.sizes, (None,))
        if (sizes <= 0).any():
            raise FFGymError(f"sizes = {sizes.tolist()} must be > 0.")
        sliding = check_number("sliding", self.sliding, unit="rad", low=0.0, open_low=True)
        slope = check_number("period", self.period, unit="s", low=0.0, open_low=True)
        references = []
        for joint in stage.moved(self.joints):
            label = stage.robot.joints[joint]
            motor_angles = [*sizes * stage.presliding[joint], sliding]
            names = [*(f"{label}.bristles_x{size:g}" for size in sizes), f"{label}.sliding"]
            periods = [*[slope] * len(sizes), 2 * slope]
            for angle, name, period in zip(motor_angles, names, periods, strict=True):
                size = stage.only([joint], stage.joint_side(angle))
                centre = stage.about(stage.rest, size)
                path = triangle(centre, size, period, self.periods, dt=stage.dt, name=name)
                references.append(joint_reference(stage.robot, path))
        return self.paused(references)
