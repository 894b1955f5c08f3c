"""Pages of a trial: the plan to print and tick off, and the result to send."""

from collections.abc import Mapping
from typing import Any

from ffgym.deployment.trial.pictures import draw_gains, draw_runs
from ffgym.deployment.trial.plan import TrialPlan
from ffgym.deployment.trial.power import Power
from ffgym.deployment.trial.reading import RunResult, TrialResult
from ffgym.deployment.trial.words import explain_claims, say_power, say_result, tabulate_gains
from ffgym.report.page import Details, Items, Note, Page, Part, Section, words_of
from ffgym.report.table import Cell, Column, Table


def render_plan(plan: TrialPlan, power: Power, info: Mapping[str, Any]) -> str:
    """Render the page of a plan, to print and to tick off run by run.

    Raises:
        FFGymError: if matplotlib or jinja2 is missing.
    """
    words = words_of("trial")
    steps = [words["warm_up"], words["order"], words["names"], words["laps"], words["repeat"]]
    if plan.laps == 1:
        steps.remove(words["laps"])
    return Page(
        title=f"Trial on {plan.robot}",
        subtitle=f"{len(plan.runs)} runs, {plan.pairs} pairs of each program; seed {plan.seed}, plan "
        f"`{plan.digest[:12]}`, committed before the first run.",
        headline=say_power(plan, power),
        parts=[
            Section("Before and while you run", [Items([step.format(laps=plan.laps) for step in steps])]),
            Section("Programs", [_programs(plan)]),
            Section("Runs", [_run_sheet(plan)]),
        ],
        provenance=info,
        is_dated=False,
    ).html()


def render_trial(result: TrialResult, info: Mapping[str, Any]) -> str:
    """Render the page of a result: pictures first, then the gains, what was left out, and every run.

    Raises:
        FFGymError: if matplotlib or jinja2 is missing.
    """
    words, plan = words_of("trial"), result.plan
    parts: list[Part] = [
        draw_runs(result),
        draw_gains(result),
        Section("Gain by program", [tabulate_gains(result), Note(words["gain"]), Note(words["claims"])]),
    ]
    if notes := [*explain_claims(result), *result.notes]:
        parts.append(Section("What was left out, and what to look at", [Items(notes)]))
    parts.append(Section("Runs", [Details("Every run with its log and error", [_runs(result)])]))
    return Page(
        title=f"Gain on {plan.robot}",
        subtitle=f"Randomised trial of {len(plan.runs)} runs; seed {plan.seed}, plan `{plan.digest[:12]}`.",
        headline=say_result(result),
        parts=parts,
        provenance=info,
        is_dated=False,
    ).html()


def _programs(plan: TrialPlan) -> Table:
    speeds = [None if program.speed is None else 1e3 * program.speed for program in plan.programs]
    places = [None if p.place is None else ", ".join(f"{x:.3f}" for x in p.place) for p in plan.programs]
    return Table(
        columns=[
            Column("program", [program.name for program in plan.programs], kind="name"),
            Column("one pass", [program.duration for program in plan.programs], ".2f", unit="s"),
            Column("speed of the tool", speeds, ".3g", unit="mm/s"),
            Column("place of the tool", places, kind="text", unit="m"),
        ],
        name="programs",
    )


def _run_sheet(plan: TrialPlan) -> Table:
    """Tabulate the runs with room for ticks, times and remarks."""
    runs = plan.runs
    kinds = [Cell("WITH" if run.corrected else "without") for run in runs]
    return Table(
        columns=[
            Column("run", [run.number for run in runs]),
            Column("program", [run.program for run in runs], kind="name"),
            Column("correction", kinds, kind="text"),
            Column("log", [run.log for run in runs], kind="code"),
            Column("pair", ["warm-up" if run.is_warm_up else str(run.pair) for run in runs], kind="text"),
            Column("done", ["☐" for _ in runs], kind="text"),
            Column("time, remarks", ["________________" for _ in runs], kind="text"),
        ],
        name="runs",
        ruled_by=4,
    )


def _runs(result: TrialResult) -> Table:
    runs = result.runs
    return Table(
        columns=[
            Column("run", [one.run.number for one in runs]),
            Column("program", [one.run.program for one in runs], kind="name"),
            Column("correction", [one.run.what for one in runs], kind="text"),
            Column("pair", ["warm-up" if one.run.is_warm_up else str(one.run.pair) for one in runs], kind="text"),
            Column("log", [one.log or None for one in runs], kind="code"),
            Column("error", [_known(one.error) for one in runs], ".4g", unit=result.unit.name),
            Column("began", [_known(one.started) for one in runs], ".1f", unit="s"),
            Column("remark", [_remark(one) for one in runs], kind="prose"),
        ],
        name="every-run",
    )


def _known(value: float) -> float | None:
    return None if value != value else value


def _remark(one: RunResult) -> Cell | None:
    if one.left_out:
        return Cell(one.left_out, style="flagged")
    return Cell("not scored") if one.run.is_warm_up else None
