"""What pages tell of stored results of the leaderboard."""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from ffgym.agents.residual.validation import RADIUS
from ffgym.agents.setpoint_rows import UNKNOWN_DELAY
from ffgym.envs.machines import make_rig
from ffgym.leaderboard.adaptation.curve import CurvePoint, curve
from ffgym.leaderboard.adaptation.protocol import LAP, SCORED, SQUARE
from ffgym.leaderboard.comparison.samples import DRAWS, GROUPS, WORKCELLS, collect_sample
from ffgym.leaderboard.evaluation.jobs import lost_cells
from ffgym.leaderboard.plants import NOMINAL, THESIS_WORKCELL, find_plant
from ffgym.leaderboard.tasks import SPLITS
from ffgym.simulation import LaserTracker
from scripts.adaptation import NOMINAL as NOMINAL_ADAPTED
from scripts.claims.claim import claim
from scripts.claims.records import numbers_of
from scripts.tables.leaderboard import (
    GAINS,
    RESIDUALS,
    adapted,
    header_of,
    held_out,
    of_base,
    row_of,
    search_of,
    stored_rows,
)

RESULTS = "ffgym leaderboard --out docs/leaderboard/results"


def left(name: str, group: str = WORKCELLS) -> float:
    """Error that a row leaves [%] on held-out circles of a group of plants."""
    return 100 * row_of(group, name).score.left


@claim(RESULTS)
def what_we_found() -> Iterator[str]:
    """The table of the README."""
    feedback = [line for line in held_out(WORKCELLS).lines if line.row.feedback and line.row.base == "elastic"]
    least, most = (100 * choose(line.score.left for line in feedback) for choose in (min, max))
    lap = row_of(WORKCELLS, "fitted").score.robot_seconds
    yield f"dynamic LuGre feed-forward, nominal numbers | {left('lugre_dynamic'):.0f} % |"
    yield f"elastic feed-forward, nominal numbers | {left('elastic'):.0f} % |"
    yield f"policies of reinforcement learning | {least:.0f} to {most:.0f} % |"
    yield f"fitted to one lap of one circle ({lap:.1f} s) | {left('fitted'):.0f} % |"
    yield f"that a network reads from that lap | {left('amortised'):.0f} % |"


@claim(RESULTS)
def one_lap() -> Iterator[str]:
    """What a lap on the machine and feedback leave on drawn workcells."""
    scores = {name: row_of(WORKCELLS, name).score for name in ("amortised", "fitted", "elastic")}
    lap = f"{scores['amortised'].robot_seconds:.1f} s"
    elastic = by_machine("elastic")
    yield f"move each of them for one lap first, {lap}."
    yield f"from {lap} of motion and leaves {left('amortised'):.0f} % of the error"
    yield f"to the same lap leaves {left('fitted'):.0f} %"
    yield (
        f"with nominal numbers leaves {left('elastic'):.0f} %, {min(elastic):.0f} % on one machine and "
        f"{max(elastic):.0f} % on another, and the best linear feedback on top of it {left('servo_gains_drives'):.0f} %"
    )


def by_machine(name: str) -> list[float]:
    """Error that a row leaves on each drawn workcell [%], a geometric mean over circles and seeds."""
    grid = held_out(WORKCELLS).grid
    logs = [np.log(collect_sample(stored_rows()[each], grid).rms).mean(axis=0).mean(axis=1) for each in (name, "none")]
    found: list[float] = (100 * np.exp(logs[0] - logs[1])).tolist()
    return found


@claim(RESULTS)
def through_set_points() -> Iterator[str]:
    """What set-points keep, and what two samples of delay cost."""
    costs = {group: left("elastic_setpoints_late", group) - left("elastic_setpoints", group) for group in GROUPS}
    *most, least = sorted(costs.values(), reverse=True)
    assert (round(least), min(costs, key=costs.__getitem__)) == (1, THESIS_WORKCELL)
    yield f"cost {most[-1]:.0f} to {most[0]:.0f} percentage points of it"
    late, sent = (speeds(THESIS_WORKCELL, f"elastic_setpoints{suffix}") for suffix in ("_late", ""))
    yield (
        f"{late[100]:.0f} instead of {sent[100]:.0f} um are left at 100 mm/s, but {late[40]:.1f} instead of "
        f"{sent[40]:.1f} um at 40 mm/s"
    )


