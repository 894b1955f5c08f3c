"""`ffgym export code`: a feed-forward law as C99."""

from dataclasses import asdict

from ffgym.cli.code_options import ExportCode
from ffgym.cli.export import load_machine_or_robot, prepare_motion
from ffgym.cli.laws import check_laws
from ffgym.cli.outputs import claim_new_folder, claim_outputs, print_places, provenance, write_numbers
from ffgym.deployment.code import write_law_code
from ffgym.deployment.code.compiler import UNCHECKED, need_compiler
from ffgym.deployment.code.law import check_name
from ffgym.robot import ModelOptions, RigidArm, physics_fingerprint
from ffgym.simulation.export.model import in_engine


def run(config: ExportCode) -> None:
    """Check, trace, compile, compare, write, print."""
    claim_new_folder(config.out)
    claim_outputs({"--json": config.json}, inputs=(config.robot, config.path, config.parameters, config.feedforward))
    check_laws([config.feedforward], "--feedforward")
    check_name(config.name)
    if not config.unchecked:
        need_compiler("A law in C")
    known, machine = load_machine_or_robot(config.robot)
    options = ModelOptions(looks=False)
    ready = prepare_motion(config, config.robot, config.path, RigidArm(known), machine, options)
    check = write_law_code(
        ready.law, ready.motion.reference, config.out, name=config.name, checked=not config.unchecked
    )
    # origin of the files, and what was found
    fingerprint = physics_fingerprint(in_engine(ready.machine).spec(options).compile())
    info = provenance("ffgym export code", config, ready.arm.robot.name, fingerprint, seed=None)
    info |= {"motion": ready.motion.reference.name, "feedforward_law": ready.law.name}
    write_numbers(config, info | {"check": None if check is None else asdict(check)})
    print(f"{ready.law.name} for {ready.motion.reference.name}, {len(ready.motion.reference.t)} samples")
    print("\n".join(f"note: {note}" for note in ready.motion.notes), end="\n" if ready.motion.notes else "")
    if check is None:
        print(f"note: {UNCHECKED}")
    else:
        print(f"largest difference from the simulation: {check.largest_difference:.2g} N m")
        print(f"time of a step on this computer: {check.worst_us:.2g} us at most, median {check.median_us:.2g} us")
    print_places(folder=config.out, numbers=config.json)
