"""What docs/workcell.md tells of the calibration of workcells, and how near they come to the published errors."""

from collections.abc import Iterator

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.tables.problem import MAX_SPREAD, RMS_SPREAD
from ffgym.published import published_mm
from ffgym.simulation.sensors import LaserTracker, Resolver
from ffgym.workcell import workcell
from scripts.claims.claim import claim
from scripts.claims.records import numbers_of
from scripts.claims.told.constants import CODE
from scripts.workcell.free import CALIBRATIONS

AGAIN = "python -m scripts.claims --record workcell workcell_arm"
NAMES = {"none": "none", "lugre_static": "static LuGre", "lugre_dynamic": "dynamic LuGre"}
FACTOR = 1.5
SLOW, FAST = 10.0, 40.0
SMALL, LARGE = 1.0, 5.0
"""Radii of the smallest and largest circles [mm]."""


def errors(record: str, law: str, speed: float, statistic: str = "rms", radius: float | None = None) -> Array:
    """Simulated and published errors [mm] of the circles of a law and speed, shape (M, 2)."""
    cells = [
        cell
        for cell in numbers_of(record)["cells"]
        if (cell["agent"], cell["speed_mm_s"]) == (law, speed) and radius in (None, cell["radius_mm"])
    ]
    published = [
        published_mm(law, statistic, speed * 1e-3, cell["radius_mm"] * 1e-3, cell["position"]) for cell in cells
    ]
    return np.array([(cell[f"{statistic}_mm"], value) for cell, value in zip(cells, published, strict=True)])


def off(pairs: Array) -> Array:
    """|ln(simulated / published)|."""
    return np.abs(np.log(pairs[:, 0] / pairs[:, 1]))


def within(pairs: Array) -> int:
    """How many are within the factor."""
    return int((off(pairs) <= np.log(FACTOR)).sum())


def every(record: str, statistic: str = "rms") -> Array:
    """Errors of all laws and speeds."""
    return np.concatenate([errors(record, law, speed, statistic) for law in NAMES for speed in (SLOW, FAST)])


def left_of_small(record: str, law: str, column: int = 0) -> Array:
    """Errors of the smallest circles at the higher speed over those without compensation, simulated or published."""
    one, none = (errors(record, name, FAST, radius=SMALL)[:, column] for name in (law, "none"))
    return one / none


def span(values: Array) -> str:
    """Least to largest of shares, in percent."""
    return f"{100 * values.min():.0f} to {100 * values.max():.0f} %"


@claim(CODE)
def sensors_of_the_workcell() -> Iterator[str]:
    """Resolution and noise of what is measured."""
    sensors = workcell("thesis").sensors
    (resolver,) = (each for each in sensors if isinstance(each, Resolver))
    (tracker,) = (each for each in sensors if isinstance(each, LaserTracker))
    assert resolver.noise < 2 * np.pi / 2**resolver.bits
    yield f"motor angles ({resolver.bits} bit, noise below a step)"
    yield f"a laser tracker ({1e6 * tracker.noise:g} um in each coordinate, every {1e3 * tracker.period:g} ms)"


@claim(CODE)
def calibration_of_the_workcell() -> Iterator[str]:
    """Objective and prior."""
    cells = len(every("workcell"))
    yield f"path error in the {cells} cells of Tables 4.1 and 4.2 ({SLOW:g} and {FAST:g} mm/s,"
    yield f"RMS errors count in units of {100 * RMS_SPREAD:g} %, largest errors in units of {100 * MAX_SPREAD:g} %."
    yield f"each of the {len(CALIBRATIONS['thesis'].free)} free numbers costs"


@claim(AGAIN)
def how_near_the_workcell_is() -> Iterator[str]:
    """Simulated beside published errors, by law and speed."""
    for law, title in NAMES.items():
        for speed in (SLOW, FAST):
            rms, largest = (errors("workcell", law, speed, statistic) for statistic in ("rms", "max"))
            simulated, published = rms.mean(axis=0)
            yield (
                f"| {title} | {speed:g} | {simulated:.3f} / {published:.3f} | "
                f"{np.median(off(rms)):.2f} ({np.median(off(largest)):.2f}) | "
                f"{within(rms)} ({within(largest)}) of {len(rms)} |"
            )


