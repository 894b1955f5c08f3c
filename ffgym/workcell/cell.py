"""Workcell: a machine whose true parameters are hidden, the model that its controller has of it, and its sensors."""

from dataclasses import dataclass, field, replace
from typing import NoReturn, Self, final

from ffgym.core.errors import FFGymError
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation import Rig, Sensor
from ffgym.simulation.plant import Machine

_HIDDEN = ("friction.effort.", "arm_friction.effort.", "link.position.", "link.velocity.")
"""Columns that no sensor of the workcell measures."""


@final
@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class SealedMachine(Machine):
    """Machine whose parameters are hidden, in its text as well as in its recordings."""

    label: str
    """Name in messages and printed text."""

    def __repr__(self) -> str:
        return f"SealedMachine({self.label!r})"

    @property
    def truth(self) -> None:
        """None: the true robot is hidden."""
        return None

    def with_robot(self, robot: RobotDescription) -> NoReturn:
        """Refuse to change numbers of a workcell.

        Raises:
            FFGymError: always.
        """
        raise FFGymError(
            f"Workcell {self.label!r} has fixed parameters, which cannot be drawn anew: leave out the randomization, "
            f"or take another workcell, by its seed."
        )

    def seen(self, recording: Recording) -> Recording:
        """Return the recording as sensors see it, without columns that no sensor of the workcell measures."""
        seen = super().seen(recording)
        columns = {name: values for name, values in seen.columns.items() if not name.startswith(_HIDDEN)}
        return seen.derive(columns)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Workcell(Rig):
    """Stand-in for a real robot in a hall, with its sensors: motions go in, recordings come out."""

    name: str
    title: str
    """Purpose, in a few words."""
    controller: str
    """Name of the nominal robot of its controller, whose arm is `arm`."""
    arm: RigidArm = field(repr=False)
    """Nominal arm, with the friction of its commissioning: the knowledge of its controller and of all methods."""
    machine: SealedMachine = field(repr=False)
    """Machine with its hidden effects."""
    sensors: tuple[Sensor, ...] = field(repr=False)
    """Sensors that make the recordings."""

    def at(self, running_since: float) -> Self:
        """Return the workcell on the same day, when it has run for so long [s]."""
        return replace(self, machine=self.machine.at(running_since))
