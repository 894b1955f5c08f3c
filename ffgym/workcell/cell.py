"""A workcell: a machine whose truth is shut away, the model its controller has of it, and its sensors."""

from dataclasses import dataclass, field, replace
from typing import NoReturn, Self, final

from ffgym.core.errors import FFGymError
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation import Rig, Sensor
from ffgym.simulation.plant import Machine

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

    def at(self, running_since: float) -> Self:
        """The same day, when it has run for so long [s]."""
        return replace(self, machine=self.machine.at(running_since))
