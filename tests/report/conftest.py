"""Small studies that the report tests share: one simulated, one made of the published numbers."""

import pytest

from ffgym.published import published_mm
from ffgym.robot import RobotDescription
from ffgym.studies import CircleStudy, OneAxisStudy, StudyCell, circle_study, one_axis_study

LAWS = ("none", "lugre_static", "lugre_dynamic")


@pytest.fixture(scope="session")
def circle(irb4600: RobotDescription) -> CircleStudy:
    """One position and radius, a speed with published numbers and one without."""
    return circle_study(irb4600, positions=["p1"], radii=[0.003], speeds=[0.04, 0.1])


@pytest.fixture(scope="session")
def sine(one_axis: RobotDescription) -> OneAxisStudy:
    """The sine test at one frequency."""
    return one_axis_study(one_axis, frequencies=[3.0])


@pytest.fixture(scope="session")
def made_up(irb4600: RobotDescription):
    """Function that makes a study whose RMS is the published one times `factor(law, speed, radius, position)`."""

    def make(factor=lambda *where: 1.0, *, laws=LAWS, rename=lambda law: law) -> CircleStudy:
        cells = [
            cell_at(law, speed, radius, position, factor(law, speed, radius, position), rename)
            for law in laws
            for speed in (0.01, 0.04)
            for radius in (0.001, 0.003, 0.005)
            for position in ("p1", "p2", "p3", "p4")
        ]
        return CircleStudy(robot=irb4600, cells=cells, recordings={}, fingerprint="made up")

    return make


def cell_at(law, speed, radius, position, factor, rename) -> StudyCell:
    rms = factor * published_mm(law, "rms", speed, radius, position)
    return StudyCell(
        agent=rename(law),
        plant="nominal",
        position=position,
        radius_mm=round(radius * 1e3, 6),
        speed_mm_s=speed * 1e3,
        rms_mm=rms,
        max_mm=2 * rms,
        rms_3d_mm=rms,
        max_3d_mm=2 * rms,
        motor_rms_rad=[0.001] * 6,
    )
