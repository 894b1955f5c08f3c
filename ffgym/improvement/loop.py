"""Improvement of a model: rounds on a machine, then the gain of its laws on circles that no round recorded."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from ffgym.core.files import filled_folder
from ffgym.diagnosis.diagnosis_file import diagnosis_document
from ffgym.diagnosis.identification import friction_torques, identify_friction
from ffgym.improvement.gain import HELD_OUT_RADII, ControlGain, contenders, held_out_positions, measure_gain
from ffgym.improvement.rounds import Diagnose, ImprovementRound, Plan, Stage, improve_in_rounds
from ffgym.paths import SPEEDS
from ffgym.recordings.io import read_folder
from ffgym.robot import RigidArm
from ffgym.simulation import Rig
from ffgym.studies import circle_references


@dataclass(frozen=True, kw_only=True, eq=False)
class Improvement:
    """Rounds on a machine, and their gain in control."""

    rig: Rig
    plan: Plan
    rounds: tuple[ImprovementRound, ...]
    gain: ControlGain

    @property
    def ended(self) -> str:
        """Reason why the rounds ended."""
        last = self.rounds[-1].diagnosis
        if last.causes:
            return f"the {self.plan.rounds} rounds are used up"
        if last.verdict == "none":
            return "the last recordings do not falsify the model"
        return f"the last diagnosis names nothing to add ({last.verdict})"

    def document(self) -> dict[str, Any]:
        """Convert to JSON."""
        return {
            "rig": self.rig.name,
            "ended": self.ended,
            "rounds": [
                {
                    "round": each.number,
                    "protocols": list(each.protocols),
                    "seconds": each.seconds,
                    "logs": str(each.logs),
                    "model": str(each.model),
                    "diagnosis": diagnosis_document(each.diagnosis),
                }
                for each in self.rounds
            ],
            "scores": [asdict(score) for score in self.gain.scores],
            "circles": [asdict(cell) for cell in self.gain.study.cells],
        }


def improve(
    rig: Rig,
    plan: Plan,
    folder: Path,
    *,
    diagnose: Diagnose,
    stage: Stage,
    positions: Sequence[str] | None = None,
    speeds: Sequence[float] = SPEEDS,
    radii: Sequence[float] = HELD_OUT_RADII,
) -> Improvement:
    """Record, diagnose, extend, in rounds; then compare feed-forward from the model before and after on the machine.

    Args:
        rig: the machine.
        plan: plan of the rounds.
        folder: folder for recordings, diagnoses and models; complete ones in it are not made again.
        diagnose: diagnosis of a model by recordings.
        stage: context that shows progress.
        positions: positions of the circles of the comparison; None is all where no protocol draws circles.
        speeds: speeds of these circles [m/s].
        radii: radii of these circles [m].

    Raises:
        FFGymError: if something cannot be recorded, diagnosed, run or written, or another process fills the folder.
    """
    places = held_out_positions(rig.robot) if positions is None else positions
    circle_references(rig.arm, places, speeds, radii)  # circles that cannot be run are refused before anything moves
    with filled_folder(folder):
        rounds = improve_in_rounds(rig, plan, folder, diagnose, stage)
    # the nominal robot with friction identified from the recordings of the first round
    nominal = plan.nominal.physical
    with stage("identifying friction", "joints") as progress:
        torques = friction_torques(RigidArm(nominal), read_folder(rounds[0].logs))
        found = identify_friction(torques, seed=plan.seed, progress=progress)
    # laws of the model before and after, on circles that no round recorded
    laws = contenders(rig, plan, rounds, replace(nominal, friction=found.friction))
    with stage("comparing laws", "s") as progress:
        gain = measure_gain(
            rig,
            laws,
            positions=places,
            speeds=speeds,
            radii=radii,
            seed=plan.seed,
            n_threads=plan.n_threads,
            progress=progress,
        )
    return Improvement(rig=rig, plan=plan, rounds=tuple(rounds), gain=gain)
