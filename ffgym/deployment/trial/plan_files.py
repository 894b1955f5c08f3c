"""Files of a plan: plan.json, plan.csv, the programs, and a page to print."""

import csv
import io
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ffgym.core.errors import FFGymError, errors_at
from ffgym.core.files import new_folder, read_text, write_json, write_text
from ffgym.core.typed_json import parse_json
from ffgym.deployment.trial.plan import TrialPlan, plan_trial
from ffgym.deployment.trial.program import TrialProgram
from ffgym.recordings import read_recording, write_recording

PLAN, TABLE, PAGE, PROGRAMS = "plan.json", "plan.csv", "plan.html", "programs"
"""Files and folder of a plan."""
_FORMAT = "ffgym.trial 1"
"""Kind and version of plan.json."""


def write_trial_plan(plan: TrialPlan, folder: str | os.PathLike[str], page: str, info: Mapping[str, Any]) -> None:
    """Write the folder of a plan, whole or not at all; nothing is written over, as a plan is a commitment.

    Args:
        plan: the plan.
        folder: is made.
        page: the page to print, HTML.
        info: where the plan comes from, and what it assumes; JSON.

    Raises:
        FFGymError: if something is there already, or it cannot be written.
    """
    with new_folder(folder) as place:
        write_json(place / PLAN, describe_plan(plan) | {"origin": dict(info)})
        write_text(place / TABLE, format_plan_table(plan))
        write_text(place / PAGE, page)
        (place / PROGRAMS).mkdir()
        for program, name in zip(plan.programs, _program_files(plan), strict=True):
            write_recording(program.recording, place / PROGRAMS / name)


def describe_plan(plan: TrialPlan) -> dict[str, Any]:
    """Describe a plan as JSON has it."""
    programs = [
        {
            "name": program.name,
            "file": name,
            "duration_s": program.duration,
            "speed_mm_s": None if program.speed is None else 1e3 * program.speed,
            "place_m": None if program.place is None else program.place.tolist(),
        }
        for program, name in zip(plan.programs, _program_files(plan), strict=True)
    ]
    return {
        "format": _FORMAT,
        "digest": plan.digest,
        "robot": plan.robot,
        "pairs": plan.pairs,
        "warm_up": plan.warm_up,
        "laps": plan.laps,
        "seed": plan.seed,
        "programs": programs,
        "runs": [vars(run) for run in plan.runs],
    }


def format_plan_table(plan: TrialPlan) -> str:
    """Format the runs as CSV, one a line."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["run", "log", "program", "correction", "pair"])
    for run in plan.runs:
        pair = "warm-up" if run.is_warm_up else run.pair
        writer.writerow([run.number, run.log, run.program, "on" if run.corrected else "off", pair])
    return text.getvalue()


def read_trial_plan(folder: str | os.PathLike[str]) -> TrialPlan:
    """Read the plan in a folder; the order is drawn from its seed again, and must be the one that is written there.

    Raises:
        FFGymError: if the folder holds no plan, or one that was changed.
    """
    path = Path(folder) / PLAN
    if not path.exists():
        raise FFGymError(f"{folder}: holds no {PLAN}. Name the folder that `ffgym trial plan --out` made.")
    with errors_at(str(path)):
        try:
            values = parse_json(read_text(path), "The file")
            if values["format"] != _FORMAT:
                raise KeyError("format")
            files = [Path(folder) / PROGRAMS / str(entry["file"]) for entry in values["programs"]]
            numbers = {name: values[name] for name in ("pairs", "seed", "warm_up", "laps")}
            robot, runs, digest = str(values["robot"]), values["runs"], values["digest"]
        except (KeyError, TypeError) as error:
            raise FFGymError(f"The file is no plan of this version ({_FORMAT}): {error!r}. Plan again.") from error
        programs = [TrialProgram(recording=read_recording(file)) for file in files]
        plan = plan_trial(robot, programs, **numbers)
        if [vars(run) for run in plan.runs] != runs or plan.digest != digest:
            raise FFGymError(
                "The plan was changed after it was drawn: its runs or programs are not those of its seed and digest. "
                "Take the folder as it was written; runs that were not made are told by their missing logs."
            )
        return plan


def _program_files(plan: TrialPlan) -> list[str]:
    return [f"{k:02d}.npz" for k in range(1, len(plan.programs) + 1)]
