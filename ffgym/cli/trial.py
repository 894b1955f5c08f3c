"""`ffgym trial`: a randomised on/off experiment on a machine: plan it, rehearse it, read it."""

from pathlib import Path
from typing import Any

from ffgym.cli.laws import check_laws, make_laws, setting_for
from ffgym.cli.outputs import (
    claim_new_folder,
    claim_outputs,
    hash_inputs,
    need_extra,
    print_places,
    provenance,
    write_numbers,
)
from ffgym.cli.progress import progress_bar
from ffgym.cli.trial_options import PlanTrial, ReadTrial, RehearseTrial
from ffgym.control import SetpointChannel
from ffgym.core.errors import FFGymError, check_number, check_whole, errors_at
from ffgym.core.files import new_folder, read_text, write_text
from ffgym.core.typed_json import parse_json, to_json
from ffgym.deployment.trial.matching import TrialLog
from ffgym.deployment.trial.pages import render_plan, render_trial
from ffgym.deployment.trial.plan import TrialPlan, plan_trial
from ffgym.deployment.trial.plan_files import PAGE, PLAN, TABLE, describe_plan, read_trial_plan, write_trial_plan
from ffgym.deployment.trial.power import LEAST_SPREAD, SPREAD, Power, pool_pilot
from ffgym.deployment.trial.program import TrialProgram, make_program
from ffgym.deployment.trial.reading import TrialResult, read_trial
from ffgym.deployment.trial.rehearsal import rehearse
from ffgym.deployment.trial.words import format_plan, format_trial
from ffgym.envs.machines import find_controller, make_rig
from ffgym.logs import log_formats, read_logs
from ffgym.paths.motions import load_motion
from ffgym.paths.motions.load import is_program
from ffgym.recordings import write_recording
from ffgym.recordings.io import recording_files
from ffgym.robot import load_draft, load_robot

LOGS = "logs"
"""Folder of a rehearsal's logs in that of its plan."""


def plan(config: PlanTrial) -> None:
    """Plan, write, print."""
    need_extra("ffgym trial plan", "matplotlib", "jinja2")
    if config.out is None:
        raise FFGymError("Say where the plan goes: --out FOLDER.")
    if not config.motions:
        raise FFGymError("Name what the machine is to run, a program for each speed and place, e.g. circles.")
    claim_new_folder(config.out)
    claim_outputs({"--json": config.json}, inputs=(config.robot, config.pilot, *config.motions))
    runs = check_whole("--runs", config.runs, low=2)
    if runs % 2:
        raise FFGymError(f"--runs {runs} must be even: each run with the correction has one without.")
    made = plan_trial(
        find_controller(config.robot),
        _programs(config),
        pairs=runs // 2,
        seed=config.seed,
        warm_up=config.warm_up,
        laps=config.laps,
    )
    power = _power(config, len(made.programs))
    info = provenance("ffgym trial plan", config, made.robot, None, config.seed)
    info |= {"inputs": hash_inputs((config.robot, *config.motions))}
    needs = {"spread": power.spread, "spread_from": power.source, "gain": power.gain, "power": power.power}
    needs |= {"pairs_needed": power.needed}
    write_trial_plan(made, config.out, render_plan(made, power, info), info | {"assumed": needs})
    write_numbers(config, info | describe_plan(made) | {"assumed": needs})
    print(format_plan(made, power))
    print_places(plan=config.out / PLAN, table=config.out / TABLE, print=config.out / PAGE, numbers=config.json)


def _programs(config: PlanTrial) -> list[TrialProgram]:
    """Make the programs of all motions."""
    arm = make_rig(config.robot).arm
    programs = []
    if config.entry is not None and not any(map(is_program, config.motions)):
        raise FFGymError(
            f"--entry {config.entry} has no effect: {', '.join(config.motions)} is no RAPID program. Leave it out."
        )
    for source in config.motions:
        motion = load_motion(arm, source, entry=config.entry if is_program(source) else None)
        if motion.reference.robot is not arm.robot:
            raise FFGymError(f"{source} brings a tool of its own; plan with a robot that has this tool.")
        for note in motion.notes:
            print(f"note: {motion.reference.name}: {note}")
        programs.append(make_program(arm, motion.reference))
    return programs


def _power(config: PlanTrial, places: int) -> Power:
    """Collect what the number of pairs is reckoned from."""
    if config.spread_percent is not None and config.pilot is not None:
        raise FFGymError("--spread-percent and --pilot both say the spread; leave one of them out.")
    spread, source = SPREAD, "assumed"
    if config.spread_percent is not None:
        spread, source = config.spread_percent / 100, "as stated"
    elif config.pilot is not None:
        spread, source = _read_pilot(config.pilot), f"upper end of what {config.pilot} leaves open"
    gain = check_number("--gain-percent", config.gain_percent, unit="%", low=0.0, high=99.0, open_low=True) / 100
    power = check_number("--power-percent", config.power_percent, unit="%", low=5.0, high=99.9) / 100
    spread = check_number("spread of the ratios of pairs", spread, low=LEAST_SPREAD, high=3.0)
    return Power(gain=gain, spread=spread, source=source, power=power, places=places)