@claim(AGAIN)
def what_the_workcell_reproduces() -> Iterator[str]:
    """Medians, order of the laws, and what compensation takes away."""
    rms, largest = every("workcell"), every("workcell", "max")
    yield (
        f"is {np.median(off(rms)):.2f} over the {len(rms)} RMS errors and {np.median(off(largest)):.2f} over as many "
        "largest errors"
    )
    none, static, dynamic = (errors("workcell", law, SLOW)[:, 0] for law in NAMES)
    ordered = int(((dynamic < static) & (static < none)).sum())
    yield f"in {ordered} of {len(none)} cells at {SLOW:g} mm/s."
    gone = {
        (law, speed, column): 100
        * (1 - errors("workcell", law, speed)[:, column].mean() / errors("workcell", "none", speed)[:, column].mean())
        for law in ("lugre_static", "lugre_dynamic")
        for speed in (SLOW, FAST)
        for column in (0, 1)
    }
    slow, fast = (
        [f"{gone[law, speed, column]:.0f} %" for column in (0, 1) for law in ("lugre_static", "lugre_dynamic")]
        for speed in (SLOW, FAST)
    )
    yield (
        f"Compensation takes away {slow[0]} (static) and {slow[1]} (dynamic) of the mean error at {SLOW:g} mm/s, "
        f"{fast[0]} and {fast[1]} at {FAST:g} mm/s; on the real robot it was {slow[2]} and {slow[3]}, then {fast[2]} "
        f"and {fast[3]}."
    )


@claim(AGAIN)
def what_the_workcell_does_not_reproduce() -> Iterator[str]:
    """Circles without compensation, and the sign of what compensation does to the smallest ones."""
    pairs = errors("workcell", "none", SLOW, radius=LARGE).mean(axis=0)
    yield f"circles of {LARGE:g} mm err {100 * (1 - pairs[0] / pairs[1]):.0f} % less than published on average"
    simulated, published = errors("workcell", "none", SLOW, radius=SMALL).T
    assert (simulated < published).tolist() == [True, False, False, True]
    yield f"those of {SMALL:g} mm less at p1 and p4 and more at p2 and p3."
    yield (
        "makes the error larger than without: "
        f"static LuGre by {span(left_of_small('workcell', 'lugre_static') - 1)}, "
        f"dynamic LuGre by {span(left_of_small('workcell', 'lugre_dynamic') - 1)};"
    )


@claim(AGAIN)
def sign_on_the_workcell() -> Iterator[str]:
    """What dynamic LuGre does to the smallest circles."""
    yield f"makes these circles worse, by {span(left_of_small('workcell', 'lugre_dynamic') - 1)}"


@claim(AGAIN)
def workcell_within() -> Iterator[str]:
    """How many errors the workcell was fitted to, and how many are near."""
    rms, largest = every("workcell"), every("workcell", "max")
    yield f"was fitted to all {len(rms)} RMS values and all {len(largest)} largest errors of Tables 4.1 and 4.2"
    yield f"of which {within(rms)} RMS values are within the factor"


@claim(AGAIN)
def left_on_the_workcell() -> Iterator[str]:
    """What dynamic LuGre leaves at the lower speed."""
    left = errors("workcell", "lugre_dynamic", SLOW)[:, 0].mean()
    yield f"was fitted to these numbers and leaves {left:.3f} mm"


@claim(AGAIN)
def workcell_with_friction_behind_springs() -> Iterator[str]:
    """How near the second workcell is, and the sign of what compensation does to the smallest circles."""
    both = {name: within(every(name)) for name in ("workcell", "workcell_arm")}
    assert both["workcell"] == both["workcell_arm"]
    yield f"{both['workcell_arm']} of {len(every('workcell_arm'))} fitted RMS errors are within a factor {FACTOR:g}"
    yield (
        f"dynamic LuGre leaves {span(left_of_small('workcell_arm', 'lugre_dynamic'))} of the error there "
        f"(published {span(left_of_small('workcell_arm', 'lugre_dynamic', 1))}; "
        f"`thesis` {span(left_of_small('workcell', 'lugre_dynamic'))})"
    )
