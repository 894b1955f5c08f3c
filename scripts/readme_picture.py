"""Picture of the README: a circle of the tool with and without friction compensation, from a simulation."""

from dataclasses import dataclass
from pathlib import Path

import tyro

from ffgym.control import DynamicLuGreExact, NoCompensation
from ffgym.paths import cartesian_reference, circle_test
from ffgym.report.circles.paths_plot import flat_circles
from ffgym.report.figure import panels, save_figure
from ffgym.report.laws import law_styles
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation import Run, simulate


@dataclass(frozen=True)
class Config:
    """Circle, and the place of the picture."""

    out: Path = Path("docs/pictures/circle.svg")
    """SVG or PNG file."""
    position: str = "p1"
    """Position of the circle in the workspace of the robot."""
    speed_mm_s: float = 10.0
    """Speed of the tool."""
    radius_mm: float = 5.0
    """Radius of the circle."""
    magnification: float = 20.0
    """Factor by which the deviation from the circle is enlarged."""


POINTS = 600
"""Points drawn on one circle, enough for a line without corners."""


def main(config: Config) -> Path:
    """Simulate the circle with and without compensation, and draw both paths beside the reference."""
    robot = load_robot("irb4600_60_205")
    arm = RigidArm(robot)
    path = circle_test(
        robot.position(config.position), speed=1e-3 * config.speed_mm_s, radii=(1e-3 * config.radius_mm,)
    )
    reference = cartesian_reference(arm, path)
    laws = {"none": NoCompensation(), "lugre_dynamic": DynamicLuGreExact(robot.friction)}
    recordings = simulate([Run(reference=reference, law=law) for law in laws.values()], arm=arm)
    styles = law_styles(laws)
    with panels(size=(5.4, 5.0)) as (figure, grid):
        axes = grid[0, 0]
        # deviations from the circle are enlarged, radii are not
        for name, recording in zip(laws, recordings, strict=True):
            (circle,) = flat_circles(recording)
            drawn = circle.path(config.magnification)[:: max(1, len(circle.angle) // POINTS)]
            rms = float((circle.outward**2).mean() ** 0.5)
            label = f"{styles[name].label}: RMS {1e3 * rms:.0f} µm"
            axes.plot(*drawn.T, color=styles[name].colour, linewidth=1.6, label=label)
        axes.plot(*circle.reference().T, color="black", linewidth=0.8, linestyle=(0, (5, 3)), label="reference")
        axes.set(aspect="equal", xlabel="x [mm]", ylabel="y [mm]")
        axes.set_title(f"{config.speed_mm_s:g} mm/s, deviation enlarged {config.magnification:g} times", fontsize=10)
    return save_figure(figure, config.out)


if __name__ == "__main__":
    main(tyro.cli(Config))
