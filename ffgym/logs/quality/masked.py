"""Checks of the mask: how much of a log is left to conclude from."""

from collections.abc import Iterator

from ffgym.logs.quality.check import Check, Seen
from ffgym.logs.quality.log import Log


def _masked(log: Log) -> Iterator[Seen]:
    shares = 1.0 - log.recording.valid.mean(axis=0)
    for joint, share in zip(log.joints, shares.tolist(), strict=True):
        message = (
            f"valid.{joint}: {share:.0%} of the rows do not count, must be less than 20 %. See what conditioning left "
            "out, and record that again."
        )
        yield Seen(value=share, message=message, columns=(f"valid.{joint}",), joint=joint)


def _all_masked(log: Log) -> Iterator[Seen]:
    share = 1.0 - float(log.recording.valid.any(axis=1).mean())
    message = (
        f"valid: {share:.0%} of the rows count for no joint, must be less than 80 %. Nearly nothing is left to "
        "conclude from; record again."
    )
    yield Seen(value=share, message=message, columns=tuple(f"valid.{joint}" for joint in log.joints))


MASKED = (
    Check(
        name="masked",
        figure="Share of rows that do not count for a joint",
        unit="1",
        flag=0.2,
        why="a fifth that was left out is worth knowing; the other joints, and the rest, are judged",
        judge=_masked,
    ),
    Check(
        name="nothing_left",
        figure="Share of rows that count for no joint",
        unit="1",
        flag=0.5,
        refuse=0.8,
        why="what can be left out is; where that is nearly all, nothing can be concluded",
        judge=_all_masked,
    ),
)
"""Checks of what is left out."""
