"""A workcell: a machine whose truth is shut away, the model its controller has of it, and its sensors."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NoReturn, Self, final

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.recordings import Recording
from ffgym.robot import ModelOptions, RigidArm, RobotDescription
from ffgym.simulation import RECORD_DT, Rig, Run, Sensor, SimulatedRig
from ffgym.simulation.plant import Machine
from ffgym.simulation.run import Progress

_HIDDEN = ("friction.effort.", "link.position.", "link.velocity.")
"""Columns that no sensor of the workcell measures."""


@final
@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class SealedMachine(Machine):
    """A machine that tells nobody what it is: neither printed nor in what it records."""

    label: str
    """What to call it."""

    def __repr__(self) -> str:
        return f"SealedMachine({self.label!r})"

    @property
    def truth(self) -> None:
        """See base class."""
        return None

    def with_robot(self, robot: RobotDescription) -> NoReturn:
        """A workcell has no other numbers.

        Raises:
            FFGymError: always.
        """
        raise FFGymError(
            f"Workcell {self.label!r} is what it is, and nothing of it is drawn: leave out the randomization, or take "
            f"another workcell, by its seed."
        )

    def seen(self, recording: Recording) -> Recording:
        """See base class; what only a simulation knows is left out."""
        seen = super().seen(recording)
        columns = {name: values for name, values in seen.columns.items() if not name.startswith(_HIDDEN)}
        return Recording(columns=columns, header=seen.header)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Workcell(Rig):
    """What stands for a real robot in a hall, with its sensors; motions in, recordings out."""

    name: str
    title: str
    """What it is for."""
    arm: RigidArm = field(repr=False)
    """What its controller, and everyone else, knows of it: the nominal arm with the friction of its commissioning."""
    machine: SealedMachine = field(repr=False)
    """What it is."""
    sensors: tuple[Sensor, ...] = field(repr=False)
    """What measures."""

    @property
    def fingerprint(self) -> str:
        """See base class."""
        return self.machine.physics(ModelOptions(looks=False))

    def at(self, running_since: float) -> Self:
        """The same day, when it has run for so long [s]."""
        return replace(self, machine=self.machine.at(running_since))

    def run(
        self,
        runs: Sequence[Run],
        *,
        seed: int | Sequence[np.random.Generator] = 0,
        started: Sequence[float] | None = None,
        record_dt: float = RECORD_DT,
        n_threads: int = 0,
        progress: Progress | None = None,
    ) -> list[Recording]:
        """See base class."""
        rig = SimulatedRig(arm=self.arm, machine=self.machine, sensors=self.sensors, name=self.name)
        return rig.run(runs, seed=seed, started=started, record_dt=record_dt, n_threads=n_threads, progress=progress)
