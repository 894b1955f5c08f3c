"""`ffgym record`: measurement protocols on a machine, one recording for each motion."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from ffgym.cli.laws import check_laws, make_laws, setting_for
from ffgym.cli.outputs import check_outputs, provenance
from ffgym.cli.progress import progress_bar
from ffgym.cli.protocol_list import protocol_list
from ffgym.cli.unused import given_options
from ffgym.control import FeedForwardLaw
from ffgym.core.errors import FFGymError, check_number
from ffgym.core.files import write_json
from ffgym.envs.machines import rig_of
from ffgym.recordings.io import INDEX
from ffgym.robot import RobotDescription
from ffgym.simulation import RECORD_DT, Rig, Sensor, SimulatedRig, TorqueSensor
from ffgym.simulation.protocols import (
    Protocol,
    RecordedSession,
    SessionMotion,
    load_protocols,
    plan_session,
    record_into,
    usual_sensors,
)
from ffgym.simulation.protocols.protocol import JointProtocol

LISTED_ROBOT = "irb4600_60_205"
"""Robot that --list tells durations for, if none is named."""


@dataclass(frozen=True)
class Record:
    """Run measurement protocols on a machine; write one recording for each motion, and an index of them."""

    robot: tyro.conf.Positional[str | None] = None
    """Built-in robot, a path that ends in .toml to a description or a machine file, or workcell:<name or seed>."""
    protocols: tyro.conf.Positional[tuple[str, ...]] = ()
    """Names of protocols, motion files (.toml, .csv, .mod), or .toml files that list steps (docs/protocols.md)."""
    listing: Annotated[bool, tyro.conf.arg(name="list")] = False
    """Show the protocols, how long they take and what they serve, and record nothing."""
    out: Path | None = None
    """Folder for the recordings; it is made if there is none. What is complete in it is not made again."""
    joints: tuple[str, ...] = ()
    """Joints that the protocols move; none given is all."""
    feedforward: str = "none"
    """Name of docs/agents, or file of a learned law. One that learns is trained first, on its standard motions."""
    parameters: Path | None = None
    """Parameter file for the law's model of the robot; the machine keeps its own numbers."""
    seed: int = 0
    """Of the sensors' noise."""
    exact: bool = False
    """Record the exact state of a simulated robot, with what no machine knows, instead of what sensors measure."""
    torque_noise_percent: float = 0.0
    """White noise of the measured torque, in percent of each drive's peak torque."""
    later_min: float = 0.0
    """How much later in the day the session begins than the machine is set up for; one that warms up is warmer then."""
    record_dt_ms: float = RECORD_DT * 1e3
    """Time between the rows of a recording."""
    format: Literal["npz", "csv"] = "npz"
    """Format of the recordings."""
    force: bool = False
    """Make recordings again that are complete, and write over those of another session."""
    json: Path | None = None
    """Also write what was recorded to this file."""
    threads: int = 0
    """Threads of the simulation, 0 for all cores; recordings are the same at any number."""

    def run(self) -> None:
        """Check, simulate, write, print."""
        if self.listing:
            print(protocol_list(rig_of(self.robot or LISTED_ROBOT).arm))
            return
        folder = self._check()
        rig = self._rig()
        motions = plan_session(rig.arm, self._protocols(), start=self._start)
        law = self._law(rig, motions)
        session = self._recorded(folder, motions, rig, law)
        if self.json is not None:
            write_json(self.json, session.index | {"folder": str(folder), "made": session.made, "kept": session.kept})
        seconds = sum(motion.reference.duration for motion in motions)
        before = f", {session.kept} were complete before" if session.kept else ""
        print(f"{session.made} recordings of {len(motions)} made{before}; {seconds:.0f} s of motion in all")
        print(f"recordings: {folder}")
        print(f"index: {folder / INDEX}")
        if self.json is not None:
            print(f"numbers: {self.json}")

    def _check(self) -> Path:
        """Refuse what cannot be run or written; returns the folder."""
        if self.robot is None or not self.protocols:
            raise FFGymError("Name a robot and what to record, e.g. one_axis diagnosis; --list shows the protocols.")
        if self.out is None:
            raise FFGymError("Say where the recordings go: --out FOLDER.")
        if self.exact and (given := given_options(self, ("seed", "torque_noise_percent"))):
            raise FFGymError(f"{given[0]} has no effect with --exact: nothing is measured. Leave one of them out.")
        if self.parameters is not None and self.feedforward == "none":
            raise FFGymError("--parameters has no effect without --feedforward: no law has a model. Leave it out.")
        check_laws([self.feedforward], "--feedforward")
        if self.out.exists() and not self.out.is_dir():
            raise FFGymError(f"--out {self.out}: is a file, must be a folder; choose another name.")
        index = self.out / INDEX if self.out.exists() else None
        inputs = (self.robot, self.parameters, *self.protocols)
        check_outputs({"--json": self.json, "the index of the recordings": index}, inputs=inputs)
        return self.out

    @property
    def _start(self) -> float:
        """When the session begins [s]."""
        return 60.0 * check_number("--later-min", self.later_min, unit="min", low=0.0)

    def _rig(self) -> Rig:
        """Where the motions are run."""
        assert self.robot is not None
        rig = rig_of(self.robot)
        if isinstance(rig, SimulatedRig):
            return replace(rig, sensors=() if self.exact else self._sensors(rig.robot))
        if given := given_options(self, ("exact", "torque_noise_percent")):
            raise FFGymError(f"{given[0]} is not for {self.robot}: its sensors are its own, its truth is shut away.")
        return rig

    def _sensors(self, robot: RobotDescription) -> tuple[Sensor, ...]:
        """What measures on a simulated robot."""
        noise = check_number("--torque-noise-percent", self.torque_noise_percent, unit="%", low=0.0, high=100.0) / 100
        torque = (TorqueSensor(noise=noise * robot.drive.peak_torque),) if noise > 0 else ()
        return (*usual_sensors(robot), *torque)

    def _protocols(self) -> list[Protocol]:
        """Protocols as they are named, for the joints that are."""
        protocols = [protocol for name in self.protocols for protocol in load_protocols(name)]
        if not self.joints:
            return protocols
        chosen: list[Protocol] = []
        for protocol in protocols:
            if not isinstance(protocol, JointProtocol):
                raise FFGymError(
                    f"--joints has no effect on {protocol.name}, which moves the tool or says itself what moves."
                )
            chosen.append(replace(protocol, joints=self.joints))
        return chosen

    def _law(self, rig: Rig, motions: list[SessionMotion]) -> FeedForwardLaw:
        """The feed-forward law, trained if it is one that learns."""
        references = [motion.reference for motion in motions]
        (law,) = make_laws([self.feedforward], setting_for(rig, references, self.parameters, self.threads))
        return law

    def _recorded(self, folder: Path, motions: list[SessionMotion], rig: Rig, law: FeedForwardLaw) -> RecordedSession:
        seed = None if self.exact else self.seed
        origin = provenance("ffgym record", self, rig.robot.name, rig.fingerprint, seed)
        with progress_bar("recording", "s") as progress:
            return record_into(
                folder,
                motions,
                rig,
                law=law,
                seed=self.seed,
                record_dt=self.record_dt_ms / 1e3,
                origin=_lasting(origin),
                suffix=f".{self.format}",
                force=self.force,
                n_threads=self.threads,
                progress=progress,
            )


def _lasting(origin: dict[str, Any]) -> dict[str, Any]:
    """What recordings depend on, without options that only say where they go and how they are made."""
    passing = ("listing", "out", "json", "force", "threads", "format")
    config = {name: value for name, value in origin["config"].items() if name not in passing}
    return {"command": origin["command"], "config": config}
