"""What a log is to be used for, and what it must have for that."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import final

import numpy as np

from ffgym.core.errors import check_choice
from ffgym.logs.quality.check import NotJudgedError
from ffgym.logs.quality.coverage import FIGURES, figures
from ffgym.logs.quality.finding import Finding
from ffgym.logs.quality.log import Log


@final
@dataclass(frozen=True, kw_only=True)
class Need:
    """A use of a log."""

    columns: tuple[str, ...] = ()
    """Families that it takes."""
    torque: bool = False
    """Whether the header must say what the torque is."""
    least: Mapping[str, float] = field(default_factory=dict)
    """Figures of coverage that at least one joint must reach, by name."""
    sound: tuple[str, ...] = ()
    """Checks that must not even be flagged."""
    why: str


_FRICTION = {"reversals": 2.0, "both_ways": 0.1}

NEEDS: Mapping[str, Need] = MappingProxyType(
    {
        "position": Need(columns=("motor.position",), why="everything else hangs on it"),
        "torque": Need(columns=("motor.effort",), torque=True, why="torque of unknown meaning is not guessed"),
        "reference": Need(columns=("reference.position",), why="tracking errors are against the set-point"),
        "tracker": Need(columns=("tcp.position",), why="only the tool shows transmission errors"),
        "temperature": Need(
            columns=("temperature",), least={"temperature_span": 5.0}, why="viscous friction halves over some 20 K"
        ),
        "friction": Need(
            columns=("motor.position", "motor.effort"),
            torque=True,
            least={**_FRICTION, "speed_ratio": 4.0},
            why="friction is what differs between both ways; Coulomb and viscous parts are told apart by speeds",
        ),
        "presliding": Need(
            columns=("motor.position", "motor.effort"),
            torque=True,
            least={**_FRICTION, "presliding_rows": 10.0},
            why="bristles are seen while they bend, before a joint slides",
        ),
        "dwell": Need(
            columns=("motor.position", "motor.effort"),
            torque=True,
            least={"longest_rest": 1.0},
            why="a breakaway torque grows with the time at rest, over 0.1 to 10 s",
        ),
        "load": Need(
            columns=("motor.position", "motor.effort"),
            torque=True,
            least={"load_span": 0.05},
            why="gravity and load-dependent friction need a load that changes by some percent of the peak torque",
        ),
        "diagnosis": Need(
            columns=("motor.position", "motor.effort"),
            torque=True,
            sound=(
                *("clock_drift", "coarse", "encoder_steps", "torque_lag_apart"),
                *("tracker_scale", "tracker_motion", "tracker_frame", "tracker_lag"),
            ),
            why="what is coarser than its noise, or of another frame or time would be taken for a fault of the machine",
        ),
    }
)
"""Uses of a log by name."""


def need_findings(log: Log, needs: Iterable[str], others: Sequence[Finding]) -> tuple[Finding, ...]:
    """What a log lacks for its uses: refused if no joint serves, flagged for joints that do not.

    Args:
        log: what is judged.
        needs: names of uses.
        others: what checks found, of which some uses bear less.

    Raises:
        FFGymError: if a use is unknown.
    """
    found: list[Finding] = []
    for name in needs:
        need = NEEDS[check_choice("need", name, list(NEEDS))]
        found += _columns(log, name, need) or _flaws(name, need, others) or _coverage(log, name, need) or [_met(name)]
    return tuple(found)


def _met(name: str) -> Finding:
    return Finding(check=f"need_{name}", verdict="ok", message=f"The log has what {name} needs.")


def _columns(log: Log, name: str, need: Need) -> list[Finding]:
    absent = [family for family in need.columns if not log.recording.has(family)]
    if absent:
        return [_refused(name, f"{', '.join(absent)} is missing, {name} needs it ({need.why}). Log it.", tuple(absent))]
    if need.torque and log.recording.header.torque_semantics == "unspecified":
        text = (
            f"header torque_semantics is 'unspecified', {name} needs to know it ({need.why}). Say what the torque is."
        )
        return [_refused(name, text, ("motor.effort",))]
    return []


def _flaws(name: str, need: Need, others: Sequence[Finding]) -> list[Finding]:
    """What the use does not bear, although others do."""
    flagged = [finding for finding in others if finding.verdict == "flagged" and finding.check in need.sound]
    return [_refused(name, f"For {name}: {finding.message}", finding.columns) for finding in flagged]


def _refused(name: str, message: str, columns: tuple[str, ...] = ()) -> Finding:
    return Finding(check=f"need_{name}", verdict="refused", message=message, columns=columns)


def _coverage(log: Log, name: str, need: Need) -> list[Finding]:
    short = np.zeros(len(log.joints), dtype=np.bool_)
    texts = []
    for figure, least in need.least.items():
        compute: Callable[[Log, int], float] = FIGURES[figure][0]
        try:
            values = figures(log, compute)
        except NotJudgedError as reason:
            return [_refused(name, f"{figure} is not known: {reason}; {name} needs it ({need.why}).")]
        short |= values < least
        shown = ", ".join(f"{joint} {value:.3g}" for joint, value in zip(log.joints, values, strict=True))
        texts.append(f"{figure} is {shown}, must be {least:g} at least")
    if not short.any():
        return []
    joints = [joint for joint, lacks in zip(log.joints, short, strict=True) if lacks]
    message = (
        f"{'; '.join(texts)}: joints {', '.join(joints)} do not serve for {name} ({need.why}). Record another motion."
    )
    if short.all():
        return [_refused(name, message)]
    return [Finding(check=f"need_{name}", verdict="flagged", message=message, joint=joint) for joint in joints]