def _read_pilot(path: Path) -> float:
    """Read the spread of an earlier trial from its numbers."""
    with errors_at(str(path)):
        try:
            gains = parse_json(read_text(path), "The file")["gains"]
            known = [(float(g["spread"]), int(g["pairs"]) - 1) for g in gains if g["spread"] and not g["is_overall"]]
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            raise FFGymError(
                f"The file has no gains of a trial ({error!r}); ffgym trial read --json writes it."
            ) from error
        return pool_pilot([spread for spread, _ in known], [freedom for _, freedom in known])


def rehearse_plan(config: RehearseTrial) -> None:
    """Simulate, write, print."""
    out = config.trial / LOGS if config.out is None else config.out
    made = read_trial_plan(config.trial)
    check_laws([config.feedforward], "--feedforward")
    claim_new_folder(out)
    claim_outputs({"--json": config.json}, inputs=(config.trial / PLAN, config.machine, config.parameters))
    rig = make_rig(config.machine)
    if rig.robot.joints != load_robot(made.robot).joints:
        raise FFGymError(f"{config.machine} has other joints than {made.robot}, for which the trial was planned.")
    references = [program.make_reference(rig.arm) for program in made.programs]
    (law,) = make_laws([config.feedforward], setting_for(rig, references, config.parameters, config.threads))
    info = provenance("ffgym trial rehearse", config, rig.robot.name, rig.fingerprint, config.seed)
    with new_folder(out) as folder, progress_bar("rehearsing", "s") as progress:
        logs = rehearse(
            made,
            rig,
            law,
            channel=SetpointChannel() if config.channel == "setpoint" else None,
            seed=config.seed,
            begin=60.0 * check_number("--later-min", config.later_min, unit="min", low=0.0),
            variation=config.variation_percent / 100,
            pause=config.pause_s,
            n_threads=config.threads,
            progress=progress,
        )
        names = []
        for log in logs:
            write_recording(log.recording, folder / f"{log.name}.npz")
            names.append(log.name)
    write_numbers(config, info | {"plan": made.digest, "folder": str(out), "logs": names})
    print(f"{len(names)} runs of {config.machine}, correction {law.name}")
    print_places(logs=out, numbers=config.json)


def read(config: ReadTrial) -> None:
    """Read, write, print."""
    made = read_trial_plan(config.trial)
    inputs = (*config.logs, config.columns, config.trial / PLAN)
    claim_outputs({"--report": config.report, "--json": config.json}, inputs=inputs)
    robot = load_robot(made.robot) if not _lacks_entries(made) else None
    result = read_trial(made, _read_logs(config, made), robot=robot, without=config.without, accept=config.accept)
    info = provenance("ffgym trial read", config, made.robot, None, made.seed)
    info |= {"plan": made.digest, "inputs": hash_inputs(inputs)}
    if config.report is not None:
        write_text(config.report, render_trial(result, info))
    write_numbers(config, info | describe_result(result))
    print(format_trial(result))
    print_places(report=config.report, numbers=config.json)


def _lacks_entries(made: TrialPlan) -> bool:
    return made.robot.endswith(".toml") and bool(load_draft(made.robot).missing)


def _read_logs(config: ReadTrial, made: TrialPlan) -> list[TrialLog]:
    """Read all logs, files that cannot be read too: they are named, and their runs are left out."""
    if not config.logs:
        raise FFGymError("There are no logs to read: name files, or a folder of recordings.")
    files = [file for path in config.logs for file in _list_logs(path, is_mapped=config.columns is not None)]
    logs = []
    with progress_bar("reading", "logs") as progress:
        for done, file in enumerate(files):
            progress(done, len(files))
            try:
                found = read_logs(file, config.columns, robot=made.robot if config.columns else None)
            except FFGymError as error:
                print(f"note: not read: {error}")
                continue
            names = [file.stem] if len(found) == 1 else [recording.header.segment for recording in found]
            logs += [TrialLog(name, recording) for name, recording in zip(names, found, strict=True)]
    if not logs:
        raise FFGymError("None of the logs can be read, see the notes above.")
    return logs


def _list_logs(path: Path, *, is_mapped: bool) -> list[Path]:
    """List the logs in a folder; a file, or with a column map a folder that is one log, stands for itself."""
    if not path.is_dir():
        return [path]
    if not is_mapped:
        return recording_files(path)
    return [path] if any(kind.recognises(path) for kind in log_formats()) else sorted(path.iterdir())


def describe_result(result: TrialResult) -> dict[str, Any]:
    """Describe a result as JSON has it."""
    gains = [
        to_json(gain) | {"claim": gain.claim, "is_overall": gain not in result.gains[: len(result.plan.programs)]}
        for gain in result.gains
    ]
    runs = [to_json(one) | {"counts": one.counts} for one in result.runs]
    measure = {"measure": result.measure, "unit": result.unit.name, "meaning": result.unit.words}
    return measure | {"gains": gains, "runs": runs, "notes": list(result.notes)}
