"""Gain in control: path errors on the machine by feed-forward laws of the model before and after.

Circles are at positions and of sizes that no round recorded.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ffgym.agents.elastic import elastic_law
from ffgym.agents.lugre import dynamic_lugre
from ffgym.agents.model import model_law
from ffgym.control import FeedForwardLaw, NoCompensation
from ffgym.core.errors import FFGymError
from ffgym.improvement.rounds import ImprovementRound, Plan
from ffgym.paths import RADII, SPEEDS
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation import Rig
from ffgym.simulation.protocols.mixtures import CIRCLE
from ffgym.simulation.run import Progress
from ffgym.studies import CircleStudy, circle_study

BASELINE = "lugre_dynamic"
"""Baseline of the gain: dynamic LuGre with nominal parameters."""
IDENTIFIED = "lugre_identified"
"""Dynamic LuGre with friction that was identified from the first round's recordings."""
BENT = "elastic_identified"
"""Elastic feed-forward with that friction."""
FITTED = "fitted"
"""The nominal model with all numbers fitted to the first round's recordings, before any diagnosis."""
MODEL = "model"
"""Feed-forward from the last extended model; that of an earlier round has its number behind it."""


@dataclass(frozen=True, eq=False)
class Contender:
    """A law with its name and title in the comparison."""

    name: str
    title: str
    """Title for readers."""
    law: FeedForwardLaw


def contenders(
    rig: Rig, plan: Plan, rounds: Sequence[ImprovementRound], identified: RobotDescription
) -> list[Contender]:
    """Make all laws, in the order of tables.

    Args:
        rig: rig that will run them; its controller stays.
        plan: plan with the nominal model.
        rounds: rounds with the extended models.
        identified: the nominal robot with friction identified from the same recordings.
    """
    nominal, arm = plan.nominal.physical, rig.arm
    found = [
        Contender("none", "no compensation", NoCompensation()),
        Contender(BASELINE, "dynamic LuGre, nominal", dynamic_lugre(nominal)),
        Contender(IDENTIFIED, "dynamic LuGre, identified friction", dynamic_lugre(identified)),
        Contender("elastic", "elastic, nominal", elastic_law(RigidArm(nominal), arm)),
        Contender(BENT, "elastic, identified friction", elastic_law(RigidArm(identified), arm, BENT)),
    ]
    if plan.fit:
        found.append(Contender(FITTED, "all numbers fitted", model_law(rounds[0].before, arm, FITTED)))
    grown = [each for each in rounds if each.diagnosis.causes] or rounds[-1:]
    for each in grown:
        name = MODEL if each is grown[-1] else f"{MODEL}_{each.number}"
        law = model_law(each.machine, arm, name)
        found.append(Contender(name, f"extended model of round {each.number}", law))
    return found


HELD_OUT_RADII = tuple(radius for radius in RADII if radius != CIRCLE)
"""Radii of the thesis [m] without that of the circles that the diagnosis protocol records."""


def held_out_positions(robot: RobotDescription) -> tuple[str, ...]:
    """List positions of the work area where no protocol draws circles: all but the first.

    Raises:
        FFGymError: if the robot has no such position.
    """
    names = () if robot.work_area is None else tuple(robot.work_area.positions)[1:]
    if not names:
        raise FFGymError(
            f"Robot {robot.name!r} has no work area with two positions or more, so that there are no circles on which "
            f"feed-forward could be compared."
        )
    return names


@dataclass(frozen=True, kw_only=True)
class LawScore:
    """Path error of one law at one speed, mean over all circles."""

    law: str
    title: str
    speed_mm_s: float
    rms_um: float
    """Mean of the RMS path errors."""
    max_um: float
    """Mean of the largest path errors."""
    against: float
    """Reduction as a share of the RMS path error of dynamic LuGre with nominal parameters; negative for growth."""
    better_on: int
    """Circles on which the error is smaller than with that law."""
    circles: int


@dataclass(frozen=True, kw_only=True, eq=False)
class ControlGain:
    """Scores of all laws at all speeds."""

    study: CircleStudy
    """Study of every circle."""
    scores: tuple[LawScore, ...]
    """Scores law by law, speed by speed."""


def measure_gain(
    rig: Rig,
    laws: Sequence[Contender],
    *,
    positions: Sequence[str],
    speeds: Sequence[float] = SPEEDS,
    radii: Sequence[float] = HELD_OUT_RADII,
    seed: int = 0,
    n_threads: int = 0,
    progress: Progress | None = None,
) -> ControlGain:
    """Run all laws on circles and score them.

    Args:
        rig: the machine.
        laws: laws to compare, BASELINE among them.
        positions: names in the work area.
        speeds: speeds of the tool [m/s].
        radii: radii of the circles [m].
        seed: seed of the sensors' noise, the same for all laws.
        n_threads: threads of the simulation, 0 for all cores.
        progress: function that is called now and then with the simulated seconds done and their total.

    Raises:
        FFGymError: if there is nothing to run, or the robot cannot follow the circles.
    """
    studies = []
    for i, each in enumerate(laws):
        study = circle_study(
            rig,
            laws=[each.law],
            positions=positions,
            speeds=speeds,
            radii=radii,
            seed=seed,
            n_threads=n_threads,
            progress=None if progress is None else partial(_report_part, progress, i, len(laws)),
        )
        studies.append(study.rename(each.law.name, each.name))
    study = studies[0]
    for other in studies[1:]:
        study = study.join(other)
    tested = dict.fromkeys(cell.speed_mm_s for cell in study.cells)
    return ControlGain(study=study, scores=tuple(_score(study, each, speed) for each in laws for speed in tested))


def _report_part(progress: Progress, i: int, n: int, done: float, total: float) -> None:
    """Report progress of the i-th of n equal parts."""
    progress(i * total + done, n * total)


def _score(study: CircleStudy, law: Contender, speed_mm_s: float) -> LawScore:
    own, base = (study.select(agent=name, speed_mm_s=speed_mm_s) for name in (law.name, BASELINE))
    mine, theirs = (np.array([cell.rms_mm for cell in cells]) * 1e3 for cells in (own, base))
    return LawScore(
        law=law.name,
        title=law.title,
        speed_mm_s=speed_mm_s,
        rms_um=float(mine.mean()),
        max_um=float(np.mean([cell.max_mm for cell in own])) * 1e3,
        against=float(1 - mine.mean() / theirs.mean()),
        better_on=int(np.sum(mine < theirs)),
        circles=len(own),
    )
