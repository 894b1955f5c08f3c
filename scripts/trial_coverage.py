"""Measure how honest `ffgym trial` is: how often its intervals hold the true gain, and how often it claims too much.

python -m scripts.trial_coverage --json docs/deployment/trial_coverage.json

Every repetition is a trial of its own on a workcell: the order of runs is drawn anew, the machine was switched on at
most half an hour before and warms up while it runs, Coulomb friction of every joint differs from run to run, and
sensors are noisy. Nothing is shared between repetitions. Logs are read as `ffgym trial read` reads them.

**The true gain** of a repetition is that of the same workcell with perfect sensors, at the times of its runs:
1 - exp(mean over the slots of its pairs of E[ln e_on] - E[ln e_off]), where e is the error of a run at the temperature
of the slot, and E the expectation over friction from run to run. It is computed on a grid of times, with draws of
friction in pairs of opposite sign, and interpolated.

Three corrections are tried: elastic feed-forward, one that does nothing, and one that gains nothing while it moves the
error to the other side: elastic feed-forward, made larger until the RMS error is as without it (`mirrored`). It is so
at one temperature only, that of the middle of its trials: what it gains before, it loses later, or the other way.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import scipy

from ffgym.agents.elastic import elastic_law
from ffgym.control import FeedForwardLaw, NoCompensation
from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.files import read_text, write_json
from ffgym.core.provenance import versions
from ffgym.core.types import Array
from ffgym.deployment.trial.gains import OVERALL
from ffgym.deployment.trial.passes import find_passes
from ffgym.deployment.trial.plan import TrialPlan, plan_trial
from ffgym.deployment.trial.program import TrialProgram, make_program
from ffgym.deployment.trial.reading import read_trial
from ffgym.deployment.trial.rehearsal import VARIATION, compute_starts, rehearse, vary_friction
from ffgym.deployment.trial.scoring import score_run
from ffgym.envs.machines import make_rig
from ffgym.paths import Reference, cartesian_reference
from ffgym.simulation import Rig, Run
from ffgym.simulation.plant import Machine
from ffgym.studies.circles import circle_path

Circle = tuple[str, float, float]
"""Position in the work area, speed [m/s] and radius [m]."""
CIRCLES: tuple[Circle, ...] = (("p1", 0.1, 0.005), ("p2", 0.04, 0.003))
"""Programs of the trials."""
LAWS = ("elastic", "nothing", "mirrored")
"""Corrections that are tried."""
LATEST = 1800.0
"""Latest begin of a trial since the machine was switched on [s]."""
DRIFT = 0.01
"""Least change of an error, without correction or with, from the first trial to the last, as a share: without any,
intervals could not be wrong about drift."""
_PARTS = ("gain", "low", "high", "p", "p_adjusted")
"""Numbers of a gain that are kept."""
_TIMES, _DRAWS = 7, 8
"""Times of the grid on which the true gain is computed, and draws of friction at each, half of them mirrored."""


@dataclass(frozen=True, eq=False)
class Scaled(FeedForwardLaw):
    """A law made larger, by a factor for each motion."""

    law: FeedForwardLaw
    factors: Mapping[str, float]
    name: ClassVar[str] = "mirrored"

    def torque(self, reference: Reference) -> Array:
        """Return the torque of the law times the factor of the motion [N m], shape (T, N)."""
        return self.factors[reference.name] * self.law.torque(reference)


@dataclass(frozen=True)
class Config:
    """Machines and repetitions."""

    machines: tuple[str, ...] = ("workcell:thesis", "workcell:3")
    """Workcells, with friction that temperature changes."""
    laws: tuple[str, ...] = LAWS
    """Corrections."""
    repetitions: int = 100
    """Trials of each correction on each workcell."""
    pairs: int = 8
    """Pairs of runs of each program."""
    seed: int = 31
    """Seed of everything that is drawn."""
    json: Path | None = None
    """File for every number; repetitions that it holds are not made again."""


def measure_exactly(rig: Rig, program: TrialProgram, law: FeedForwardLaw, machines: Sequence[Machine]) -> Array:
    """Measure logarithms of errors of a program with perfect sensors, on a machine each, shape (M,)."""
    run = Run(reference=program.make_reference(rig.arm), law=law)
    recordings = replace(rig, sensors=()).run([run] * len(machines), machines=machines, n_threads=1)
    passes = [find_passes(program, recording).found[0].recording for recording in recordings]
    return np.log([score_run([one], "tool").size for one in passes])


def find_factor(rig: Rig, program: TrialProgram, law: FeedForwardLaw, machine: Machine) -> float:
    """Find how much larger a law must be to leave as much error as without it, on the other side."""
    (without,) = measure_exactly(rig, program, NoCompensation(), [machine])

    def change(factor: float) -> float:
        scaled = Scaled(law, {program.name: factor})
        return float(measure_exactly(rig, program, scaled, [machine])[0] - without)

    return float(scipy.optimize.brentq(change, 1.0, 2.7, xtol=1e-3))


def find_truth(
    rig: Rig, program: TrialProgram, laws: Mapping[str, FeedForwardLaw], latest: float, rng: np.random.Generator
) -> dict[str, Callable[[Array], Array]]:
    """Find the true log ratio of errors with each law over time since the machine was switched on [s].

    Raises:
        FFGymError: if no error drifts, without or with a law.
    """
    assert rig.machine is not None
    times = np.linspace(0.0, latest, _TIMES)
    # the same draws of friction at all times, and each with its opposite
    changes = rng.integers(2**32, size=_DRAWS // 2)
    machines = [
        vary_friction(rig.machine.later(since), sign * VARIATION, np.random.default_rng(seed))
        for since in times
        for seed in changes
        for sign in (1.0, -1.0)
    ]
    means = {
        name: measure_exactly(rig, program, law, machines).reshape(_TIMES, -1).mean(axis=1)
        for name, law in {"none": NoCompensation(), **laws}.items()
    }
    if max(np.ptp(mean) for mean in means.values()) < DRIFT:
        raise FFGymError(f"No error of {rig.name} changes by {DRIFT:.0%} while it warms up: nothing would drift.")
    return {name: scipy.interpolate.CubicSpline(times, means[name] - means["none"]) for name in laws}


@dataclass(frozen=True, kw_only=True, eq=False)
class CoverageStudy:
    """Workcell with its programs, the corrections that are tried, and what they truly gain."""

    name: str
    rig: Rig
    programs: tuple[TrialProgram, ...]
    laws: Mapping[str, FeedForwardLaw]
    factors: Mapping[str, float]
    """Factor of the mirrored law for each program."""
    truths: Mapping[str, Mapping[str, Callable[[Array], Array]]]
    """True log ratio of errors over time, by program and law."""
    seed: int

    def repeat(self, law: str, pairs: int, repetition: int) -> list[dict[str, Any]]:
        """Carry out one trial of a law, and compare what it says with the truth."""
        rng = np.random.default_rng([self.seed, *self.name.encode(), *law.encode(), repetition])
        plan = _plan(self.rig, self.programs, pairs, int(rng.integers(2**31)))
        begin = LATEST / 2 if law == Scaled.name else float(rng.uniform(0.0, LATEST))
        seed = int(rng.integers(2**31))
        logs = list(rehearse(plan, self.rig, self.laws[law], seed=seed, begin=begin, n_threads=1))
        ratios, rows = self._average_truth(plan, law, begin), []
        for gain in read_trial(plan, logs).gains:
            truth = float(-np.expm1(ratios[gain.name]))
            numbers = {"truth": truth} | {part: getattr(gain, part) for part in _PARTS}
            rounded = {part: float(f"{value:.6g}") for part, value in numbers.items()}
            row = {"program": gain.name, "claim": gain.claim, "covered": gain.low <= truth <= gain.high}
            rows.append(row | rounded)
        return rows

    def _average_truth(self, plan: TrialPlan, law: str, begin: float) -> dict[str, float]:
        """Average the true log ratio over the slots of a plan, by program, and over all."""
        starts = np.array(compute_starts(plan, begin=begin))
        ratios = {}
        for program in self.programs:
            own = starts[[run.program == program.name for run in plan.runs]]
            ratios[program.name] = float(self.truths[program.name][law](own).mean())
        return ratios | {OVERALL: float(np.mean(list(ratios.values())))}


def prepare_study(
    name: str, *, pairs: int, seed: int, laws: Sequence[str] = LAWS, circles: Sequence[Circle] = CIRCLES
) -> CoverageStudy:
    """Prepare trials on a workcell: programs, corrections, and what they truly gain.

    Raises:
        FFGymError: if the machine does not warm up, so that nothing would drift.
    """
    rig = make_rig(name)
    if rig.machine is None or rig.machine.climate is None:
        raise FFGymError(f"{name} is no workcell that warms up, so that nothing would drift.")
    machine = rig.machine.at(0.0)
    rig = replace(rig, machine=machine)
    programs = tuple(
        make_program(rig.arm, cartesian_reference(rig.arm, circle_path(rig.robot, position, speed, [radius])))
        for position, speed, radius in circles
    )
    rng = np.random.default_rng([seed, *name.encode()])
    latest = LATEST + compute_starts(_plan(rig, programs, pairs, 0))[-1]
    elastic, factors = elastic_law(rig.arm, rig.arm), dict[str, float]()
    if Scaled.name in laws:
        middle = machine.later(latest / 2)
        factors = {program.name: find_factor(rig, program, elastic, middle) for program in programs}
    known = {"elastic": elastic, "nothing": NoCompensation(), Scaled.name: Scaled(elastic, factors)}
    tried = {law: known[check_choice("correction", law, LAWS)] for law in laws}
    return CoverageStudy(
        name=name,
        rig=rig,
        programs=programs,
        laws=tried,
        factors=factors,
        truths={program.name: find_truth(rig, program, tried, latest, rng) for program in programs},
        seed=seed,
    )


def _plan(rig: Rig, programs: Sequence[TrialProgram], pairs: int, seed: int) -> TrialPlan:
    return plan_trial(rig.robot.name, programs, pairs=pairs, seed=seed, warm_up=0)


def count_rows(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Count, by law and program, how often the interval holds the truth, and what was claimed."""
    found = []
    for law, program in dict.fromkeys((row["law"], row["program"]) for row in rows):
        own = [row for row in rows if (row["law"], row["program"]) == (law, program)]
        found.append(
            {
                "law": law,
                "program": program,
                "repetitions": len(own),
                "truth": float(np.mean([row["truth"] for row in own])),
                "width": float(np.mean([row["high"] - row["low"] for row in own])),
                "covered": sum(row["covered"] for row in own),
                "gain_claimed": sum(row["claim"] == "gain" for row in own),
                "worse_claimed": sum(row["claim"] == "worse" for row in own),
            }
        )
    return found


