"""Studies with made-up results, so that claims can be made to hold and to fail."""

from dataclasses import replace

import pytest

from ffgym.control import NoCompensation
from ffgym.studies import CircleStudy, circle_study
from scripts.thesis import ITEMS, ThesisStudies
from scripts.thesis.claims import judge

POSITIONS, RADII, SPEEDS = ("p1", "p2", "p3", "p4"), (1.0, 3.0, 5.0), (0.010, 0.040, 0.100)


@pytest.fixture(scope="session")
def short(irb4600) -> CircleStudy:
    """One short motion without compensation, whose recording and cell others are made of."""
    laws = [NoCompensation()]
    return circle_study(irb4600, laws=laws, positions=["p1"], radii=[0.001], speeds=[0.1])


@pytest.fixture(scope="session")
def made_up_circles(short):
    """Function that makes a study of the 36 circles with given errors.

    `path(law, speed, radius, position)` is the RMS path error [mm], `motor(law, speed, position, joint)` that of the
    motor [rad]; speed in m/s, radius in mm, joints from 1.
    """
    [recording], [cell] = short.recordings.values(), short.cells
    reference = recording.joint_array("reference.position")

    def with_error(law, speed, position, motor):
        columns = {
            f"motor.position.{name}": reference[:, j] - motor(law, speed, position, j + 1)
            for j, name in enumerate(recording.header.joints)
        }
        header = replace(recording.header, segment=f"{position}, {speed * 1e3:g} mm/s")
        return replace(recording.with_columns(columns), header=header)

    def make(laws, path=lambda *where: 1.0, motor=lambda *where: 1e-3):
        keys = [(law, position, speed) for speed in SPEEDS for position in POSITIONS for law in laws]
        cells = [
            replace(
                cell,
                agent=law,
                position=position,
                radius_mm=radius,
                speed_mm_s=round(speed * 1e3, 6),
                rms_mm=path(law, speed, radius, position),
                max_mm=2 * path(law, speed, radius, position),
            )
            for law, position, speed in keys
            for radius in RADII
        ]
        recordings = {(law, position, speed): with_error(law, speed, position, motor) for law, position, speed in keys}
        return replace(short, cells=cells, recordings=recordings)

    return make


@pytest.fixture
def studies() -> ThesisStudies:
    """Studies; tests put results into it instead of simulating."""
    return ThesisStudies()


@pytest.fixture
def verdict(studies):
    """Function that judges a claim by what is put into the studies."""
    claims = {claim.name: claim for item in ITEMS for claim in item.claims}

    def judged(name, **results) -> str:
        for what, value in results.items():
            setattr(studies, what, value)
        return judge(claims[name], studies).verdict

    return judged