def speeds(group: str, name: str) -> dict[float, float]:
    """RMS path error of a row [um] by speed [mm/s]."""
    return {each.speed_mm_s: each.rms_um for each in row_of(group, name).score.speeds}


@claim("ffgym leaderboard, which lists its circles")
def where_circles_are() -> Iterator[str]:
    """Circles of each split, and the machines' tracker."""
    for split in SPLITS:
        circles = [cell.key for task in find_plant(NOMINAL).tasks([split]) for cell in lost_cells(task)]
        positions, radii, at = (sorted({key[k] for key in circles}) for k in (1, 2, 3))
        of = "the same radii and speeds" if split == "positions" else None
        where = ", ".join(map(str, positions))
        yield f"| `{split}` | {where}; {of or f'{_list(radii)} mm; {_list(at)} mm/s'} |"
    (tracker,) = (each for each in make_rig(THESIS_WORKCELL).sensors if isinstance(each, LaserTracker))
    yield f"measured by its laser tracker, {1e6 * tracker.noise:.0f} um of noise in each coordinate"


def _list(values: Iterable[Any]) -> str:
    return ", ".join(f"{value:g}" for value in values)


@claim("the code itself")
def delay_of_late_set_points() -> Iterator[str]:
    """Delay that a sender does not know of."""
    yield f"behind a delay of {1e3 * UNKNOWN_DELAY:g} ms that their sender does not know of"


@claim("the code itself")
def circles_of_tuning() -> Iterator[str]:
    """Radius of the circles of tuning."""
    yield f"other points of the work area, {1e3 * RADIUS:g} mm,"


@claim("the code itself")
def protocol_of_adaptation() -> Iterator[str]:
    """Circle that is practised, and motions that are scored."""
    (radius, speed), (_, half_side, _) = LAP, SQUARE
    radii, speeds = zip(*(circle[1:] for circle in SCORED), strict=True)
    yield f"laps of one circle at p1, {1e3 * radius:g} mm at {1e3 * speed:g} mm/s;"
    yield (
        f"({1e3 * min(radii):g} to {1e3 * max(radii):g} mm, {1e3 * min(speeds):g} to {1e3 * max(speeds):g} mm/s), and "
        f"a square of {2e3 * half_side:g} mm with rounded corners at p4"
    )


@claim("python -m scripts.claims --record adaptation_bounds")
def left_with_true_numbers() -> Iterator[str]:
    """What elastic feed-forward leaves with the true numbers of the LuGre model."""
    left = numbers_of("adaptation_bounds")["workcells"]["all true numbers"]
    yield f"elastic feed-forward leaves {100 * np.exp(np.log(left).mean()):.0f} % on workcells"


@claim("python -m scripts.adaptation")
def who_wins_when() -> Iterator[str]:
    """What families leave over the budget, on drawn workcells and on the nominal robot."""
    amortised, fitted = points("amortised"), points("fitted")
    yield (
        f"after {amortised[0].budget_s:.1f} s of motion {100 * amortised[0].left:.1f} % of the error is left, where "
        f"elastic feed-forward with nominal numbers leaves {100 * points('elastic')[0].left:.0f} %, and no motion of "
        f"any machine keeps more than {100 * amortised[0].worst:.0f} % of its error"
    )
    yield f"are nearly enough ({100 * points('amortised_motors')[0].left:.0f} %)"
    yield f"Two more laps add nothing ({100 * amortised[1].left:.1f} %)"
    first, last = (100 * fitted[k].left for k in (0, 2))
    yield f"leaves {first:.0f} % after one lap, and {last:.0f} % after a quarter of a minute"
    yield f"with no motion above {100 * fitted[2].worst:.0f} %"
    ilc = points("ilc_basis")
    yield f"leaves {100 * ilc[0].left:.0f} % after one lap and {100 * ilc[2].left:.0f} % after ten"
    silent = [100 * each.left for each in points("fitted", [NOMINAL_ADAPTED])]
    elastic = 100 * points("elastic", [NOMINAL_ADAPTED])[0].left
    yield (
        f"it leaves {min(silent):.1f} to {max(silent):.1f} % there, where elastic feed-forward leaves {elastic:.1f} %."
    )
    yield f"takes {amortised[0].budget_s:.3f} s, which is the smallest budget"
    by_motion = errors_by_motion("amortised", 1)
    square, fast, slow = by_motion[5], by_motion[:2], by_motion[2:5]
    yield (
        f"keeps most of its error ({square:.0f} %); circles at 100 and 70 mm/s keep "
        f"{min(fast):.0f} %, those at 40, 20 and 10 mm/s {min(slow):.0f} to {max(slow):.0f} %."
    )
    yield f"which leaves {left('model_fitted', THESIS_WORKCELL):.1f} % on `workcell:thesis`"


