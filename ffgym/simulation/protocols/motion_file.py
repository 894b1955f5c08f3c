"""A motion of one's own as a protocol."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar, final

from ffgym.core.errors import FFGymError, check_whole
from ffgym.paths.motions import load_motion
from ffgym.paths.motions.part import entry
from ffgym.simulation.protocols.protocol import Protocol, Scheduled
from ffgym.simulation.protocols.stage import Stage

MOST_REPEATS = 1000
"""Most repeats of a motion; more are surely a slip."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class MotionFile(Protocol):
    """A built-in motion, or one from a motion file, a table or a RAPID program."""

    name: ClassVar[str] = "motion"
    purpose: ClassVar[str] = "any motion of one's own"

    file: str | Path = entry("built-in name, or a file: .toml, .csv, .mod")
    procedure: str | None = entry("of a RAPID program; absent is main, or the only one", default=None)
    repeats: int = entry("how often", default=1)

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.file, str | Path):
            raise FFGymError(f"motion = {self.file!r} must be the name of a motion or a file.")
        if not isinstance(self.procedure, str | None):
            raise FFGymError(f"procedure = {self.procedure!r} must be the name of a procedure.")

    def motions(self, stage: Stage) -> list[Scheduled]:
        """The motion, as often as asked for."""
        repeats = check_whole("repeats", self.repeats, low=1, high=MOST_REPEATS)
        reference = load_motion(stage.arm, self.file, entry=self.procedure).reference
        if reference.robot is not stage.robot:
            raise FFGymError(
                f"{self.file} brings its own tool, which the other motions do not have. Give the tool to the robot's "
                f"description, and leave it out of the program."
            )
        if repeats == 1:
            return self.paused([reference])
        return self.paused([replace(reference, name=f"{reference.name}.{i}") for i in range(1, repeats + 1)])
