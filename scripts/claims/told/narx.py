"""What docs/narx.md tells of its made tables, and of settings of the study."""

import re
from collections.abc import Iterator

import numpy as np

from ffgym.diagnosis.identification.narx.fit import N_EVALUATIONS
from ffgym.robot import load_robot
from ffgym.robot.friction import WIDTHS
from ffgym.studies.friction_data import SAMPLE_TIME
from ffgym.studies.torque_prediction import MOVING
from scripts.claims.claim import claim
from scripts.claims.made import table_of
from scripts.thesis import narx as study

AGAIN = "python -m scripts.tables --page narx.md"
PAGE = "docs/narx.md"
JOINTS = tuple(f"a{j}" for j in range(1, 7))
SPEED, OUTPUT, SLIP = "v(k), v(k-1)  (6.19)", "v(k), y(k-1)  (6.20)", "v(k), slip elements"
FIRST, SECOND, ONE_STEP, MEDIAN = "f = 1", "f = 0.5", "f = 0.5, one step", "set V, median record"


def fit(model: str, column: str) -> float:
    """Median fit of a model [%]."""
    return float(table_of(PAGE, "fits")[model][column].split()[0])


def worst(model: str, column: str) -> float:
    """Fit of the worst start [%]."""
    (low,) = re.findall(r"\((\S+) to", table_of(PAGE, "fits")[model][column])
    return float(low)


@claim(AGAIN)
def fits_of_narx() -> Iterator[str]:
    """Fits that the text tells again."""
    yield f"reaches a fit of {fit(OUTPUT, ONE_STEP):.1f} % one step ahead"
    yield f"on set V (median {fit('(6.19), set D', MEDIAN):.0f} against {fit('static curve', MEDIAN):.0f} %)"
    ellipse = fit("OE: v(k), y(k-1)", FIRST)
    yield f"OE draws an ellipse ({ellipse:.0f} %, the static curve {fit('static curve', FIRST):.0f} %)"
    yield f"one step ahead, {fit('ARX: v(k), y(k-1)', ONE_STEP):.1f} % by repeating the last torque"
    linear = "linear: v(k), slip elements"
    (both,) = {f"{fit(linear, column):.0f}" for column in (FIRST, SECOND)}
    yield f"{both} % on both sines and {fit(linear, MEDIAN):.0f} % on the median record of set V"
    first, second, median = (f"{fit(SLIP, column):.0f}" for column in (FIRST, SECOND, MEDIAN))
    yield (
        f"(three neurons on the same elements: {first}, {second} and {median} %, from the worst start "
        f"{worst(SLIP, SECOND):.0f} and {worst(SLIP, MEDIAN):.0f} %)"
    )
    network, lines = fit("v(k), slip elements, set D", MEDIAN), fit("linear: v(k), slip elements, set D", MEDIAN)
    yield f"the network is better (median {network:.0f} against {lines:.0f} %)"


@claim(AGAIN)
def samples_of_narx() -> Iterator[str]:
    """Sample time and amplitude, and what follows from them."""
    ms = 1e3 * SAMPLE_TIME
    yield f"At {ms:g} ms"
    yield f"A = {study.AMPLITUDE:g} rad/s;"
    yield f"A = {study.AMPLITUDE:g} rad/s OE draws"
    yield f"Fitted to {study.ESTIMATION}, or where"
    share = 2 * np.pi * float(study.ESTIMATION.split("f = ")[1]) * SAMPLE_TIME
    yield f"is the acceleration times {ms:g} ms, {100 * share:.1f} % of the speed"
    yield f"worse on the sine of {study.ESTIMATION.split('f = ')[1]} Hz than it was"
    friction = load_robot("one_axis").friction
    speeds = {f"{float(level[0] / friction.bristle_damping[0]):.1f}" for level in (friction.coulomb, friction.static)}
    (near,) = speeds
    yield f"but for speeds near g(v) / σ₁ = {near} rad/s"


@claim(AGAIN)
def settings_of_narx() -> Iterator[str]:
    """Lags, widths, evaluations and samples of the study."""
    now, *lags = (1e3 * SAMPLE_TIME * lag for lag in study.LONG.speed_lags)
    assert now == 0.0
    yield f"lags of {lags[0]:g} and {lags[1]:g} ms; a fit"
    yield f"(`ffgym.robot.friction`; {1e3 * min(WIDTHS):g} to {1e3 * max(WIDTHS):g} mrad, chosen"
    (free,) = (each for each in study.OTHERS if each.name == "free_run")
    yield (
        f"at most {N_EVALUATIONS} evaluations ({study.FEWER_EVALUATIONS} beyond the thesis' two models, "
        f"{free.n_evaluations} for the free run)"
    )
    yield f"of the {round(study.DURATION / SAMPLE_TIME) + 1} samples of a sine"
    yield f"lags are of the full {1e3 * SAMPLE_TIME:g} ms"
    yield f"last two periods or {study.SHORTEST:g} s, as"


@claim("ffgym.studies.torque_prediction")
def still_joints() -> Iterator[str]:
    """Speed below which a joint is not scored."""
    yield f"a joint slower than {MOVING:g} rad/s is not scored"


def measured(model: str, part: str = "measured") -> dict[str, float]:
    """Errors of a model on the run that was not fitted, by joint [N m]."""
    row = table_of(PAGE, part)[model]
    return {joint: float(row[joint].split()[0]) for joint in JOINTS}


@claim(AGAIN)
def measured_narx() -> Iterator[str]:
    """What the text tells of the tables of a measured robot."""
    models = {name: measured(name) for name in table_of(PAGE, "measured") if not name.startswith("RMS")}
    best = {joint: min(errors[joint] for errors in models.values()) for joint in JOINTS}
    curve = models["v(k), no memory"]
    yield (
        f"predicts run C within {max(curve[j] - best[j] for j in ('a2', 'a3', 'a5', 'a6')):.2f} N m of the best model "
        "on axes 2, 3, 5 and 6"
    )
    yield f"it is within {max(models[SPEED][j] - best[j] for j in JOINTS):.2f} N m of the best on all axes"
    ahead, free = ([of[j] for j in JOINTS[3:]] for of in (measured(OUTPUT, "measured, one step"), models[OUTPUT]))
    yield (
        f"one step ahead {min(ahead):.2f} to {max(ahead):.2f} N m on the wrist, in free run {min(free):.2f} to "
        f"{max(free):.2f} N m"
    )
    ratios = [errors[j] / curve[j] for name, errors in models.items() if name[:3] in ("ARX", "OE:") for j in JOINTS]
    yield f"**ARX and OE models leave {min(ratios):.1f} to {max(ratios):.1f} times what the curve leaves**"
