"""Results of a trial in sentences and tables."""

import numpy as np

from ffgym.deployment.trial.gains import OVERALL, Gain
from ffgym.deployment.trial.plan import TrialPlan
from ffgym.deployment.trial.power import LEVEL, Power, compute_power, count_least_pairs, find_least_gain
from ffgym.deployment.trial.reading import TrialResult
from ffgym.report.table import Cell, Column, Table, wrap_text

STYLES = {"gain": "", "worse": "refused", "none": "flagged", "too few": "flagged"}
"""Style of a claim in tables of pages."""


def say_gain(gain: Gain) -> str:
    """Say what may be claimed of one place, with its interval and p-value."""
    if gain.pairs == 0:
        return "no pair of runs is left"
    if gain.claim == "too few":
        return f"one pair tells no interval; its errors differ by {_percent(gain, gain.gain)} %"
    low, high = (_percent(gain, end) for end in (gain.low, gain.high))
    chance = f"p = {_chance(gain.p_adjusted)}"
    if gain.claim == "gain":
        return f"gains {_percent(gain, gain.gain)} % ({low} to {high}), {chance}"
    if gain.claim == "worse":
        least, most = (_percent(gain, -end) for end in (gain.high, gain.low))
        return f"worse by {_percent(gain, -gain.gain)} % ({least} to {most}), {chance}"
    return f"no gain shown: {low} to {high} %, {chance}"


def say_result(result: TrialResult) -> list[str]:
    """Say the gain over all programs first, then that of each."""
    order = sorted(result.gains, key=lambda gain: gain.name != OVERALL)
    return [f"**{gain.name}** {say_gain(gain)}." for gain in order]


def explain_claims(result: TrialResult) -> list[str]:
    """Say why something is not shown though its interval leaves out zero, and which programs the whole is without."""
    sentences = []
    places = sum(1 for gain in result.gains if gain.name != OVERALL)
    lost = [gain.name for gain in result.gains if gain.name != OVERALL and gain.pairs < 2]
    if places > 1 and lost:
        sentences.append(f"{OVERALL}: without {', '.join(lost)}, of which fewer than two pairs are left.")
    least = count_least_pairs(places)
    for gain in result.gains:
        if gain.claim != "none" or gain.low <= 0.0 <= gain.high:
            continue
        if gain.pairs < least and gain.name != OVERALL:
            why = f"{gain.pairs} pairs can be ordered in too few ways for a smaller p-value; {least} pairs can show it"
        else:
            why = f"its own p-value is {_chance(gain.p)}, and {len(result.gains)} claims are made together"
        sentences.append(f"{gain.name}: the interval leaves out zero, and still nothing is claimed, as {why}.")
    return sentences


def tabulate_gains(result: TrialResult) -> Table:
    """Tabulate errors without and with the correction, and the gain, by program."""
    gains, places = result.gains, {program.name: program for program in result.plan.programs}
    speeds = [_speed(result.plan, gain.name) for gain in gains]
    claims = [Cell(say_gain(gain), style=STYLES[gain.claim]) for gain in gains]
    spreads = [None if np.isnan(gain.spread) else 100 * gain.spread for gain in gains]
    return Table(
        columns=[
            Column("program", [gain.name for gain in gains], kind="name"),
            Column("speed", speeds, ".3g", unit="mm/s"),
            Column("pairs", [gain.pairs for gain in gains]),
            Column("without", [_number(gain.without) for gain in gains], ".4g", unit=result.unit.name),
            Column("with", [_number(gain.corrected) for gain in gains], ".4g", unit=result.unit.name),
            Column("spread", spreads, ".2g", unit="%"),
            Column("gain", claims, kind="text"),
        ],
        name="gains",
        strong=[-1] if len(gains) > len(places) > 1 else [],
    )


def format_trial(result: TrialResult) -> str:
    """Format a result for a terminal: sentences, table, and what was left out."""
    counted = sum(1 for one in result.runs if one.counts)
    scored = sum(1 for one in result.runs if not one.run.is_warm_up)
    lines = [sentence.replace("**", "") for sentence in say_result(result)]
    lines += [wrap_text(sentence) for sentence in explain_claims(result)]
    lines += ["", tabulate_gains(result).text(), ""]
    lines.append(f"{result.unit.words} [{result.unit.name}]; {counted} of {scored} runs count.")
    return "\n".join([*lines, *(wrap_text(f"note: {note}") for note in result.notes)])


def format_plan(plan: TrialPlan, power: Power) -> str:
    """Format a plan for a terminal: how many runs, how long, and what they can show."""
    programs = ", ".join(program.name for program in plan.programs)
    each = "each of " if len(plan.programs) > 1 else ""
    pairs = f"{plan.pairs} pair{'s' if plan.pairs > 1 else ''} of {each}{programs}"
    lines = [
        f"{len(plan.runs)} runs: {pairs}; {plan.warm_up} to warm up; "
        f"{plan.seconds / 60:.1f} min in motion. Seed {plan.seed}, plan {plan.digest[:12]}.",
        *say_power(plan, power),
    ]
    return "\n".join(map(wrap_text, lines))


def say_power(plan: TrialPlan, power: Power) -> list[str]:
    """Say how many pairs show the gain that is wanted, and what the planned ones show."""
    wanted = f"To show a gain of {100 * power.gain:.3g} % with a probability of {100 * power.power:.3g} %"
    needed = "more than 500" if power.needed is None else str(power.needed)
    chance = compute_power(power.gain, power.spread, plan.pairs, places=power.places)
    least = find_least_gain(power.spread, plan.pairs, power=power.power, places=power.places)
    shown = "none" if least is None else f"one of {100 * least:.2g} % and more"
    lines = [
        f"{wanted}, where the ratios of pairs scatter by {100 * power.spread:.2g} % ({power.source}), {needed} pairs "
        f"of each program are needed. With {plan.pairs}, as planned, it is {100 * chance:.0f} %, and the smallest gain "
        f"that they show with {100 * power.power:.3g} %: {shown}."
    ]
    if plan.pairs < (fewest := count_least_pairs(power.places)):
        lines.append(
            f"With fewer than {fewest} pairs of each program nothing can be claimed of a single one: their order could "
            f"have come about by chance with more than {100 * LEVEL:.0f} %, however large the gain is."
        )
    return lines


def _speed(plan: TrialPlan, name: str) -> float | None:
    speeds = [program.speed for program in plan.programs if program.name == name]
    return None if not speeds or speeds[0] is None else 1e3 * speeds[0]


def _number(value: float) -> float | None:
    return None if np.isnan(value) else value


def _percent(gain: Gain, share: float) -> str:
    """Write a share in percent, with a decimal where the interval is narrower than that of whole numbers."""
    fine = np.isfinite(gain.high) and gain.high - gain.low < 0.03
    text = f"{100 * share:.{1 if fine else 0}f}"
    return text.removeprefix("-") if not float(text) else text


def _chance(p: float) -> str:
    """Write a p-value."""
    return f"{p:.2g}"
