"""Motions of the commands, and what is told about them."""

from typing import Any, Protocol

from ffgym.core.errors import FFGymError
from ffgym.paths.motions import Motion, load_motion
from ffgym.robot import RigidArm

MOST_SHOWN = 30
"""Most events on a terminal; all of them are in the file of numbers."""


class ProgramOptions(Protocol):
    """Options of a command that runs a motion, which may be a RAPID program."""

    @property
    def entry(self) -> str | None:
        """Procedure of a program."""

    @property
    def inputs(self) -> tuple[str, ...]:
        """Values of inputs of a program, NAME=VALUE each."""

    @property
    def cycles(self) -> int:
        """Passes through a loop of a program that never ends."""


def read_motion(config: ProgramOptions, arm: RigidArm, path: str) -> Motion:
    """Read the motion of a command, with the values that a program is run with."""
    return load_motion(arm, path, entry=config.entry, inputs=_inputs(config.inputs), cycles=config.cycles)


def _inputs(given: tuple[str, ...]) -> dict[str, float]:
    """Values of inputs by name, from NAME=VALUE."""
    values: dict[str, float] = {}
    for word in given:
        name, equals, number = word.partition("=")
        try:
            values[name] = float(number)
        except ValueError:
            equals = ""
        if not (name and equals):
            raise FFGymError(f"--inputs {word} must be NAME=VALUE with a number, e.g. diPartOk=1.")
    return values


def tell_events(motion: Motion) -> list[str]:
    """Tell what else happens on a motion, a line each."""
    lines = [f"event: {event}" for event in motion.events[:MOST_SHOWN]]
    left = len(motion.events) - len(lines)
    return [*lines, f"... and {left} more events (--json)"] if left else lines


def list_events(motion: Motion) -> list[dict[str, Any]]:
    """List what else happens on a motion, as JSON values."""
    return [
        {
            "t": event.t,
            "position": None if event.position is None else event.position.tolist(),
            "text": event.text,
            "where": event.where,
        }
        for event in motion.events
    ]
