"""The workcell `thesis` errs like the published robot: Tables 4.1 and 4.2, to which it was fitted."""

import numpy as np
import pytest

from ffgym.paths import RADII
from ffgym.published import published_mm
from ffgym.recordings.metrics import path_errors
from ffgym.robot import ModelOptions
from ffgym.simulation import Run, simulate
from ffgym.studies import circle_references, circle_study, thesis_laws
from ffgym.workcell import workcell

SLOW, FAST = 0.010, 0.040
POSITIONS = ("p1", "p2", "p3", "p4")
LAWS = ("none", "lugre_static", "lugre_dynamic")
MOST_OFF = 0.25
"""Largest median of |ln(simulated / published)|."""


def published(speed, radii):
    """RMS path errors [mm], shape (3, 4, R): law, position, radius."""
    return np.array(
        [[[published_mm(law, "rms", speed, radius, p) for radius in radii] for p in POSITIONS] for law in LAWS]
    )


def simulated_coarsely(speed, radii):
    """The same on the workcell, with a physics step of 1 ms, which changes errors by 1 %."""
    cell = workcell("thesis")
    references = circle_references(cell.arm, POSITIONS, [speed], radii)
    runs = [Run(reference=r, law=law) for law in thesis_laws(cell.robot) for r in references.values()]
    options = ModelOptions(looks=False, physics_dt=0.001)
    recordings = simulate(runs, arm=cell.arm, machine=cell.machine, sensors=cell.sensors, options=options, n_threads=1)
    errors = [[error.rms * 1e3 for error in path_errors(recording)] for recording in recordings]
    return np.reshape(errors, (len(LAWS), len(POSITIONS), len(radii)))


def off(simulated, wanted):
    return float(np.median(np.abs(np.log(simulated / wanted))))


def ordered(sizes):
    """Cells in which dynamic LuGre is better than static, and static better than none."""
    none, static, dynamic = sizes
    return int(((dynamic < static) & (static < none)).sum())


def gains(sizes):
    """Share of the mean error that each compensation takes away."""
    return [float(1 - law.mean() / sizes[0].mean()) for law in sizes[1:]]


def test_small_circles_err_as_published():
    slow, fast = simulated_coarsely(SLOW, RADII[:1]), simulated_coarsely(FAST, RADII[:2])
    assert off(slow, published(SLOW, RADII[:1])) <= MOST_OFF
    assert off(fast, published(FAST, RADII[:2])) <= MOST_OFF
    assert ordered(slow) >= 3
    assert all(at_40 < at_10 for at_40, at_10 in zip(gains(fast), gains(slow), strict=True))


@pytest.mark.slow
def test_all_circles_err_as_published():
    cell = workcell("thesis")
    cells = circle_study(cell, speeds=[SLOW, FAST]).cells
    sizes = np.array(
        [
            [
                [
                    [c.rms_mm for c in cells if (c.agent, c.position, c.speed_mm_s) == (law, p, speed * 1e3)]
                    for p in POSITIONS
                ]
                for law in LAWS
            ]
            for speed in (SLOW, FAST)
        ]
    )
    wanted = np.stack([published(speed, RADII) for speed in (SLOW, FAST)])
    assert off(sizes, wanted) <= MOST_OFF
    assert ordered(sizes[0]) >= 10
    assert all(at_40 < at_10 for at_40, at_10 in zip(gains(sizes[1]), gains(sizes[0]), strict=True))
