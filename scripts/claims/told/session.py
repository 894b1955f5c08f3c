"""What pages tell of measuring, identifying and compensating on the workcell `thesis`."""

from collections.abc import Iterator

import numpy as np

from scripts.claims.claim import claim
from scripts.claims.records import numbers_of

AGAIN = "python -m scripts.claims --record session"


def left(when: str, agent: str, speed: float) -> list[float]:
    """RMS path errors of the circles at a speed [mm]."""
    return [row["rms_mm"] for row in numbers_of("session")[when] if (row["agent"], row["speed_mm_s"]) == (agent, speed)]


def mean(when: str, agent: str, speed: float) -> str:
    """Mean of these errors as pages print it."""
    return f"{np.mean(left(when, agent, speed)):.3f}"


@claim(AGAIN)
def measured_and_compensated() -> Iterator[str]:
    """What the workcell errs before and after identification."""
    record = numbers_of("session")
    found = [each for each in record["parameters"] if each["status"] == "identified"]
    assert len(found) == len(record["parameters"])
    good, usable = (record["verdicts"].get(verdict, 0) for verdict in ("good", "usable"))
    assert usable == 1
    yield f"All {len(found)} parameters are identified; {good} logs are good, one is usable"
    before, after = ([left("before", "lugre_dynamic", v), left("after", "lugre_dynamic", v)] for v in (10.0, 40.0))
    less = sum(new < old for olds, news in (before, after) for old, new in zip(olds, news, strict=True))
    count = sum(len(olds) for olds, _ in (before, after))
    yield (
        f"mean RMS path error of the {len(before[0])} circles: {mean('after', 'lugre_dynamic', 10.0)} mm instead of "
        f"{mean('before', 'lugre_dynamic', 10.0)} mm at 10 mm/s, {mean('after', 'lugre_dynamic', 40.0)} mm instead of "
        f"{mean('before', 'lugre_dynamic', 40.0)} mm at 40 mm/s, smaller on {less} of {count} circles"
    )


@claim(AGAIN)
def table_of_getting_started() -> Iterator[str]:
    """The same as a table."""
    yield f"Mean RMS path error of the {len(left('before', 'none', 10.0))} circles"
    for speed in (10.0, 40.0):
        cells = [("before", "none"), ("before", "lugre_dynamic"), ("after", "lugre_dynamic")]
        yield f"| {speed:g} mm/s | {' | '.join(f'{mean(*cell, speed)} mm' for cell in cells)} |"


@claim(AGAIN)
def re_identified() -> Iterator[str]:
    """The same in one line."""
    before, after = (mean(when, "lugre_dynamic", 10.0) for when in ("before", "after"))
    yield f'"Re-identified friction leaves {after} instead of {before} mm"'
