"""`ffgym export fmu`: a robot and a program as FMUs."""

from dataclasses import asdict

from ffgym.cli.code_options import ExportFmu
from ffgym.cli.export import load_machine_or_robot, prepare_motion
from ffgym.cli.laws import check_laws
from ffgym.cli.outputs import claim_new_folder, claim_outputs, need_extra, print_places, provenance, write_numbers
from ffgym.core.errors import FFGymError
from ffgym.deployment import write_fmus
from ffgym.deployment.code.compiler import need_compiler
from ffgym.robot import ModelOptions, RigidArm, physics_fingerprint
from ffgym.simulation.export.model import in_engine, missing_text


def run(config: ExportFmu) -> None:
    """Check, simulate, compile, validate, compare, write, print."""
    claim_new_folder(config.out)
    claim_outputs({"--json": config.json}, inputs=(config.robot, config.path, config.parameters, config.feedforward))
    if not config.fmi:
        raise FFGymError("Name a version of the standard or both: --fmi 2.0 3.0.")
    check_laws([config.feedforward], "--feedforward")
    need_extra("An FMU", "fmpy", extra="fmu")
    need_compiler("An FMU", optional=False)
    known, machine = load_machine_or_robot(config.robot)
    options = ModelOptions(looks=False)
    ready = prepare_motion(config, config.robot, config.path, RigidArm(known), machine, options)
    checks = write_fmus(
        config.out,
        ready.law,
        ready.motion.reference,
        machine=ready.machine,
        arm=ready.arm,
        versions=config.fmi,
        program=config.program,
    )
    # origin of the files, and what was found
    fingerprint = physics_fingerprint(in_engine(ready.machine).spec(options).compile())
    info = provenance("ffgym export fmu", config, ready.arm.robot.name, fingerprint, seed=None)
    info |= {"motion": ready.motion.reference.name, "feedforward_law": ready.law.name}
    write_numbers(config, info | {"checks": [asdict(check) for check in checks]})
    print(f"{ready.law.name} for {ready.motion.reference.name}, {checks[0].steps} steps")
    for check in checks:
        print(f"FMI {check.version}: valid, {check.largest_difference:.2g} at most from the simulation (SI units)")
    notes = [*ready.motion.notes, missing_text(ready.machine)]
    print("".join(f"note: {note}\n" for note in notes if note), end="")
    print_places(folder=config.out, numbers=config.json)