def points(adapter: str, machines: Sequence[str] = ()) -> list[CurvePoint]:
    """Curve of an adapter, on the drawn workcells if none are given."""
    cells = [run.machine for run in adapted() if run.machine != NOMINAL_ADAPTED]
    return curve(adapted(), adapter, list(dict.fromkeys(machines or cells)))


def errors_by_motion(adapter: str, laps: int) -> list[float]:
    """Error left on each scored motion [%], a geometric mean over machines and seeds."""
    whole = {run.machine: np.array(run.rms_um) for run in adapted() if run.adapter == "none"}
    runs = [run for run in adapted() if (run.adapter, run.laps) == (adapter, laps) and run.machine != NOMINAL_ADAPTED]
    logs = [np.log(np.array(run.rms_um) / whole[run.machine]) for run in runs]
    found: list[float] = (100 * np.exp(np.mean(logs, axis=0))).tolist()
    return found


@claim(RESULTS)
def margins_of_learned_rows() -> Iterator[str]:
    """How much agents with feedback bear."""
    by_path = [name for name, row in stored_rows().items() if row.seeded and not name.endswith("drives")]
    learned = [stored_rows()[name] for name in (*by_path, "servo_gains", "servo_gains_drives")]
    gains = sorted(each.gain for row in learned for each in row.margins)
    stable = [each for row in learned for each in row.margins if each.delay_ms is not None]
    assert len(stable) == 1
    yield f"Of {len(gains)} trainings by path errors alone one is stable there"
    yield f"which bears {stable[0].gain:.2f} times its torque and {stable[0].delay_ms:g} ms"


@claim("python -m scripts.tune_gains")
def servo_gains_found() -> Iterator[str]:
    """Servo gains as they were found, and the search that found them."""
    search = header_of("servo_gains_stable")["meta"]["search"]
    a, b, c = min(search, key=lambda tried: tried[1])[0]
    yield f"What was found is a = {a:g}, b = {b:g}, c = {c:g}"
    (margins,) = stored_rows()["servo_gains_stable"].margins
    yield f"It bears {margins.gain:.1f} times its torque and {margins.delay_ms:g} ms on the nominal robot, somewhat"
    refused = [value for _, value in search if value >= 1]
    yield f"{len(refused)} of {len(search)} candidates were refused"


@claim(RESULTS)
def stable_gains_are_worth() -> Iterator[str]:
    """What stable linear feedback gains."""
    stable = ratio(WORKCELLS, "servo_gains_stable")
    yield f"{100 * (1 - stable):.0f} % less error than `elastic` is what stable linear feedback is worth there"
    yield (
        f"`servo_gains_stable` leaves {ratio(NOMINAL, 'servo_gains_stable'):.1f} times its error, `servo_gains` "
        f"{ratio(NOMINAL, 'servo_gains'):.1f} times."
    )


def ratio(group: str, name: str) -> float:
    """Error of a row over that of its base."""
    found = row_of(group, name).against_base
    assert found is not None
    assert found.difference is not None
    return found.difference.ratio


@claim(RESULTS)
def searched_policies() -> Iterator[str]:
    """What policies leave that were searched for on machines with drives."""
    names = ("ppo_drives", "recurrent_ppo_drives", "sac_drives", "elastic")
    ppo, recurrent, sac, elastic = (f"{left(name):.1f}" for name in names)
    yield f"they leave {ppo}, {recurrent} and {sac} %, as elastic feed-forward does ({elastic} %), and"
    yield f"stable servo gains {left('servo_gains_stable'):.1f} %."
    values = sorted(trial["value"] for trial in search_of("tqc")["trials"])
    yield f"the fourth best of it ({values[3]:.3f} against {values[0]:.3f})"
    tqc = row_of(WORKCELLS, "tqc_drives").against_base
    assert tqc is not None
    assert tqc.difference is not None
    assert tqc.difference.interval is not None
    low, high = tqc.difference.interval.low, tqc.difference.interval.high
    yield (
        f"it leaves {left('tqc_drives'):.1f} %, between {100 * (1 - low):.0f} % less and {100 * (high - 1):.0f} % more "
        "than its base"
    )
    gains = [each.gain for each in stored_rows()["tqc_drives"].margins]
    yield f"(gain margins of {min(gains):.2f} to {max(gains):.2f})"
    yield f"stable servo gains leave {np.exp(header_of('servo_gains_stable')['meta']['log_ratio']):.2f}."


