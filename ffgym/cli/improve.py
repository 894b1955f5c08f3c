"""`ffgym improve`: what a diagnosis is worth in control: record, diagnose, extend, in rounds; then compare laws."""

from pathlib import Path

from ffgym.cli.log_options import Improve
from ffgym.cli.outputs import claim_outputs, given_folder, need_extra, print_places, provenance
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import check_whole
from ffgym.core.files import filled_folder, write_json, write_text
from ffgym.diagnosis import diagnose
from ffgym.diagnosis.settings import settings
from ffgym.effects import Origin
from ffgym.envs.machines import find_controller, make_rig
from ffgym.improvement import Plan, format_improvement, improve, improvement_figures, render_improvement
from ffgym.report import save_figure
from ffgym.robot import load_robot
from ffgym.simulation.plant import Machine, load_machine
from ffgym.simulation.plant.machine_file import is_machine_file, origins_of, robot_reference
from ffgym.simulation.protocols import load_protocols

PAGE, NUMBERS = "improvement.html", "improvement.json"
"""Files beside the rounds, with the page's pictures."""

DPI = 100
"""Pixels per inch of the pictures."""


def run(config: Improve) -> None:
    """Check, run, write, print."""
    # refuse wrong options first, as the robot then moves for long
    need_extra("ffgym improve", "matplotlib", "jinja2")
    folder = given_folder(config.out, "recordings, diagnoses and models go")
    check_whole("--most-causes", config.most_causes, low=1, high=settings().search.most_causes)
    for name in config.protocols:
        load_protocols(name)
    claim_outputs({"--json": config.json}, inputs=(config.rig, config.robot, *config.protocols))
    with filled_folder(folder):
        _improve(config, folder)


def _improve(config: Improve, folder: Path) -> None:
    """Run, write, print."""
    # rounds of recording, diagnosis and an extended model
    rig = make_rig(config.rig)
    result = improve(
        rig,
        _plan(config),
        folder,
        diagnose=lambda machine, recordings, prior, most: diagnose(
            machine, recordings, prior=prior, seed=config.seed, most=most
        ),
        stage=progress_bar,
        positions=config.positions or None,
        speeds=[speed / 1e3 for speed in config.speeds_mm_s],
        radii=[radius / 1e3 for radius in config.radii_mm],
    )
    info = provenance("ffgym improve", config, rig.robot.name, rig.fingerprint, config.seed)
    numbers = config.json or folder / NUMBERS
    write_text(folder / PAGE, render_improvement(result, info))
    write_json(numbers, info | result.document())
    for each in improvement_figures(result):
        save_figure(each.figure, folder / f"{each.name}.png", DPI)
    print(format_improvement(result))
    print_places(report=folder / PAGE, model=result.rounds[-1].model, numbers=numbers)


def _plan(config: Improve) -> Plan:
    """Plan the rounds; without a model to begin with, from the robot that the machine's controller knows."""
    known = config.robot or find_controller(config.rig)
    reference = robot_reference(known) if is_machine_file(known) else known
    nominal, origins = Machine(robot=load_robot(reference)), tuple[Origin, ...]()
    if config.robot is not None and is_machine_file(config.robot):
        nominal, origins = load_machine(config.robot), origins_of(config.robot)
    return Plan(
        nominal=nominal,
        robot=reference,
        origins=origins,
        fit=config.fit,
        protocols=config.protocols,
        rounds=config.rounds,
        most_causes=config.most_causes,
        seed=config.seed,
        n_threads=config.threads,
    )
