"""Robot and program as FMUs for co-simulation, compared with the simulation before they are written.

`plant` is the robot under its servos: the exported model in MuJoCo's own library. `program` gives set-points and
torques of one motion under a feed-forward law, as C makes them. Outputs of the program are inputs of the plant.
"""

import os
import platform
from collections.abc import Sequence
from hashlib import sha256
from pathlib import Path
from typing import get_args

import mujoco
import numpy as np

from ffgym.control import FeedForwardLaw, rigid_feedforward
from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.files import new_folder, write_bytes, write_text
from ffgym.core.provenance import is_installed
from ffgym.core.types import Array
from ffgym.core.version import __version__
from ffgym.deployment.code.compiler import fill_template, need_compiler
from ffgym.deployment.code.fmu_build import FmuParts, build_fmu
from ffgym.deployment.code.fmu_check import FmuCheck, compare_with_simulation, validate
from ffgym.deployment.code.law import write_law_files
from ffgym.deployment.code.law_text import number_rows
from ffgym.deployment.code.model_description import FmuVariable, ModelDescription, Version
from ffgym.paths import Reference
from ffgym.recordings import Recording
from ffgym.robot import ModelOptions, RigidArm, RobotDescription, model_bytes
from ffgym.simulation import Run, simulate
from ffgym.simulation.export.model import add_rest, in_engine, missing_text, plant_of, spec_with_home
from ffgym.simulation.plant import Machine

_TOOL = f"ffgym {__version__}"


def write_fmus(
    path: str | os.PathLike[str],
    law: FeedForwardLaw,
    reference: Reference,
    *,
    machine: Machine | None = None,
    arm: RigidArm | None = None,
    versions: Sequence[Version] = ("2.0", "3.0"),
    program: bool = True,
) -> list[FmuCheck]:
    """Write a folder with `plant_fmi2.fmu`, `program_fmi2.fmu` and the same for FMI 3.

    Args:
        path: a folder that is empty or does not exist.
        law: feed-forward law of the program.
        reference: motion of the program; the plant rests where it begins.
        machine: what the plant is, with those of its effects that MuJoCo has; None is the robot of the reference.
        arm: rigid dynamics of the controller, if the caller has them already.
        versions: versions of the standard.
        program: False leaves the program out, for laws that have no form in C.

    Returns:
        Comparison with the simulation, one for each version.

    Raises:
        FFGymError: if a compiler or a package is missing, the computer is no Linux on x86-64, the law has no form in C,
            FMPy finds a mistake, or a number differs from the simulation; nothing is written then.
    """
    for version in versions:
        check_choice("version of FMI", version, get_args(Version))
    compiler = _need_tools()
    arm, machine = arm or RigidArm(reference.robot), machine or Machine.of(reference.robot)
    rigid = rigid_feedforward(arm, reference)
    parts = [plant_parts(machine, reference, rigid[0])]
    if program:
        parts.append(program_parts(law, reference, rigid))
    recording = _record(law, reference, machine, arm)
    checks = []
    with new_folder(path) as folder:
        for version in versions:
            files = [folder / f"{part.description.name}_fmi{version[0]}.fmu" for part in parts]
            for file, part in zip(files, parts, strict=True):
                write_bytes(file, build_fmu(part, version, compiler))
                validate(file)
            checks.append(compare_with_simulation(files, version, recording, reference))
        write_text(folder / "README.txt", _readme(parts, machine, reference, law))
    return checks


def _need_tools() -> str:
    """Return the compiler, if all that FMUs need is there."""
    if platform.system() != "Linux" or platform.machine() != "x86_64":
        raise FFGymError(
            f"FMUs are written on Linux with x86-64 alone, for that platform; this is {platform.system()} on "
            f"{platform.machine()}."
        )
    if not is_installed("fmpy"):
        raise FFGymError("FMUs are validated by FMPy, which is missing: pip install 'ffgym[fmu]'.")
    return need_compiler("An FMU", optional=False)


def _record(law: FeedForwardLaw, reference: Reference, machine: Machine, arm: RigidArm) -> Recording:
    """Simulate the program, recorded every control step."""
    options = ModelOptions(looks=False)
    run = Run(reference=reference, law=law)
    dt = reference.robot.servo.control_dt
    (recording,) = simulate([run], arm=arm, machine=in_engine(machine), options=options, record_dt=dt)
    return recording


def plant_parts(machine: Machine, reference: Reference, torque: Array) -> FmuParts:
    """Make the parts of the plant: the exported model, which rests at the start of a motion under `torque` (N,)."""
    robot = machine.robot
    # model with a keyframe that rests at the start
    plant = plant_of(machine, None)
    spec = spec_with_home(plant, machine, ModelOptions(looks=False))
    start = np.concatenate([reference.motor_q[0], reference.motor_dq[0], torque])
    controls = np.empty(plant.model.nu)
    for part, values in zip(plant.split_controls(controls), np.split(start, 3), strict=True):
        part[:] = values
    add_rest(spec, plant, "start", reference.q[0], reference.dq[0], controls)
    model = model_bytes(spec.compile())
    # description, and code with the names of the joints
    about = f"{robot.title} under its servos. {missing_text(machine)}"
    names = ", ".join(f'"{joint}"' for joint in robot.joints)
    source = fill_template("plant.c", {"joints": str(robot.n_joints), "names": names})
    description = _describe("plant", about, _plant_variables(robot, start), reference, source, model)
    (library,) = Path(mujoco.__file__).parent.glob("libmujoco.so.*")
    return FmuParts(
        description=description, sources={"plant.c": source}, libraries=(library,), resources={"model.mjb": model}
    )


