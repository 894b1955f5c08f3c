"""Passes of a program in a log: when the machine went through it, told by its commanded or measured joints.

Names and clocks of logs may be wrong, and logs begin and end as they like; commands of a run are its program but for
the correction, and its joints follow to a fraction of its extent whether the correction is on or off.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy

from ffgym.core.errors import FFGymError
from ffgym.core.measures import interpolate
from ffgym.core.types import Array
from ffgym.deployment.trial.program import TrialProgram
from ffgym.recordings import Recording, clip_phases

ALIKE = 0.3
"""Largest distance of the joints of a log from those of the program, as a share of its own extent (RMS both), that is
still a pass of it. Chosen: circles of 3 mm without compensation leave 0.15, a speed that is 5 % higher 0.42."""
PACE = 0.02
"""Largest share by which a pass may be faster or slower than the program: a clock is off by far less, an override of
speed by more, and errors of 15 % of the extent look like 0.3 % of pace."""
_APART = 0.9
"""Least distance of two passes, in times that the program moves."""
_STEPS = 3
"""Steps of Gauss-Newton; the first is within 1e-4 s."""
_MOST_ROWS = 4000
"""Instants of the program that are compared; more would only cost time."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ProgramPass:
    """One pass of a program in a log."""

    start: float
    """Time at which the program began, on the clock of the log [s]."""
    recording: Recording
    """Measured columns beside the program's set-points and tool path, motor side, on a clock that begins with it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Passes:
    """Passes of a program in a log, in order."""

    found: tuple[ProgramPass, ...]
    paces: tuple[float, ...] = ()
    """Speeds of stretches that follow the program faster or slower, over its own."""
    nearest: float
    """Distance of the best stretch of the log from the program, as a share of the program's extent; infinite for a log
    that is too short."""


def find_passes(program: TrialProgram, log: Recording) -> Passes:
    """Find the passes of a program in a log: by commanded positions where it has some that follow it, else by measured.

    Raises:
        FFGymError: if the log has no measured joint positions, or other joints.
    """
    if not log.has("motor.position"):
        raise FFGymError("The log has no motor.position, by which a run is known. Map the measured joint positions.")
    joints = program.recording.header.joints
    if len(log.header.joints) != len(joints):
        raise FFGymError(
            f"The log has {len(log.header.joints)} joints, the program has {len(joints)}: {', '.join(joints)}."
        )
    tried = [
        _find(program, log, log.header.joint_side(log.joint_array(family)))
        for family in ("reference.position", "motor.position")
        if log.has(family)
    ]
    return next((passes for passes in tried if passes.found), tried[-1])


def _find(program: TrialProgram, log: Recording, joints: Array) -> Passes:
    """Find the passes of a program in joint positions of a log (T, N), behind the gearbox."""
    # program without its rests, which logs may cut short, on a grid that both can fill
    moving = np.flatnonzero(~program.recording.mask(kind="standstill"))
    first, last = program.recording.t[moving[0]], program.recording.t[moving[-1]]
    step = max(program.recording.dt, log.dt, (last - first) / _MOST_ROWS)
    at = np.arange(first, last, step)
    wanted = interpolate(at, program.recording.t, program.joints)
    seen = interpolate(np.arange(log.t[0], log.t[-1], step), log.t, joints)
    if len(seen) < len(wanted) or len(wanted) < 2:
        return Passes(found=(), nearest=np.inf)
    misfit = _slide(wanted, seen)
    starts: list[float] = []
    for row in np.argsort(misfit):
        if misfit[row] > ALIKE:
            break
        begin = float(log.t[0] + row * step - first)
        if all(abs(begin - other) >= _APART * (last - first) for other in starts):
            starts.append(begin)
    refined = sorted(_refine(begin, at, wanted, log.t, joints) for begin in starts)
    found = tuple(
        ProgramPass(start=begin, recording=_cut(program, log, begin))
        for begin, pace in refined
        if abs(pace - 1) <= PACE
    )
    paces = tuple(pace for _, pace in refined if abs(pace - 1) > PACE)
    return Passes(found=found, paces=paces, nearest=float(misfit.min()))


def _slide(wanted: Array, seen: Array) -> Array:
    """Compute the RMS distance of `wanted` (n, N) from every stretch of `seen` (m, N), as a share of its extent."""
    centre = wanted.mean(axis=0)
    wanted, seen = wanted - centre, seen - centre
    n = len(wanted)
    sums = np.concatenate([[0.0], np.cumsum(np.sum(seen**2, axis=1))])
    both = sum(scipy.signal.correlate(seen[:, j], wanted[:, j], "valid", "fft") for j in range(wanted.shape[1]))
    extent = np.sum(wanted**2)
    squares = sums[n:] - sums[:-n] - 2 * both + extent
    return np.asarray(np.sqrt(np.maximum(squares, 0.0) / max(extent, np.finfo(np.float64).tiny)))


def _refine(start: float, at: Array, wanted: Array, t: Array, joints: Array) -> tuple[float, float]:
    """Refine the start of a pass within a sample, and find its pace over the program's: steps of Gauss-Newton."""
    speed, middle, pace = np.gradient(wanted, at, axis=0), float(at.mean()), 1.0
    columns = np.stack([speed.ravel(), (speed * (at - middle)[:, None]).ravel()], axis=1)
    for _ in range(_STEPS):
        seen = interpolate(start + middle + (at - middle) / pace, t, joints)
        (early, faster), *_ = np.linalg.lstsq(columns, (seen - wanted).ravel(), rcond=None)
        start, pace = start - float(early), pace * (1 + float(faster))
    return start, pace


def _cut(program: TrialProgram, log: Recording, start: float) -> Recording:
    """Cut the rows of one pass, with the program's set-points in place of those of the controller."""
    own = program.recording
    rows = (log.t >= start) & (log.t <= start + program.duration)
    t = log.t[rows] - start
    motor = log.header.motor_side(log.joint_array("motor.position"))[rows]
    reference = scipy.interpolate.CubicSpline(own.t, own.joint_array("reference.position"))(t)
    columns = {"timestamp": t}
    for j, joint in enumerate(own.header.joints):
        columns |= {f"motor.position.{joint}": motor[:, j], f"reference.position.{joint}": reference[:, j]}
    if log.has("tcp.position") and own.has("tcp_reference.position"):
        tool, path = log.vector("tcp.position")[rows], program.tool_path(t)
        for k, axis in enumerate("xyz"):
            columns |= {f"tcp.position.{axis}": tool[:, k], f"tcp_reference.position.{axis}": path[:, k]}
    end = float(t[-1] + np.median(np.diff(t)))
    header = replace(own.header, phases=clip_phases(own.header.phases, float(t[0]), end))
    return Recording(columns, header)