@claim(RESULTS)
def servo_gains_beside_learned_rows() -> Iterator[str]:
    """Servo gains beside residual policies."""
    a, b, c = min(header_of("servo_gains")["meta"]["search"], key=lambda tried: tried[1])[0]
    yield f"a, b, c = {a:.3f}, {b:.3f}, {c:.3f}"
    yield f"found them in {len(header_of('servo_gains')['meta']['search'])} evaluations"
    cell, draws = ({name: f"{ratio(group, name):.2f}" for name in RESIDUALS[:3]} for group in (THESIS_WORKCELL, DRAWS))
    yield (
        f"it leaves {cell['servo_gains']} of the error of `elastic` on the workcell, where SAC, the best, leaves "
        f"{cell['sac_elastic']}, and {draws['servo_gains']} on twenty drawn robots (SAC {draws['sac_elastic']}, PPO "
        f"{draws['ppo_elastic']})."
    )
    drawn = [f"{ratio(WORKCELLS, name):.2f}" for name in ("servo_gains", "sac_elastic", "servo_gains_drives")]
    yield (
        f"it leaves {drawn[0]} of the error of `elastic`, SAC {drawn[1]}, and `servo_gains_drives`, three numbers that "
        f"were tuned on drawn machines with drives, {drawn[2]},"
    )
    yield (
        f"PPO on elastic is better than it, {ratio(NOMINAL, 'ppo_elastic'):.2f} to {ratio(NOMINAL, 'servo_gains'):.2f} "
        "times the error of `elastic`"
    )


@claim(RESULTS)
def stability_of_residuals() -> Iterator[str]:
    """Gain margins of residual policies, and what stable gains are worth."""
    gains = {name: [each.gain for each in stored_rows()[name].margins] for name in (*GAINS, *RESIDUALS[1:4])}
    own = {name: f"{min(each):.2f}" for name, each in gains.items()}
    both = {name: f"{min(each):.2f} to {max(each):.2f}" for name, each in gains.items()}
    yield (
        f"are {own['servo_gains']} (`servo_gains`), {own['servo_gains_drives']} (`servo_gains_drives`), "
        f"{both['ppo_elastic']} (`ppo_elastic`), {both['sac_elastic']} (`sac_elastic`) and "
        f"{both['recurrent_ppo_elastic']} (`recurrent_ppo_elastic`)"
    )
    (stable,) = stored_rows()["servo_gains_stable"].margins
    yield f"bears twice its gain and {stable.delay_ms:g} ms of delay."
    against = {name: row_of(WORKCELLS, name).against_base for name in GAINS}
    yield (
        f"it leaves {of_base(against['servo_gains_stable'])} of the error of `elastic`, `servo_gains_drives`, which "
        f"chatters, {of_base(against['servo_gains_drives'])}."
    )
    yield f"is worth {100 * (1 - ratio(WORKCELLS, 'servo_gains_stable')):.0f} % there"
    worse = [speeds(THESIS_WORKCELL, name)[100] / speeds(THESIS_WORKCELL, "elastic")[100] for name in RESIDUALS[1:5]]
    yield f"those on `elastic` are up to {100 * (max(worse) - 1):.0f} % worse"


@claim(RESULTS)
def what_getting_started_tells_of_the_workcell() -> Iterator[str]:
    """What a fitted model and policies leave on the workcell `thesis`."""
    fitted, none = (speeds(THESIS_WORKCELL, name) for name in ("model_fitted", "none"))
    at = (10, 40, 100)
    yield f"leaves {fitted[10]:.0f}, {fitted[40]:.0f} and {fitted[100]:.0f} um at 10, 40 and 100 mm/s"
    yield f"servo alone leaves {', '.join(f'{none[v]:.0f}' for v in at[:2])} and {none[100]:.0f}."
    names = [
        name for name in RESIDUALS if row_of(THESIS_WORKCELL, name).row.base == "elastic" and name != "servo_gains"
    ]
    less = [100 * (1 - ratio(THESIS_WORKCELL, name)) for name in names]
    yield f"leave {min(less):.0f} to {max(less):.0f} % less than that law"
