"""`ffgym export`: a robot, and a motion on it, in files that need nothing of ffgym."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import tyro

from ffgym.cli.descriptions import described_robot
from ffgym.cli.laws import check_laws, make_laws, setting_for
from ffgym.cli.outputs import check_outputs, provenance
from ffgym.cli.progress import progress_bar
from ffgym.cli.unused import given_options
from ffgym.core.errors import FFGymError
from ffgym.core.files import check_vacant, write_json
from ffgym.paths.motions import load_motion
from ffgym.robot import ModelOptions, RigidArm, physics_fingerprint
from ffgym.simulation import RECORD_DT, Run, SimulatedRig
from ffgym.simulation.export import ReferenceForm, export_model, export_run
from ffgym.simulation.export.model import Angles, Sides, in_engine, missing_text
from ffgym.simulation.plant import Machine, load_machine
from ffgym.simulation.plant.machine_file import is_machine_file, known_robot


@dataclass(frozen=True)
class Export:
    """Write a folder with the robot's model as MJCF; with a motion, also its set-points, reference and recording."""

    robot: tyro.conf.Positional[str]
    """Built-in robot, or a path that ends in .toml to a description or a machine file."""
    path: tyro.conf.Positional[str | None] = None
    """Built-in motion, or a file: .toml (motion), .csv (poses or joint positions), .mod (RAPID); none is the model."""
    entry: str | None = None
    """Procedure of a RAPID program to run; none is main, or the only one."""
    out: Path = Path("export")
    """Folder to write; it must be empty or not exist."""
    feedforward: str = "none"
    """Name of docs/agents, or file of a learned law. One that learns is trained first, on its standard motions."""
    parameters: Path | None = None
    """Parameter file for the law's model of the robot; the exported machine keeps its own numbers."""
    sides: Sides = "both"
    """Side of the gearbox of the quantities in reference.csv."""
    angles: Angles = "rad"
    """Unit of angles in reference.csv."""
    binary: bool = False
    """Also write model.mjb, which loads faster, in this version of MuJoCo only."""
    record_dt_ms: float = RECORD_DT * 1e3
    """Time between the rows of the recording."""
    flexible: bool = True
    """Elastic joints; no-flexible makes them rigid."""
    friction: bool = True
    """Friction; no-friction leaves it out."""
    gravity: bool = True
    """Gravity; no-gravity leaves it out."""
    springs: bool = True
    """Springs between links, e.g. a counterbalance; no-springs leaves them out."""
    json: Path | None = None
    """Also write where the files come from to this file."""
    threads: int = 0
    """Threads of the simulation, 0 for all cores; results are the same at any number."""

    def run(self) -> None:
        """Check, simulate, write, print."""
        if self.out.suffix in (".xml", ".mjb"):
            raise FFGymError(f"--out {self.out}: must be a folder; the model in it is model.xml.")
        check_vacant(self.out)
        check_outputs({"--json": self.json})
        check_laws([self.feedforward], "--feedforward")
        is_machine = is_machine_file(self.robot)
        known = known_robot(self.robot) if is_machine else described_robot(self.robot)
        machine = load_machine(self.robot) if is_machine else Machine.of(known)
        self._refuse_unused()
        lines = self._model(machine) if self.path is None else self._motion(RigidArm(known), machine, self.path)
        if missing := missing_text(machine):
            lines.append(f"note: {missing}")
        print("\n".join([*lines, f"folder: {self.out}"]))
        if self.json is not None:
            print(f"origin: {self.json}")

    def _refuse_unused(self) -> None:
        """Options that say how a motion is run have no effect without one."""
        given = given_options(self, ("entry", "feedforward", "parameters", "sides", "angles", "record_dt_ms"))
        if self.path is None and given:
            raise FFGymError(
                f"{', '.join(given)} has no effect without a motion. Name one after the robot, or leave it out."
            )

    @property
    def _options(self) -> ModelOptions:
        return ModelOptions(flexible=self.flexible, friction=self.friction, gravity=self.gravity, springs=self.springs)

    def _model(self, machine: Machine) -> list[str]:
        """Export the robot alone; returns what to print."""
        export_model(self.out, machine, options=self._options, binary=self.binary)
        model = in_engine(machine).spec(replace(self._options, looks=False)).compile()
        self._write_origin(machine.robot.name, physics_fingerprint(model), {})
        return [f"{model.nv} degrees of freedom, {model.nu} controls (position, velocity, torque of each motor)"]

    def _motion(self, arm: RigidArm, machine: Machine, path: str) -> list[str]:
        """Export the robot and a motion on it; returns what to print."""
        motion = load_motion(arm, path, entry=self.entry)
        if motion.reference.robot is not arm.robot:  # the motion brings its own tool
            if machine.robot is not arm.robot:
                raise FFGymError(f"{path} brings a tool of its own, but that of {self.robot} cannot be changed.")
            arm, machine = RigidArm(motion.reference.robot), Machine.of(motion.reference.robot)
        rig = SimulatedRig(arm=arm, machine=in_engine(machine), options=replace(self._options, looks=False))
        setting = setting_for(rig, [motion.reference], self.parameters, self.threads)
        (law,) = make_laws([self.feedforward], setting)
        with progress_bar("exporting", "s") as progress:
            recording = export_run(
                self.out,
                Run(reference=motion.reference, law=law),
                arm=arm,
                machine=machine,
                options=self._options,
                form=ReferenceForm(sides=self.sides, angles=self.angles),
                binary=self.binary,
                record_dt=self.record_dt_ms / 1e3,
                n_threads=self.threads,
                progress=progress,
            )
        what = {"motion": motion.reference.name, "duration": motion.reference.duration, "notes": list(motion.notes)}
        what["feedforward_law"] = law.name
        self._write_origin(arm.robot.name, recording.header.provenance["physics_fingerprint"], what)
        said = (
            f"{motion.reference.name} with {law.name}: {motion.reference.duration:g} s, {len(recording)} recorded rows"
        )
        return [said, *(f"note: {note}" for note in motion.notes)]

    def _write_origin(self, robot: str, fingerprint: str, what: dict[str, Any]) -> None:
        """Write where the files come from. Nothing is random, so that the seed is null."""
        if self.json is not None:
            write_json(self.json, provenance("ffgym export", self, robot, fingerprint, seed=None) | what)
