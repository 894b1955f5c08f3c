"""`ffgym export program`: a plan of set-points as a corrected program for a controller."""

from ffgym.cli.code_options import ExportProgram
from ffgym.cli.export import load_machine_or_robot
from ffgym.cli.outputs import claim_new_folder, claim_outputs, given_options, print_places, provenance, write_numbers
from ffgym.cli.progress import stages_bar
from ffgym.cli.stream import name_robot
from ffgym.core.errors import FFGymError
from ffgym.deployment import ServoProgram, read_plan
from ffgym.deployment.programs import write_program
from ffgym.deployment.programs.report import describe_changes, format_changes
from ffgym.robot import RigidArm


def run(config: ExportProgram) -> None:
    """Check, write, compare, print."""
    claim_new_folder(config.out)
    claim_outputs({"--json": config.json}, inputs=(config.plan, config.robot))
    _refuse_unused(config)
    plan = read_plan(config.plan)
    known, _ = load_machine_or_robot(name_robot(plan, config.robot))
    info = provenance("ffgym export program", config, known.name, None, seed=None)
    with stages_bar("choosing points") as tell:
        written = write_program(
            plan,
            RigidArm(known),
            config.out,
            config.format,
            tolerance=config.tolerance_mm / 1e3,
            period=None if config.period_ms is None else config.period_ms / 1e3,
            servo=ServoProgram(lookahead_time=config.lookahead_time, gain=config.gain),
            report=info,
            tell=tell,
        )
    write_numbers(config, info | describe_changes(written, plan))
    print(format_changes(written, plan))
    print_places(folder=config.out, numbers=config.json)


def _refuse_unused(config: ExportProgram) -> None:
    """Refuse options that the format has no use for."""
    unused = {"rapid": ("lookahead_time", "gain"), "krl": ("lookahead_time", "gain")}
    names = unused.get(config.format, ("period_ms",) if config.format == "urscript" else ("period_ms", "gain"))
    if given := given_options(config, names):
        raise FFGymError(f"{given[0]} has no effect with --format {config.format}. Leave it out.")
