"""Leaderboard as a folder with one file per row; missing outcomes are run, and kept as soon as they are complete."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

from ffgym.core.errors import FFGymError
from ffgym.core.executors import Executor
from ffgym.core.files import filled_folder, made_folder, write_text
from ffgym.leaderboard.entrants import Entrant, Registry, find_entrants
from ffgym.leaderboard.evaluation import jobs as work
from ffgym.leaderboard.plants import drives_plant, find_plant
from ffgym.leaderboard.results import DIGITS, Margins, Outcome, Row, decode_row, encode_row, read_row
from ffgym.leaderboard.tasks import SPLITS, duration_of
from ffgym.simulation.run import Progress


@dataclass(kw_only=True, eq=False)
class Board:
    """Rows, in memory and, if there is a folder, in files."""

    registry: Registry
    """Source of the entrants, see `find_entrants`."""
    folder: Path | None = None
    rows: dict[str, Row] = field(default_factory=dict, init=False)

    def __post_init__(self) -> None:
        """Read the files of the folder; FFGymError if it is no folder, or a file in it cannot be read."""
        try:
            is_other = self.folder is not None and self.folder.exists() and not self.folder.is_dir()
        except OSError as error:
            raise FFGymError(f"{self.folder}: cannot be read: {error.strerror}; choose another folder.") from error
        if is_other:
            raise FFGymError(f"{self.folder}: is a file, must be a folder of result files; choose another name.")
        self._read()

    def _read(self) -> None:
        for path in sorted(self.folder.glob("*.json")) if self.folder is not None else ():
            row = read_row(path)
            if row.name != path.stem:
                raise FFGymError(f"{path}: holds the row {row.name!r}; rename it to {row.name}.json, or remove it.")
            self.rows[row.name] = row

    @contextmanager
    def hold(self) -> Iterator[None]:
        """Hold the folder against other processes, after reading the rows that they wrote before."""
        if self.folder is None:
            yield
            return
        with filled_folder(self.folder):
            self._read()
            yield

    def run(
        self,
        entrants: Sequence[Entrant],
        plants: Sequence[str],
        splits: Sequence[str],
        n_seeds: int,
        executor: Executor,
        progress: Progress | None = None,
    ) -> float:
        """Run missing outcomes; return their simulated seconds.

        Args:
            entrants: agents to run.
            plants: names of the plants.
            splits: splits of circles.
            n_seeds: largest number of seeds of rows that a seed changes.
            executor: executor of the jobs.
            progress: function that is called with the simulated seconds done and their total.

        Raises:
            FFGymError: if an agent or a plant cannot be run, a result cannot be written, or another process fills the
                folder. Complete outcomes are kept.
        """
        with self.hold():
            missing = list(self._missing(entrants, plants, splits, n_seeds))
            jobs = work.jobs_for(self.registry, missing, splits)
            seconds = {plant: sum_durations([plant], splits) for plant in dict.fromkeys(plants)}
            total, done, run = sum(seconds[plant] for _, _, plant in missing), 0.0, 0.0
            if progress is not None and jobs:
                progress(0.0, total)
            for i, outcomes in executor.run(work.run_job, jobs):
                self.keep(outcomes)
                done += len(jobs[i].agents) * seconds[jobs[i].plant]
                run += len(outcomes) * seconds[jobs[i].plant]  # without agents that lack a plant
                if progress is not None:
                    progress(done, total)
        return run

    def _missing(
        self, entrants: Iterable[Entrant], plants: Sequence[str], splits: Sequence[str], n_seeds: int
    ) -> Iterable[work.Wanted]:
        """List agents, seeds and plants whose outcomes are missing, old, or lack circles."""
        for plant in plants:
            fingerprint = find_plant(plant).fingerprint
            keys = {cell.key for task in find_plant(plant).tasks(splits) for cell in work.lost_cells(task)}
            for entrant in entrants:
                for seed in entrant.seeds[:n_seeds]:
                    known = self._known(entrant.name, seed, plant)
                    same = known is not None and _is_current(known, entrant, fingerprint)
                    if known is None or not same or not keys <= {cell.key for cell in known.cells}:
                        yield entrant.name, seed, plant

    def _known(self, name: str, seed: int, plant: str) -> Outcome | None:
        row = self.rows.get(name)
        return None if row is None else next((o for o in row.outcomes if o.key == (seed, plant)), None)

    def measure_margins(
        self, entrants: Sequence[Entrant], n_seeds: int, executor: Executor, progress: Progress | None = None
    ) -> None:
        """Measure missing stability margins of agents with feedback that have a row; arguments are those of `run`.

        Raises:
            FFGymError: if an agent cannot be run, a result cannot be written, or another process fills the folder.
        """
        with self.hold():
            rows = {entrant.name: self.rows[entrant.name] for entrant in entrants if entrant.name in self.rows}
            known = {(name, each.seed): each for name, row in rows.items() for each in row.margins}
            jobs = [
                work.MarginsJob(self.registry, entrant.name, seed)
                for entrant in entrants
                if entrant.feedback and entrant.name in rows
                for seed in entrant.seeds[:n_seeds]
                if not _are_current(known.get((entrant.name, seed)), entrant)
            ]
            for done, (i, found) in enumerate(executor.run(work.run_margins_job, jobs), start=1):
                if found is not None:
                    self._keep_margins(jobs[i].name, found)
                if progress is not None:
                    progress(done, len(jobs))

    def _keep_margins(self, name: str, found: Margins) -> None:
        """Put the margins of a seed into their row, and write it."""
        row = self.rows[name]
        every = {each.seed: each for each in (*row.margins, found)}
        made = replace(row, margins=tuple(every[seed] for seed in sorted(every)))
        self._write(replace(decode_row(encode_row(made), name), outcomes=row.outcomes))  # with the digits of a file

    def _write(self, row: Row) -> None:
        """Keep a row, and write it if there is a folder."""
        self.rows[row.name] = row
        if self.folder is not None:
            with made_folder(self.folder):
                write_text(self.folder / f"{row.name}.json", encode_row(row))

    def keep(self, outcomes: Sequence[tuple[str, Outcome]]) -> None:
        """Put outcomes into their rows, and write the rows."""
        every = find_entrants(self.registry)
        for name in dict.fromkeys(name for name, _ in outcomes):
            head = every[name].row()
            known = self.rows.get(name, head)
            made = replace(head, outcomes=tuple(outcome for own, outcome in outcomes if own == name))
            new = decode_row(encode_row(made), name).outcomes  # with the digits of a file
            joined = [_join(self._known(name, *o.key), o, every[name]) for o in new]
            every_outcome = {outcome.key: outcome for outcome in (*known.outcomes, *joined)}
            ordered = tuple(sorted(every_outcome.values(), key=_order))
            self._write(replace(head, outcomes=ordered, margins=known.margins))

    def current(self) -> tuple[list[Row], list[str]]:
        """Return rows that can be compared, in the order of entrants, and sentences on those left out.

        Left out are outcomes of other physics or another artefact than those of this version, and rows of agents that
        are no entrants.
        """
        every = find_entrants(self.registry)
        told = [f"{name} is no agent of this leaderboard" for name in self.rows if name not in every]
        rows = []
        for name, entrant in every.items():
            if name not in self.rows:
                continue
            margins = tuple(each for each in self.rows[name].margins if _are_current(each, entrant))
            row = replace(entrant.row(), outcomes=self.rows[name].outcomes, margins=margins)
            kept = tuple(o for o in row.outcomes if _is_current(o, entrant, find_plant(o.plant).fingerprint))
            if len(kept) < len(row.outcomes):
                old = len(row.outcomes) - len(kept)
                told.append(f"{name} has {old} of {len(row.outcomes)} outcomes of other physics or artefacts")
            rows.append(replace(row, outcomes=kept))
        return rows, told


def _is_current(outcome: Outcome, entrant: Entrant, fingerprint: str) -> bool:
    """Check that an outcome is of these physics, and of the present artefact."""
    wanted = fingerprint, entrant.artefact(outcome.plant, outcome.seed)
    return (outcome.fingerprint, outcome.artefact) == wanted


def _are_current(margins: Margins | None, entrant: Entrant) -> bool:
    """Check that margins are there, of the present machine with drives, and of the present artefact."""
    if margins is None:
        return False
    plant = drives_plant()
    wanted = plant.fingerprint, entrant.artefact(plant.name, margins.seed)
    return (margins.fingerprint, margins.artefact) == wanted


def _order(outcome: Outcome) -> tuple[bool, str, int, int]:
    """Sort outcomes: nominal, workcell, draws by number; then seeds."""
    draw = outcome.plant_draw
    return draw is not None, "" if draw is not None else outcome.plant, -1 if draw is None else draw, outcome.seed


def _join(old: Outcome | None, new: Outcome, entrant: Entrant) -> Outcome:
    """Add cells and trails of an old outcome of the same agent and physics to the new one.

    An agent that practises on every task moved the machine for those too, as long as they last.
    """
    if old is None or (old.fingerprint, old.artefact) != (new.fingerprint, new.artefact):
        return new
    cells = {cell.key: cell for cell in (*old.cells, *new.cells)}
    trails = {(trail.position, trail.radius_mm, trail.speed_mm_s): trail for trail in (*old.trails, *new.trails)}
    seconds = new.robot_seconds
    if entrant.slow:
        before, now = ({cell.split for cell in each.cells} for each in (old, new))
        share = sum_durations([new.plant], list(before - now)) / sum_durations([new.plant], list(before))
        seconds += share * old.robot_seconds
    return replace(
        new,
        versions="; ".join(dict.fromkeys([*old.versions.split("; "), new.versions])),
        cells=tuple(sorted(cells.values(), key=lambda cell: SPLITS.index(cell.split))),  # within each as it was run
        trails=tuple(sorted(trails.values(), key=lambda trail: (trail.position, trail.radius_mm, trail.speed_mm_s))),
        robot_seconds=float(f"{seconds:.{DIGITS}g}"),
    )


def sum_durations(plants: Sequence[str], splits: Sequence[str]) -> float:
    """Sum the durations of all motions of splits on these plants [s]."""
    return sum(
        duration_of(find_plant(plant).rig.arm, task) for plant in plants for task in find_plant(plant).tasks(splits)
    )
