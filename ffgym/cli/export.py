"""`ffgym export`: a robot, and a motion on it, in files that need nothing of ffgym."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

from ffgym.cli.laws import check_laws, make_laws, setting_for
from ffgym.cli.motion_options import Export
from ffgym.cli.outputs import claim_new_folder, claim_outputs, given_options, print_places, provenance, write_numbers
from ffgym.cli.program_motion import ProgramOptions, list_events, read_motion, tell_events
from ffgym.cli.progress import progress_bar
from ffgym.control import FeedForwardLaw
from ffgym.core.errors import FFGymError
from ffgym.envs.machines import load_described_robot
from ffgym.paths.motions import Motion
from ffgym.robot import ModelOptions, RigidArm, RobotDescription, physics_fingerprint
from ffgym.simulation import Run, SimulatedRig
from ffgym.simulation.export import ReferenceForm, export_model, export_run
from ffgym.simulation.export.model import in_engine, missing_text
from ffgym.simulation.plant import Machine, load_machine
from ffgym.simulation.plant.machine_file import is_machine_file, known_robot


def run(config: Export) -> None:
    """Check, simulate, write, print."""
    if config.out.suffix in (".xml", ".mjb"):
        raise FFGymError(f"--out {config.out}: must be a folder; the model in it is model.xml.")
    claim_new_folder(config.out)
    claim_outputs({"--json": config.json})
    check_laws([config.feedforward], "--feedforward")
    known, machine = load_machine_or_robot(config.robot)
    given = given_options(config, ("entry", "feedforward", "parameters", "sides", "angles", "record_dt_ms"))
    if config.path is None and given:
        raise FFGymError(
            f"{', '.join(given)} has no effect without a motion. Name one after the robot, or leave it out."
        )
    options = ModelOptions(
        flexible=config.flexible, friction=config.friction, gravity=config.gravity, springs=config.springs
    )
    if config.path is None:
        lines, info = _export_model(config, machine, options)
    else:
        lines, info = _export_motion(config, config.path, RigidArm(known), machine, options)
    if missing := missing_text(machine):
        lines.append(f"note: {missing}")
    write_numbers(config, info)
    print("\n".join(lines))
    print_places(folder=config.out, numbers=config.json)


def _export_model(config: Export, machine: Machine, options: ModelOptions) -> tuple[list[str], dict[str, Any]]:
    """Export the robot alone; returns what to print, and where the files come from."""
    export_model(config.out, machine, options=options, binary=config.binary)
    model = in_engine(machine).spec(replace(options, looks=False)).compile()
    info = provenance("ffgym export", config, machine.robot.name, physics_fingerprint(model), seed=None)
    return [f"{model.nv} degrees of freedom, {model.nu} controls (position, velocity, torque of each motor)"], info


def _export_motion(
    config: Export, path: str, arm: RigidArm, machine: Machine, options: ModelOptions
) -> tuple[list[str], dict[str, Any]]:
    """Export the robot and a motion on it; returns what to print, and where the files come from."""
    ready = prepare_motion(config, config.robot, path, arm, machine, options)
    motion, law, arm = ready.motion, ready.law, ready.arm
    # closed loop with this law, recorded beside the reference
    with progress_bar("exporting", "s") as progress:
        recording = export_run(
            config.out,
            Run(reference=motion.reference, law=law),
            arm=arm,
            machine=ready.machine,
            options=options,
            form=ReferenceForm(sides=config.sides, angles=config.angles),
            binary=config.binary,
            record_dt=config.record_dt_ms / 1e3,
            n_threads=config.threads,
            progress=progress,
        )
    # origin of the files, for whoever replays them elsewhere
    fingerprint = recording.header.provenance["physics_fingerprint"]
    info = provenance("ffgym export", config, arm.robot.name, fingerprint, seed=None)
    info |= {"motion": motion.reference.name, "duration": motion.reference.duration, "notes": list(motion.notes)}
    info["events"] = list_events(motion)
    rows = f"{motion.reference.duration:g} s, {len(recording)} recorded rows"
    notes = [f"note: {note}" for note in motion.notes]
    lines = [f"{motion.reference.name} with {law.name}: {rows}", *notes, *tell_events(motion)]
    return lines, info | {"feedforward_law": law.name}


class MotionOptions(ProgramOptions, Protocol):
    """Options of a command that prepares a motion under a law."""

    @property
    def feedforward(self) -> str:
        """Name or file of a law."""

    @property
    def parameters(self) -> Path | None:
        """Parameters of the law's model."""

    @property
    def threads(self) -> int:
        """Threads of the simulation."""


@dataclass(frozen=True, kw_only=True)
class PreparedMotion:
    """A motion on a machine, and the law that is made for it."""

    arm: RigidArm
    machine: Machine
    motion: Motion
    law: FeedForwardLaw


def load_machine_or_robot(name: str) -> tuple[RobotDescription, Machine]:
    """Load what a name or file describes: the robot that its controller knows, and the machine as it is."""
    if is_machine_file(name):
        return known_robot(name), load_machine(name)
    known = load_described_robot(name)
    return known, Machine.of(known)


def prepare_motion(
    config: MotionOptions, robot: str, path: str, arm: RigidArm, machine: Machine, options: ModelOptions
) -> PreparedMotion:
    """Load a motion and make the law that the options name, on what MuJoCo has of the machine.

    Raises:
        FFGymError: if the motion or the law cannot be made, or the motion brings a tool that the machine cannot take.
    """
    motion = read_motion(config, arm, path)
    if motion.reference.robot is not arm.robot:  # the motion brings its own tool
        if machine.robot is not arm.robot:
            raise FFGymError(f"{path} brings a tool of its own, but that of {robot} cannot be changed.")
        arm, machine = RigidArm(motion.reference.robot), Machine.of(motion.reference.robot)
    # feedforward law for this motion, from the nominal model
    rig = SimulatedRig(arm=arm, machine=in_engine(machine), options=replace(options, looks=False))
    setting = setting_for(rig, [motion.reference], config.parameters, config.threads)
    (law,) = make_laws([config.feedforward], setting)
    return PreparedMotion(arm=arm, machine=machine, motion=motion, law=law)
