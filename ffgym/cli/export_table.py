"""`ffgym export table`: torque and correction along one motion as tables."""

from typing import Any

from ffgym.cli.code_options import ExportTable
from ffgym.cli.export import load_machine_or_robot, prepare_motion
from ffgym.cli.laws import check_laws
from ffgym.cli.outputs import claim_new_folder, claim_outputs, given_options, print_places, provenance, write_numbers
from ffgym.core.errors import FFGymError
from ffgym.deployment import LawTable, read_plan, write_table
from ffgym.robot import ModelOptions, RigidArm, physics_fingerprint
from ffgym.simulation.export.model import in_engine


def run(config: ExportTable) -> None:
    """Check, compute, write, compare, print."""
    claim_new_folder(config.out)
    inputs = (config.robot, config.path, config.plan, config.parameters, config.feedforward)
    claim_outputs({"--json": config.json}, inputs=inputs)
    table, robot, fingerprint, info = _of_plan(config) if config.plan is not None else _of_law(config)
    write_table(table, config.out)
    write_numbers(config, provenance("ffgym export table", config, robot, fingerprint, seed=None) | info)
    count = len(next(iter(table.values.values())))
    print(f"{info['feedforward_law']} for {info['motion']}: {count} samples of {', '.join(table.values)}")
    print_places(folder=config.out, numbers=config.json)


def _of_plan(config: ExportTable) -> tuple[LawTable, str, str | None, dict[str, Any]]:
    """Tabulate a plan; returns table, robot, fingerprint of the physics (none), and what is told."""
    if given := given_options(config, ("robot", "path", "feedforward", "entry", "parameters")):
        raise FFGymError(f"{given[0].removeprefix('--')} has no effect with --plan, which has its own. Leave it out.")
    assert config.plan is not None
    plan = read_plan(config.plan)
    return LawTable.of_plan(plan), plan.robot, None, {"motion": plan.name, "feedforward_law": plan.law}


def _of_law(config: ExportTable) -> tuple[LawTable, str, str | None, dict[str, Any]]:
    """Tabulate a law along a motion; returns as `_of_plan`."""
    if config.robot is None or config.path is None:
        raise FFGymError("A table needs a robot and a motion, e.g. irb4600_60_205 circles, or --plan and a file.")
    check_laws([config.feedforward], "--feedforward")
    known, machine = load_machine_or_robot(config.robot)
    options = ModelOptions(looks=False)
    ready = prepare_motion(config, config.robot, config.path, RigidArm(known), machine, options)
    fingerprint = physics_fingerprint(in_engine(ready.machine).spec(options).compile())
    info = {"motion": ready.motion.reference.name, "feedforward_law": ready.law.name}
    return LawTable.along(ready.law, ready.motion.reference), known.name, fingerprint, info
