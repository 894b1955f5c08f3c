"""Curve of adaptation: `python -m scripts.adaptation` runs what is missing, and draws; docs/leaderboard/adaptation.md.

Results are kept in one file after every group of runs, so that a run that was stopped goes on; runs of other physics or
another artefact are made again.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ffgym.agents.adapters import ADAPTERS
from ffgym.agents.trials import add_sensors
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import check_choice
from ffgym.envs.machines import make_rig
from ffgym.leaderboard.adaptation.curve import CurvePoint, curve
from ffgym.leaderboard.adaptation.evaluation import AdaptationEntry, Subject, evaluate, list_entries
from ffgym.leaderboard.adaptation.protocol import Adapter, lap, scored_motions
from ffgym.leaderboard.adaptation.results import AdaptationResults, AdaptationRun, read_results, write_results
from ffgym.leaderboard.submission.rounds import read_round
from ffgym.report.figure import panels, save_figure

NOMINAL = "irb4600_60_205_arm_drives"
"""Robot on which an adapter must stay silent: its machine is its model."""

START = 1.0
"""Left end of the picture [s], where laws stand that move nothing."""


@dataclass(frozen=True)
class Config:
    """Adapters and machines to run."""

    machines: tuple[str, ...] = ()
    """Names of machines; none given are those of the round, and the nominal robot."""
    round: Path = Path("docs/leaderboard/adaptation_round.json")
    """File of a revealed round, whose machines are run."""
    adapters: tuple[str, ...] = tuple(adapter.name for adapter in ADAPTERS)
    most_laps: int = 538
    """Largest budget in laps."""
    seeds: int = 5
    """Largest number of seeds of each."""
    threads: int = 0
    """Threads of the engine, 0 for all cores."""
    out: Path = Path("docs/leaderboard/adaptation.json")
    """File of the results."""
    picture: Path | None = Path("docs/pictures/adaptation.png")


def main(config: Config) -> None:
    """Run what is missing, write, print."""
    for name in config.adapters:
        check_choice("adapter", name, [adapter.name for adapter in ADAPTERS])
    machines = config.machines or (*read_round(config.round).plants, NOMINAL)
    subjects = [Subject(name=name, rig=add_sensors(make_rig(name))) for name in machines]
    chosen = [adapter for adapter in ADAPTERS if adapter.name in config.adapters]
    entries = [
        entry
        for entry in list_entries(chosen, subjects)
        if entry.laps <= config.most_laps and entry.seed < config.seeds
    ]
    arm = subjects[0].rig.arm
    known = read_results(config.out).runs if config.out.exists() else ()
    kept = {run.key: run for run in known}
    missing = [entry for entry in entries if not _is_current(kept.get(entry.key), entry)]
    with progress_bar("adaptation", "runs") as progress:
        done = 0
        for runs in evaluate(missing, config.threads):
            kept |= {run.key: run for run in runs}
            motions = tuple(motion.name for motion in scored_motions(arm))
            results = AdaptationResults(
                motions=motions, lap=lap(arm).name, runs=tuple(kept[key] for key in sorted(kept))
            )
            write_results(config.out, results)
            done += len(runs)
            progress(float(done), float(len(missing)))
    cells = [name for name in machines if name != NOMINAL]
    every = tuple(kept.values())
    print(format_table(every, ADAPTERS, cells))
    if NOMINAL in machines:
        print("\nNominal robot:\n" + format_table(every, ADAPTERS, [NOMINAL]))
    if config.picture is not None:
        draw({adapter.title: curve(every, adapter.name, cells) for adapter in ADAPTERS[1:]}, config.picture)


def format_table(runs: Sequence[AdaptationRun], adapters: Sequence[Adapter], machines: Sequence[str]) -> str:
    """Format the error left as a table of Markdown, a row for each adapter and budget."""
    lines = ["| family | robot time | error left | over machines | worst motion |", "|---|---|---|---|---|"]
    for adapter in adapters[1:]:
        for point in curve(runs, adapter.name, machines):
            low, high = point.by_machine.min(), point.by_machine.max()
            spread = "" if point.spread is None else f" [{point.spread.low:.1%}, {point.spread.high:.1%}]"
            lines.append(
                f"| {adapter.title} | {point.budget_s:.1f} s | {point.left:.1%}{spread} | {low:.1%} to {high:.1%} "
                f"| {point.worst:.0%} |"
            )
    return "\n".join(lines)


def draw(curves: Mapping[str, Sequence[CurvePoint]], path: Path) -> None:
    """Draw error left over robot time: a line with its interval for each family, thin lines for machines."""
    with panels(size=(7.0, 5.0)) as (figure, ((axes,),)):
        last = max(point.budget_s for points in curves.values() for point in points)
        for k, (title, points) in enumerate(curves.items()):
            if not points:
                continue
            # laws that move nothing are level lines
            times = [max(point.budget_s, START) for point in points]
            left = [point.left for point in points]
            if len(points) == 1:
                times, left = [START, last], left * 2
            axes.plot(times, left, marker="o" if len(points) > 1 else "", color=f"C{k}", label=title, zorder=3)
            for point in points:
                if point.spread is not None and len(points) > 1:
                    axes.plot([point.budget_s] * 2, [point.spread.low, point.spread.high], color=f"C{k}", zorder=3)
            for row in range(len(points[0].machines) if len(points) > 1 else 0):
                own = [point.by_machine[row] for point in points if row < len(point.by_machine)]
                axes.plot(times[: len(own)], own, color=f"C{k}", linewidth=0.5, alpha=0.35)
        axes.set(xscale="log", yscale="log", xlabel="motion of the robot [s]", ylabel="error left [%]")
        axes.yaxis.set_major_formatter(lambda value, place: f"{value * 100:g}")
        axes.yaxis.set_minor_formatter(lambda value, place: f"{value * 100:.0f}" if f"{value:.0e}"[0] in "25" else "")
        axes.xaxis.set_major_formatter(lambda value, place: f"{value:g}")
    save_figure(figure, path)


def _is_current(run: AdaptationRun | None, entry: AdaptationEntry) -> bool:
    """Check that a run is of these physics, and of the present artefact."""
    wanted = entry.subject.rig.fingerprint, entry.adapter.artefact(entry.seed)
    return run is not None and (run.fingerprint, run.artefact) == wanted


if __name__ == "__main__":
    import tyro

    main(tyro.cli(Config))
