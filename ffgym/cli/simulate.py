"""`ffgym simulate`: any motion on any robot with any feed-forward laws: recordings, errors, pictures."""

import re
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import tyro

from ffgym.cli.laws import check_laws, make_laws, setting_for
from ffgym.cli.outputs import check_outputs, need_extra, provenance
from ffgym.cli.progress import progress_bar
from ffgym.cli.unused import given_options
from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.files import write_json, write_text
from ffgym.envs.machines import is_workcell, rig_of
from ffgym.paths.motions import Motion, load_motion
from ffgym.recordings import write_recording
from ffgym.recordings.io import FORMATS
from ffgym.robot import ModelOptions, RigidArm, RobotDescription
from ffgym.simulation import RECORD_DT, Rig, SimulatedRig, sensors_of
from ffgym.studies import MotionStudy, motion_study


@dataclass(frozen=True)
class Simulate:
    """Run a motion on a simulated robot with feed-forward laws; print errors and how much of the limits is used."""

    robot: tyro.conf.Positional[str]
    """Built-in robot, a path that ends in .toml to a description or a machine file, or workcell:<name or seed>."""
    path: tyro.conf.Positional[str]
    """Built-in motion, or a file: .toml (motion), .csv (poses or joint positions), .mod (RAPID)."""
    entry: str | None = None
    """Procedure of a RAPID program to run; none is main, or the only one."""
    feedforward: tuple[str, ...] = ("none", "lugre_dynamic")
    """Names of docs/agents, model:<machine file>, or files of learned laws. Those that learn are trained first, on
    their standard motions."""
    parameters: Path | None = None
    """Parameter file for the laws' model of the robot; the simulated machine keeps its own numbers."""
    sensors: bool = False
    """Record what resolvers and laser tracker measure, instead of the exact state; a workcell is always measured."""
    seed: int = 0
    """Of the sensors' noise."""
    record_dt_ms: float = RECORD_DT * 1e3
    """Time between the rows of a recording."""
    flexible: bool = True
    """Elastic joints; no-flexible makes them rigid."""
    friction: bool = True
    """Friction; no-friction leaves it out."""
    gravity: bool = True
    """Gravity; no-gravity leaves it out."""
    springs: bool = True
    """Springs between links, e.g. a counterbalance; no-springs leaves them out."""
    out: Path | None = None
    """Recording to write, .csv or .npz; with several laws each has its own file, and its name before the suffix."""
    report: Path | None = None
    """Page with pictures to write, .html, in one file that can be sent."""
    json: Path | None = None
    """Also write every number to this file."""
    threads: int = 0
    """Threads of the simulation, 0 for all cores; results are the same at any number."""

    def run(self) -> None:
        """Check, simulate, write, print."""
        recordings = self._check()
        rig = self._rig()
        motion = load_motion(rig.arm, self.path, entry=self.entry)
        if motion.reference.robot is not rig.robot:  # the motion brings its own tool
            rig = self._with_tool_of(rig, motion.reference.robot)
        study = self._simulated(rig, motion)
        info = provenance("ffgym simulate", self, study.robot.name, study.fingerprint, self._seed)
        notes = [*motion.notes, *study.overloads]
        info |= {"motion": motion.reference.name, "duration": motion.reference.duration, "notes": notes}
        self._write(study, recordings, info)
        from ffgym.report import format_motion

        print("\n".join([format_motion(study), *(f"note: {note}" for note in info["notes"])]))
        places = [("recording", path) for path in recordings.values()]
        for what, place in [*places, ("report", self.report), ("numbers", self.json)]:
            if place is not None:
                print(f"{what}: {place}")

    @property
    def _seed(self) -> int | None:
        """None where nothing is random."""
        return self.seed if self._is_measured else None

    @property
    def _is_measured(self) -> bool:
        return self.sensors or is_workcell(self.robot)

    def _check(self) -> dict[str, Path]:
        """Refuse what cannot be run or written; returns the recordings' places by law."""
        names = check_laws(self.feedforward, "--feedforward")
        if not self._is_measured and (given := given_options(self, ("seed",))):
            raise FFGymError(f"{given[0]} has no effect without --sensors: nothing else is random. Leave it out.")
        recordings = self._recordings(names)
        if self.report is not None:
            need_extra("The report", "matplotlib", "jinja2")
        places = {f"--out of {name}": path for name, path in recordings.items()}
        inputs = (self.robot, self.path, self.parameters, *self.feedforward)
        check_outputs({**places, "--report": self.report, "--json": self.json}, inputs=inputs)
        return recordings

    def _recordings(self, laws: list[str]) -> dict[str, Path]:
        if self.out is None:
            return {}
        check_choice("recording format", self.out.suffix, list(FORMATS))
        if len(laws) == 1:
            return {laws[0]: self.out}
        names = {law: re.sub(r"[^\w.-]", "_", law) for law in laws}  # names of files may hold anything
        return {law: self.out.with_stem(f"{self.out.stem}_{name}") for law, name in names.items()}

    def _rig(self) -> Rig:
        """Where the motion is run."""
        if is_workcell(self.robot):
            if given := given_options(self, ("flexible", "friction", "gravity", "springs")):
                raise FFGymError(f"{given[0]} has no effect on {self.robot}, which is what it is. Leave it out.")
            return rig_of(self.robot)
        options = ModelOptions(
            flexible=self.flexible, friction=self.friction, gravity=self.gravity, springs=self.springs, looks=False
        )
        rig = rig_of(self.robot, options=options)
        assert isinstance(rig, SimulatedRig)
        return replace(rig, sensors=sensors_of(rig.robot) if self.sensors else ())

    def _with_tool_of(self, rig: Rig, robot: RobotDescription) -> Rig:
        """The rig with a robot that has another tool."""
        if not isinstance(rig, SimulatedRig) or rig.machine is not None:
            raise FFGymError(f"{self.path} brings a tool of its own, but that of {self.robot} cannot be changed.")
        return replace(rig, arm=RigidArm(robot))

    def _simulated(self, rig: Rig, motion: Motion) -> MotionStudy:
        setting = setting_for(rig, [motion.reference], self.parameters, self.threads)
        laws = make_laws(self.feedforward, setting)
        with progress_bar("simulating", "s") as progress:
            return motion_study(
                [motion.reference],
                laws=laws,
                rig=rig,
                seed=self.seed,
                record_dt=self.record_dt_ms / 1e3,
                n_threads=self.threads,
                progress=progress,
            )

    def _write(self, study: MotionStudy, recordings: dict[str, Path], info: dict[str, Any]) -> None:
        """Files first: nobody may read what is printed."""
        for law, place in recordings.items():
            write_recording(study.recordings[law, info["motion"]], place)
        if self.report is not None:
            from ffgym.report import render_motion_page

            origin = {name: value for name, value in info.items() if name != "notes"}
            write_text(self.report, render_motion_page(study, info["notes"], origin))
        if self.json is not None:
            places = {law: str(place) for law, place in recordings.items()}
            results = [asdict(result) for result in study.results]
            write_json(self.json, info | {"recordings": places, "results": results})
