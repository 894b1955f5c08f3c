"""Measurement protocols: named lists of motions that serve one purpose, for any robot."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import Field, dataclass, fields, replace
from typing import Any, ClassVar, Self, final

from ffgym.core.errors import FFGymError, check_number
from ffgym.paths import Reference
from ffgym.paths.motions.part import entry
from ffgym.robot import RigidArm
from ffgym.simulation.protocols.stage import ProtocolStage, check_torque

PAUSE = 5.0
"""Default time before a motion [s]; chosen: enough for an arm to reach the start of the motion."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Scheduled:
    """Motion of a protocol, with its pause."""

    reference: Reference
    """Motion; its name is unique within the protocol."""
    pause: float
    """Time between the end of the motion before and its start [s]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Protocol(ABC):
    """Motions that a machine makes for one purpose, each recorded on its own."""

    name: ClassVar[str]
    """Name on command lines and in files."""
    purpose: ClassVar[str]
    """Purpose of its recordings, in a few words."""

    pause: float = entry("time between motions, in which the arm goes where the next one begins", "s", default=PAUSE)

    def __post_init__(self) -> None:
        check_number("pause", self.pause, unit="s", low=0.0)

    def schedule(self, arm: RigidArm) -> list[Scheduled]:
        """Make motions for a robot, in order, within its joint ranges, speeds and torques.

        Raises:
            FFGymError: if the robot cannot make one of them; the message begins with the protocol.
        """
        try:
            motions = self.motions(ProtocolStage(arm=arm))
            for motion in motions:
                check_torque(arm, motion.reference)
        except FFGymError as error:
            raise FFGymError(f"Protocol {self.name} on {arm.robot.name!r}: {error}") from error
        return [replace(m, reference=replace(m.reference, name=f"{self.name}.{m.reference.name}")) for m in motions]

    @abstractmethod
    def motions(self, stage: ProtocolStage) -> list[Scheduled]:
        """Make motions for a robot, with names that differ; their torques are checked by `schedule`."""

    def schedule_all(self, references: Sequence[Reference]) -> list[Scheduled]:
        """Schedule motions with the same pause before each."""
        return [Scheduled(reference=reference, pause=self.pause) for reference in references]

    @classmethod
    def parse(cls, table: Mapping[str, Any]) -> Self:
        """Build a protocol with the settings of a table.

        Raises:
            FFGymError: if a setting is unknown or not valid.
        """
        known = [f.name for f in settings(cls)]
        unknown = sorted(set(table) - set(known))
        if unknown:
            raise FFGymError(f"Unknown settings {', '.join(unknown)}. Protocol {cls.name} has {', '.join(known)}.")
        return cls(**table)


@dataclass(frozen=True, kw_only=True, eq=False)
class JointProtocol(Protocol):
    """Protocol that moves selected joints."""

    joints: Sequence[str] = entry("names of the joints that move; absent is all", default=())

    def __post_init__(self) -> None:
        super().__post_init__()
        check_names("joints", self.joints)


def check_names(what: str, names: Any) -> None:
    """Check that `names` is a list of names that differ."""
    listed = isinstance(names, Sequence) and not isinstance(names, str)
    if not listed or not all(isinstance(name, str) for name in names) or len(set(names)) < len(names):
        raise FFGymError(f"{what} = {names!r} must be a list of names, each of them once.")


def settings(protocol: type[Protocol]) -> tuple[Field[Any], ...]:
    """List settings of a protocol, its own first."""
    shared = {f.name for f in fields(JointProtocol)}
    return tuple(sorted(fields(protocol), key=lambda f: f.name in shared))
