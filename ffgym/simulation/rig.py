"""Rigs: machines under their controllers; motions go in, recordings come out."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from ffgym.core.errors import FFGymError, check_class
from ffgym.recordings import Recording
from ffgym.robot import ModelOptions, RigidArm, RobotDescription
from ffgym.simulation.plant import Machine
from ffgym.simulation.run import RECORD_DT, Progress, Run, simulate
from ffgym.simulation.sensors import Sensor


@dataclass(frozen=True, kw_only=True, eq=False)
class Rig:
    """Machine under its controller, which runs motions. The machine may be hidden; its controller is known."""

    arm: RigidArm
    """Rigid dynamics of the robot that the controller was made for."""
    machine: Machine | None = None
    """Simulated machine; None is the controller's robot itself."""
    options: ModelOptions | None = None
    """Parts of the physics to leave out."""
    sensors: Sequence[Sensor] = ()
    """Sensors; without any, recordings hold the exact state."""
    name: str = "nominal"
    """Name in tables."""

    def __post_init__(self) -> None:
        check_class("arm", self.arm, RigidArm, "RigidArm(robot) makes one of a description")

    @property
    def robot(self) -> RobotDescription:
        """Robot as the controller knows it."""
        return self.arm.robot

    @property
    def fingerprint(self) -> str:
        """Fingerprint of the physics, which tells if two are the same and no more."""
        return Machine.of(self.machine or self.robot).physics(self.options or ModelOptions(looks=False))

    def run(
        self,
        runs: Sequence[Run],
        *,
        seed: int | Sequence[np.random.Generator] = 0,
        started: Sequence[float] | None = None,
        machines: Sequence[Machine | None] | None = None,
        record_dt: float = RECORD_DT,
        n_threads: int = 0,
        progress: Progress | None = None,
    ) -> list[Recording]:
        """Run motions with their feed-forward laws; a recording does not depend on the others.

        Args:
            runs: whatever model of the machine their references were made with, its controller runs them.
            seed: of the sensors' noise, or the randomness of each run.
            started: when each motion begins, since the time of the day that the machine is set up for [s]; None is
                that time.
            machines: machine of each motion, None in it for the rig's own; None is the rig's own for all.
            record_dt: sample time of the recordings [s].
            n_threads: threads of the engine, 0 for all cores.
            progress: called now and then with the simulated seconds done and their total.

        Raises:
            FFGymError: if there is nothing to run, a run does not fit, or a simulation becomes unstable.
        """
        if started is not None and len(started) != len(runs):
            raise FFGymError(f"There are {len(started)} times at which motions begin, for {len(runs)} runs.")
        if machines is not None and len(machines) != len(runs):
            raise FFGymError(f"There are {len(machines)} machines for {len(runs)} runs; give one for each, or None.")
        own, robot = self.machine or Machine.of(self.robot), self.robot
        each = [own if machine is None else machine for machine in machines or [None] * len(runs)]
        return simulate(
            # a reference names the model that it was made with, which need not be that of this controller
            [
                r if r.reference.robot is robot else replace(r, reference=replace(r.reference, robot=robot))
                for r in runs
            ],
            arm=self.arm,
            machine=each if started is None else [m.later(since) for m, since in zip(each, started, strict=True)],
            options=self.options,
            sensors=self.sensors,
            seed=seed,
            record_dt=record_dt,
            n_threads=n_threads,
            progress=progress,
        )


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedRig(Rig):
    """Rig with a machine that is known."""
