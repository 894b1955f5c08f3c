"""Columns of one kind, joint by joint."""

from collections.abc import Iterator

from ffgym.core.types import Array
from ffgym.logs.quality.log import Log

TORQUES = ("motor.effort", "command.effort", "feedback.effort", "feedback.integral")
"""Families of torques, which may be cut at their extremes."""


def joint_columns(log: Log, families: tuple[str, ...]) -> Iterator[tuple[str, int, str, Array]]:
    """Family, joint number, name and values of all per-joint columns of `families` that are present."""
    for family in families:
        if log.recording.has(family):
            for name, values in log.columns(family).items():
                yield family, log.joints.index(name.removeprefix(f"{family}.")), name, values
