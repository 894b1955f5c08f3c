"""Share of the misfit that causes explain on motions that were left out of their fit."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from ffgym.diagnosis.result import Level

_MOST_NAMED = 3
"""Joints that are named one by one at most."""

_WORDS: Mapping[str, str] = {
    "torque": "the torque",
    "tool": "the tool position",
    "link": "the link position",
    "servo": "the torque of the servo",
}
"""Names of channels in a sentence."""


@dataclass(frozen=True, kw_only=True)
class HeldOutShare:
    """Share of the energy above the noise that the extended model explains, with its channel."""

    share: float
    """Fraction from 0 to 1."""
    channel: str
    """Channel that the share is of; of several, the one with most energy above the noise."""
    place: str
    """Channels and joints that the share is of, such as 'the torque of j2'."""


def compute_held_out_share(levels: Sequence[Level], joints: Iterable[str]) -> HeldOutShare | None:
    """Compute the share of the misfit at some joints that all causes together explain on motions that were left out.

    One minus the energy above the noise that the extended model leaves over that of the nominal model, within 0 and 1,
    at each joint in the channel in which the causes explain most, as others may show the misfit of other joints alone.

    Args:
        levels: of a diagnosis.
        joints: of causes; an empty name is the machine as a whole.

    Returns:
        None where no extended model was written, so that nothing was left out, or where there is no misfit.
    """
    judged = [level for level in levels if level.noise_floor > 0]
    if all(level.before == level.after for level in judged):
        return None
    # each component counts once, however many causes act on it
    chosen: dict[tuple[str, str], Level] = {}
    for joint in joints:
        chosen |= {(level.channel, level.component): level for level in _choose_channel(judged, joint)}
    found = list(chosen.values())
    before, after = _sum_excess(found, "before"), _sum_excess(found, "after")
    if before <= 0:
        return None
    loudest = max(found, key=lambda level: _sum_excess([level], "before"))
    return HeldOutShare(
        share=min(max(1.0 - after / before, 0.0), 1.0), channel=loudest.channel, place=name_place(found)
    )


def name_place(levels: Sequence[Level]) -> str:
    """Name the channels of levels and their joints, such as 'the torque of j2 and j4, and the tool position'."""
    channels: dict[str, list[str]] = {}
    for level in levels:
        channels.setdefault(level.channel, []).append(level.component)
    places = [
        _WORDS[channel] + ("" if channel == "tool" or len(own) > _MOST_NAMED else f" of {' and '.join(own)}")
        for channel, own in channels.items()
    ]
    return ", and ".join(places)


def find_loudest(levels: Sequence[Level]) -> Level | None:
    """Find the level at which the extended model leaves most energy above the noise; None if it leaves none."""
    judged = [level for level in levels if level.after > level.noise_floor > 0]
    return max(judged, key=lambda level: _sum_excess([level], "after"), default=None)


def _choose_channel(levels: Sequence[Level], joint: str) -> Sequence[Level]:
    """Choose the levels at a joint in the channel in which most energy per component is explained, or else is left."""
    channels: dict[str, list[Level]] = {}
    for level in levels:
        channels.setdefault(level.channel, []).append(level)
    # a channel that has no component of a joint, as the tool, shows it in all its components
    candidates = [
        [level for level in own if level.component == joint] or (own if channel == "tool" or not joint else [])
        for channel, own in channels.items()
    ]

    def prefer(own: Sequence[Level]) -> tuple[float, float]:
        before, after = _sum_excess(own, "before"), _sum_excess(own, "after")
        return max(before - after, 0.0) / len(own), before / len(own)

    return max(filter(None, candidates), key=prefer, default=())


def _sum_excess(levels: Sequence[Level], model: str) -> float:
    """Sum the energy that a model, 'before' or 'after', leaves above the noise, in units of the noise."""
    return sum(max((getattr(level, model) / level.noise_floor) ** 2 - 1.0, 0.0) for level in levels)
