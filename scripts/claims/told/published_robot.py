"""What docs/published_robot.md tells of its result file, and of the published tables."""

import json
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

import numpy as np

from ffgym.core.files import read_text
from ffgym.paths import RADII
from ffgym.published import published_mm
from ffgym.robot import load_robot
from scripts.claims.claim import claim
from scripts.claims.made import table_of
from scripts.claims.records import numbers_of
from scripts.claims.told.thesis import shares
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
    adds = [100 * (ratio - 1) for ratio in structure("description")["sign_ratios"]]
    yield f"the same feed-forward adds {min(adds):.0f} to {max(adds):.0f} %."
    ours = structure("numbers")
    rows = [
        (row["value_mm"], predicted)
        for row, predicted in zip(result()["rows"], structure("description")["predicted_mm"], strict=True)
        if (row["law"], row["statistic"], row["speed_mm_s"]) == ("lugre_dynamic", "rms", 10.0)
    ]
    real, simulated = zip(*rows, strict=True)
    yield f"the real robot keeps {min(real):.2f} to {max(real):.2f} mm."
    yield f"The simulated one keeps {min(simulated):.2f} to {max(simulated):.2f} mm"
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
    yield f"with bristles {number('wrong_friction', 'bristle stiffness'):.1f} times as stiff as they are)"
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


@claim("python -m scripts.tables --page published_robot.md")
def headlines_of_the_published_robot() -> Iterator[str]:
    """What elastic feed-forward removes where all friction is on motors."""
    yield f"over the {len(RADII) * len(CORNERS)} circles, perfect parameters"
    page = "docs/published_robot.md"
    left = {
        law: float(table_of(page, "headlines")[f"numbers only, {law}"]["40 mm/s"])
        for law in ("dynamic LuGre", "elastic, all friction on the motor")
    }
    elastic, lugre = left["elastic, all friction on the motor"], left["dynamic LuGre"]
    yield f"removes {100 * (1 - elastic / lugre):.0f} %"


@claim("python -m scripts.claims --record slow_triangle")
def shares_of_slow_triangles() -> Iterator[str]:
    """Shares of joint 1 that a slow triangle shows, and the truth of the first machine."""
    record = numbers_of("slow_triangle")
    said = {"irb4600_60_205": "`irb4600_60_205`, all losses on the motor"}
    for row in record["shares"]:
        low, high = row["interval"]
        name = said.get(row["machine"], f"`{row['machine']}`")
        yield f"| {name} | {row['share']:.2f}, {low:.2f} to {high:.2f} |"
    robot, nominal = (load_robot(name) for name in ("irb4600_60_205_arm_losses", "irb4600_60_205"))
    stiffer = robot.drive.joint_stiffness[0] / nominal.drive.joint_stiffness[0]
    share = robot.arm_share[0]
    yield f"The truth of the first is {share:.2f} with a stiffness that is {100 * (stiffer - 1):.0f} % above"


@claim(AGAIN)
def separating_sessions() -> Iterator[str]:
    """Difference of two structures in the session that separates them best."""
    most = result()["separating_sessions"][0]["unexplained_max_mm"]
    yield f"differ there by up to {most:.1f} mm that no other numbers make up for"


@claim("python -m scripts.claims --record thesis; python -m scripts.claims --record networks")
def what_the_demo_shows() -> Iterator[str]:
    """What docs/getting_started.md tells of compensation."""
    harm = {
        row["agent"]: row["rms_mm"]
        for row in numbers_of("networks")["rows"]
        if (row["position"], row["radius_mm"], row["speed_mm_s"]) == ("p1", 1.0, 40.0)
    }
    more, less = harm["lugre_dynamic"] / harm["none"] - 1, 1 - rms_of("lugre_dynamic", "p1") / rms_of("none", "p1")
    yield f"by {100 * more:.0f} % at p1 with dynamic LuGre, where the real robot's shrank by {100 * less:.0f} %"
    usual, fast = (100 - share for share in shares("agents-elastic"))
    yield f"removes {usual:.0f} % of what dynamic LuGre leaves at 40 mm/s and {fast:.0f} % at 100 mm/s"
    yield f"With {100 * number('arm_friction', 'share'):.0f} % of the friction behind them"
