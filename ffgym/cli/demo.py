"""`ffgym demo`: the circle test of the thesis with any feed-forward agents, and a diagnosis; as tables and as pages."""

from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from ffgym.agents.catalogue import CATALOGUE
from ffgym.cli.diagnose import next_step, origin_of, period_of
from ffgym.cli.laws import check_laws, make_laws, record_agents, refuse_with_policies, setting_for
from ffgym.cli.log_options import Diagnose
from ffgym.cli.motion_options import Demo
from ffgym.cli.outputs import (
    claim_outputs,
    given_options,
    hash_inputs,
    need_extra,
    print_places,
    provenance,
    write_numbers,
)
from ffgym.cli.progress import stages_bar
from ffgym.core.files import check_writable, write_text
from ffgym.diagnosis import Diagnosis, examine
from ffgym.diagnosis.diagnosis_file import diagnosis_document
from ffgym.diagnosis.nominal import EXAMPLE_ROBOT, example_logs
from ffgym.envs.machines import find_controller, is_workcell, make_rig
from ffgym.report import format_one_axis, format_text, write_report
from ffgym.report.diagnosis import DiagnosisReport, format_findings, render_diagnosis_page
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation import Machine, Rig, SimulatedRig
from ffgym.studies import CircleStudy, OneAxisStudy, circle_references, one_axis_study, sine_references
from ffgym.studies.circles import score_circle_study

SEED = 0
"""Seed of the noise of a workcell's sensors, and of what a diagnosis draws."""


def run(config: Demo) -> None:
    """Simulate, write, print; then diagnose."""
    need_extra("The demo", "matplotlib", "jinja2", "rich")
    check_writable(config.report)  # it has a name then, beside which the second page is
    second = config.report.with_name(f"{config.report.stem}_diagnosis.html")
    places = {"--report": config.report, "--json": config.json}
    claim_outputs(places | ({"--report, of the diagnosis": second} if config.diagnosis else {}))
    check_laws(config.agents, "--agents", policies=True)
    refuse_with_policies(config.agents, given_options(config, ("parameters",)))
    circles, one_axis = _circles(config, make_rig(config.robot)), _one_axis(config)
    info = origin(config, circles)
    again = [info["command_line"], *["ffgym diagnose --out found"] * config.diagnosis]
    page = write_report(config.report, circles, one_axis, info, again)  # files first: printed text may go unread
    rows = [asdict(cell) for cell in circles.cells]
    numbers = info | {"rows": rows, "one_axis": [asdict(result) for result in one_axis.results]}
    write_numbers(config, numbers)
    print(format_text(circles))
    print(format_one_axis(one_axis))
    print(f"report: {page}", flush=True)
    if config.diagnosis:
        write_numbers(config, numbers | {"diagnosis": diagnosis_document(_diagnose(second))})
    print_places(numbers=config.json)


def _diagnose(file: Path) -> Diagnosis:
    """Diagnose the example logs: write a page, and print what their nominal model lacks."""
    logs, options, nominal = example_logs(), Diagnose(seed=SEED), Machine(robot=load_robot(EXAMPLE_ROBOT))
    with stages_bar("diagnosing the example logs") as tell:
        examined = examine(nominal, logs, seed=SEED, report=tell)
    diagnosis = replace(examined.diagnosis, provenance=origin_of(options, nominal))
    page = DiagnosisReport(
        diagnosis=diagnosis,
        before=examined.before,
        after=examined.after if diagnosis.causes else None,
        commands=next_step(options, diagnosis, period_of(logs)).commands,
    )
    write_text(file, render_diagnosis_page(page))
    print(f"\nDiagnosis of the example logs, recordings of a machine like {EXAMPLE_ROBOT}:")
    print(format_findings(diagnosis))
    print(f"diagnosis: {file}")
    return diagnosis


def _circles(config: Demo, rig: Rig) -> CircleStudy:
    positions, speeds = config.positions or None, [speed / 1e3 for speed in config.speeds_mm_s]
    references = circle_references(rig.arm, positions, speeds)
    setting = setting_for(rig, [*references.values()], config.parameters, config.threads)
    controller = find_controller(config.robot)
    recordings = record_agents(
        config.agents, rig, references, setting, controller=controller, seed=SEED, n_threads=config.threads
    )
    return score_circle_study(rig, recordings)


def _one_axis(config: Demo) -> OneAxisStudy:
    """The sine test with those agents that work on one axis; files and parameters are of another robot."""
    robot = load_robot("one_axis")
    names = [name for name in config.agents if name in CATALOGUE and not CATALOGUE[name].needs_arm]
    rig = SimulatedRig(arm=RigidArm(robot))
    setting = setting_for(rig, [*sine_references(robot).values()], None, config.threads)
    return one_axis_study(robot, laws=make_laws(names or ["none"], setting))


def origin(config: Demo, study: CircleStudy) -> dict[str, Any]:
    """Origin of the numbers of a study; the seed is null where nothing is random, as no sensor measures."""
    seed = SEED if is_workcell(config.robot) else None
    info = provenance("ffgym demo", config, study.robot.name, study.fingerprint, seed)
    info["config"]["positions"] = list(dict.fromkeys(cell.position for cell in study.cells))
    info["inputs"] = hash_inputs((config.robot, config.parameters, *(a.removeprefix("model:") for a in config.agents)))
    return info