def count_trials(rows: Sequence[Mapping[str, Any]], law: str, claim: str) -> int:
    """Count the trials of a law on all machines of the rows that make a claim of any program or of all."""
    found = [row for row in rows if (row["law"], row["claim"]) == (law, claim)]
    return len({(row["machine"], row["repetition"]) for row in found})


def main(config: Config) -> None:
    """Repeat trials on all workcells, print counts; with a file, go on where it ends, and keep each repetition."""
    origin = {"versions": versions(), "pairs": config.pairs, "seed": config.seed}
    origin |= {"variation": VARIATION, "latest_s": LATEST}
    kept: dict[str, Any] = {"origin": origin, "rows": []}
    if config.json is not None and config.json.exists():
        kept = json.loads(read_text(config.json))
        if kept["origin"] != origin:
            raise FFGymError(f"{config.json} holds repetitions of other settings or versions; choose another name.")
    for name in config.machines:
        study = prepare_study(name, pairs=config.pairs, seed=config.seed, laws=config.laws)
        for law, repetition in product(config.laws, range(config.repetitions)):
            key = {"machine": name, "law": law, "repetition": repetition}
            if any(key.items() <= row.items() for row in kept["rows"]):
                continue
            kept["rows"] += [key | row for row in study.repeat(law, config.pairs, repetition)]
            if config.json is not None:
                write_json(config.json, kept)
        for one in count_rows([row for row in kept["rows"] if row["machine"] == name]):
            print(
                f"{name}, {one['law']}, {one['program']}: true gain {one['truth']:.2%}, interval {one['width']:.2%} "
                f"wide, covers it in {one['covered']} of {one['repetitions']}; claimed: gain in {one['gain_claimed']}, "
                f"worse in {one['worse_claimed']}"
            )


if __name__ == "__main__":
    import tyro

    main(tyro.cli(Config))
