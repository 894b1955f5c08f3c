"""What docs/published_robot.md tells of its result file, and of the published tables."""

import json
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

import numpy as np

from ffgym.core.files import read_text
from ffgym.published import published_mm
from scripts.claims.claim import claim
from scripts.tables.published_robot import RESULT

AGAIN = "ffgym diagnose --table thesis --json docs/published_robot.json"
CORNERS = ("p1", "p2", "p3", "p4")


@cache
def result() -> Mapping[str, Any]:
    """Read the result of the diagnosis from the published tables."""
    found: Mapping[str, Any] = json.loads(read_text(RESULT))
    return found


def structure(name: str) -> Mapping[str, Any]:
    """Find a structure of the model by its name."""
    (found,) = (each for each in result()["structures"] if each["name"] == name)
    fit: Mapping[str, Any] = found
    return fit


def number(of: str, name: str) -> float:
    """Find a fitted number of a structure by the beginning of its name."""
    (found,) = (each["value"] for each in structure(of)["numbers"] if each["name"].startswith(name))
    return float(found)


def rms_of(law: str, position: str) -> float:
    """Published RMS error on the circle of 1 mm at 40 mm/s [mm]."""
    value = published_mm(law, "rms", 0.04, 0.001, position)
    assert value is not None
    return value


@claim(AGAIN)
def two_facts() -> Iterator[str]:
    """Where the simulated robot disagrees with the published one."""
    yield f"The tables of the thesis are {len(result()['rows'])} measurements of a real robot."
    ratios = [rms_of("lugre_dynamic", place) / rms_of("none", place) for place in CORNERS]
    yield f"LuGre feed-forward took {100 * (1 - max(ratios)):.0f} to {100 * (1 - min(ratios)):.0f} % off"
    ours = structure("numbers")
    fitted = [row for row in result()["rows"] if row["use"] == "fitted"]
    rms = [row for row in fitted if row["statistic"] == "rms"]
    yield (
        f"Each structure was fitted to the {len(fitted)} errors of Tables 4.1 and 4.2 ({len(rms)} RMS and "
        f"{len(fitted) - len(rms)} largest errors"
    )
    most = max(each["free_parameters"] for each in result()["structures"])
    yield f"at most {most} free numbers and their priors"
    assert ours["fitted_rms"] == len(rms)


@claim(AGAIN)
def what_structures_explain() -> Iterator[str]:
    """What backlash, friction behind the elasticity and wrong friction explain."""
    gap, arm, wrong, numbers = (
        structure(name) for name in ("backlash", "arm_friction", "wrong_friction", "description")
    )
    of, held = gap["fitted_rms"], gap["held_out_rms"]
    yield f"**Backlash** of {1e6 * number('backlash', 'half gap'):.0f} µrad to either side in joints 1 to 3"
    yield f"{gap['fitted_within_1_5']} of {of} fitted and {gap['held_out_within_1_5']} of {held} held-out RMS errors"
    yield f"({100 * number('arm_friction', 'share'):.0f} % of the friction of joints 1 to 3 acts on the arm"
    yield f"{arm['fitted_within_1_5']} of {of} fitted and {arm['held_out_within_1_5']} of {held} held-out errors"
    yield f"({arm['score']:.3f} against {gap['score']:.3f})"
    yield f"the distance of the robot as described ({numbers['score']:.3f})."
    low, high = min(wrong["sign_ratios"]), max(wrong["sign_ratios"])
    yield (
        f"explains {wrong['fitted_within_1_5']} of {of} fitted errors, and has the sign right by a hair ({low:.2f} to "
        f"{high:.2f}), but fewer held-out errors ({wrong['held_out_within_1_5']} of {held})"
    )


@claim(AGAIN)
def what_it_means() -> Iterator[str]:
    """Consequences of a gap and of a share."""
    gap = 1e6 * number("backlash", "half gap")
    low, high = (round(gap) * 1e-3 * reach for reach in (1.0, 1.5))
    yield f"({gap:.0f} µrad at 1 to 1.5 m are {low:.2f} to {high:.2f} mm)"
    yield f"If the share of {number('arm_friction', 'share'):.2f} sits behind it"


@claim(AGAIN)
def sign_in_fits() -> Iterator[str]:
    """Ratios with dynamic LuGre over none on the smallest circles, in fits, as docs/reproduction.md has them."""
    wrong, arm = (structure(name)["sign_ratios"] for name in ("wrong_friction", "arm_friction"))
    yield f"by a hair ({min(wrong):.2f} to {max(wrong):.2f})."
    yield f"do in such a fit ({min(arm):.2f} to {max(arm):.2f})"


@claim("ffgym.published")
def small_circles_of_the_real_robot() -> Iterator[str]:
    """Mean published errors on circles of 1 mm at 40 mm/s."""
    none, dynamic = (np.mean([rms_of(law, place) for place in CORNERS]) for law in ("none", "lugre_dynamic"))
    yield f"it became a little smaller ({none:.2f} to {dynamic:.2f} mm)."