def _plant_variables(robot: RobotDescription, start: Array) -> list[FmuVariable]:
    """List inputs, which begin with `start` (3 N,), and outputs of the plant, in the order of plant.c."""
    joints, lengths = robot.joints, robot.kinematics.units
    inputs = {
        "position": ("rad", "Set-point of motor {} for the end of the next step."),
        "velocity": ("rad/s", "Set-point of motor {} for the end of the next step."),
        "torque": ("N.m", "Feed-forward torque of motor {} for the end of the next step."),
    }
    variables = [
        FmuVariable(f"{name}.{joint}", unit, meaning.format(joint), float(value))
        for (name, (unit, meaning)), values in zip(inputs.items(), np.split(start, 3), strict=True)
        for joint, value in zip(joints, values, strict=True)
    ]
    variables += [FmuVariable(f"motor_position.{joint}", "rad", f"Angle of motor {joint}.") for joint in joints]
    variables += [FmuVariable(f"motor_velocity.{joint}", "rad/s", f"Speed of motor {joint}.") for joint in joints]
    for name, meaning, per in (("link_position", "Position", ""), ("link_velocity", "Speed", "/s")):
        variables += [
            FmuVariable(f"{name}.{joint}", f"{unit}{per}", f"{meaning} of joint {joint}, behind its spring.")
            for joint, unit in zip(joints, lengths, strict=True)
        ]
    if robot.tool is not None:
        variables += [FmuVariable(f"tcp.{axis}", "m", f"{axis} of the tool centre point.") for axis in "xyz"]
    return variables


def program_parts(law: FeedForwardLaw, reference: Reference, rigid: Array) -> FmuParts:
    """Make the parts of a program: reference, law in C, and torque of the controller (T, N)."""
    robot = reference.robot
    files = write_law_files(law, reference, "law", checked=True)
    tables = [reference.q, reference.motor_q, reference.motor_dq, reference.motor_ddq, rigid]
    text = ",\n".join("{\n" + number_rows(table) + "}" for table in tables)
    source = fill_template("program.c", {"name": "law", "upper": "LAW", "reference": text})
    kinds = {
        "position": ("rad", "Set-point of motor {} at the end of the next step."),
        "velocity": ("rad/s", "Set-point of motor {} at the end of the next step."),
        "torque": ("N.m", "All feed-forward torque of motor {} at the end of the next step."),
        "added_torque": ("N.m", f"Part of the torque of motor {{}} that the law {law.name} adds."),
    }
    variables = [
        FmuVariable(f"{kind}.{joint}", unit, meaning.format(joint))
        for kind, (unit, meaning) in kinds.items()
        for joint in robot.joints
    ]
    about = f"Set-points of {reference.name} on {robot.name}, with feed-forward {law.name}."
    sources = {"program.c": source} | {name: files[name] for name in ("law.c", "law.h")}
    description = _describe("program", about, variables, reference, *sources.values())
    return FmuParts(description=description, sources=sources, resources={})


def _describe(
    name: str, about: str, variables: Sequence[FmuVariable], reference: Reference, *contents: str | bytes
) -> ModelDescription:
    """Describe a model; its token is a hash of all that it is made of."""
    found = sha256()
    for part in (about, *(repr(variable) for variable in variables), *contents):
        found.update(part if isinstance(part, bytes) else part.encode())
    digits = found.hexdigest()
    token = "{" + "-".join(digits[a:b] for a, b in ((0, 8), (8, 12), (12, 16), (16, 20), (20, 32))) + "}"
    return ModelDescription(
        name=name,
        about=about.strip(),
        tool=_TOOL,
        token=token,
        variables=tuple(variables),
        stop=float(reference.t[-1]),
        step=reference.robot.servo.control_dt,
    )


def _readme(parts: Sequence[FmuParts], machine: Machine, reference: Reference, law: FeedForwardLaw) -> str:
    """Describe the folder."""
    lines = [f"{machine.robot.title}: {reference.name} with {law.name}, as FMUs for co-simulation. {_TOOL}.", ""]
    for part in parts:
        description = part.description
        lines.append(f"{description.name}_fmi*.fmu: {description.about}")
        lines += [
            f"    {v.name} [{v.unit}], {'output' if v.start is None else 'input'}: {v.meaning}"
            for v in description.variables
        ]
    lines += [
        "",
        f"Connect outputs of the program with inputs of the plant by their names, in steps of {description.step:g} s.",
        "Validated by FMPy and compared with the simulation when they were written.",
    ]
    return "\n".join(lines) + "\n"
