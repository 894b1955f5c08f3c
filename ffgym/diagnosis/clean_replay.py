"""Noise-free recordings of the nominal machine with motors that move as measured, in continuous time.

For logs without set-points, or of another controller than the documented one. The motion is that of the log without the
noise of its readings, and the machine is replayed along it in steps so small that they do not matter, those of friction
the smallest. A replay of what is recorded so, sample by sample, differs from it by what the sampled replay does wrong:
that is its bias.
"""

from dataclasses import replace

import numpy as np
import scipy

from ffgym.core.measures import interpolate
from ffgym.core.types import Array
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.replay import Replay, predict_feedback, replay
from ffgym.diagnosis.replay.states import Bristles, friction_on_motors
from ffgym.diagnosis.sampling import without_trembling
from ffgym.diagnosis.settings import settings
from ffgym.logs.preparation import LowPass
from ffgym.recordings import Recording

_TOGETHER = 1_000_000
"""Most fine steps of all motions together that are replayed at once; chosen: some 2 GB for six axes that bend."""


def replay_finely(log: Log, run: Replay, *, smooth: bool = False) -> list[Recording]:
    """Replay the nominal machine in fine steps: one recording for each motion of a log, from its replay `run`.

    A `smooth` motion has nothing above the usual band of what is compared: noise and vibration at the edge of a wide
    band would be bias. Else the low-pass of the motion is undone.
    """
    limits = settings().replay
    parts = max(1, int(np.ceil(log.dt / limits.friction_step - 1e-9)))
    n_motions = len(log.recordings)
    if n_motions > 1 and parts * len(log.q) * n_motions > _TOGETHER:
        return [one for i in range(n_motions) for one in replay_finely(log.motion(i), run, smooth=smooth)]
    # steps in a sample that are short enough for links and springs, of which each has some of all `parts`
    few = min(
        n
        for n in range(1, parts + 1)
        if parts % n == 0 and (n == parts or log.dt / n <= limits.link_step * (1 + 1e-09))
    )
    # friction in the finest steps, links and springs in coarser ones
    if few == parts or run.machine.resolver_effects:  # friction slips as motors truly move, which replays tell
        fine, few = replay(_refine(log, parts, smooth), run.machine, exact=True), parts
    else:
        finest = _refine(log, parts, smooth)
        friction, every = friction_on_motors(run.robot, finest.slip_dq, finest.dq, finest.dt), parts // few
        bristles = Bristles(torque=friction.torque[::every], whole=friction.whole[::every], sign=friction.sign[::every])
        fine = replay(_refine(log, few, smooth), run.machine, bristles=bristles, exact=True)
    return [_record(log, run, fine, few, i) for i in range(n_motions)]


def _refine(log: Log, every: int, smooth: bool) -> Log:
    """Sample the motion of a log without its noise `every` times as finely, with temperatures and set-points."""
    dt, still, low_pass = log.dt, without_trembling(log.q, log.trembling), log.sampling.motion_filter
    # undo the low-pass of each motion, or smooth it
    q = np.empty_like(log.q)
    for i, n in enumerate(log.lengths):
        measured = still[:n, i]
        if smooth:
            found = LowPass(cutoff=min(low_pass.cutoff, settings().sampling.cutoff))(measured, dt)
        else:
            # angles that the low-pass would make into these (van Cittert 1931, Z. Phys. 69): a motion that was smoothed
            # twice turns back later than the measured one, and bias where friction turns would be told too small
            found = measured
            for _ in range(settings().replay.sharpenings):
                found = found + measured - low_pass(found, dt)
        q[:, i] = np.pad(found, ((0, len(log.q) - n), (0, 0)), mode="edge")
    t: Array = dt / every * np.arange((len(q) - 1) * every + 1, dtype=np.float64)
    q, dq, ddq = _differentiate(q, log, t)
    # recordings say how long each motion is
    clocks = []
    for recording, n in zip(log.recordings, log.lengths, strict=True):
        times = dt / every * np.arange((n - 1) * every + 1, dtype=np.float64)
        clocks.append(Recording(columns={"timestamp": times}, header=replace(recording.header, phases=())))
    reference = log.reference
    return replace(
        log,
        recordings=tuple(clocks),
        sampling=replace(log.sampling, dt=dt / every, n_samples=len(t)),
        known=np.ones((len(t), len(log.recordings)), dtype=np.bool_),
        q=q,
        dq=dq,
        ddq=ddq,
        trembling=np.zeros_like(log.trembling),
        slip_dq=dq,
        torque=np.zeros_like(q),
        tool=None,
        link=None,
        feedback=None if log.feedback is None else interpolate(t, log.t, log.feedback),
        reference=None
        if reference is None
        else (_differentiate(reference[0], log, t)[0], interpolate(t, log.t, reference[1])),
        temperature=None if log.temperature is None else interpolate(t, log.t, log.temperature),
    )


def _differentiate(q: Array, log: Log, t: Array) -> tuple[Array, Array, Array]:
    """Compute angle, speed and acceleration at times `t` of a spline through samples (T, M, N), at rest at its end."""
    shape = (len(t), *q.shape[1:])
    angle, speed, change = np.empty(shape), np.zeros(shape), np.zeros(shape)
    for i, n in enumerate(log.lengths):
        curve = scipy.interpolate.CubicSpline(log.t[:n], q[:n, i])
        within = int(np.searchsorted(t, log.t[n - 1], side="right"))
        angle[:within, i] = curve(t[:within])
        angle[within:, i] = q[n - 1, i]
        speed[:within, i], change[:within, i] = curve(t[:within], 1), curve(t[:within], 2)
    return angle, speed, change


def _record(log: Log, run: Replay, fine: Replay, every: int, i: int) -> Recording:
    """Record one motion at the samples of the log, motor side."""
    recording, n = log.recordings[i], log.lengths[i]
    rows = slice(0, (n - 1) * every + 1, every)
    # columns that the log has, at its samples
    link = fine.link_q[rows, i]
    families = {
        "motor.position": log.robot.drive.motor_angle(fine.read.q[rows, i]),
        "motor.effort": fine.torque[rows, i],
        "link.position": link,
    }
    if log.reference is not None:
        families |= {"reference.position": log.reference[0][:n, i], "reference.velocity": log.reference[1][:n, i]}
        if log.feedback is not None:
            families["feedback.effort"] = predict_feedback(fine.read, fine.robot)[rows, i]
    columns = {"timestamp": recording.t}
    columns |= {
        f"{family}.{joint}": x[:, j] for family, x in families.items() for j, joint in enumerate(log.robot.joints)
    }
    # TCP, moved with base and links where they give way
    if log.tool is not None:
        position = run.arm.tcp_position(link)
        if fine.sway is not None and fine.sway.tool is not None:
            position = position + fine.sway.tool[rows, i]
        columns |= {f"tcp.position.{axis}": position[:, k] for k, axis in enumerate("xyz")}
    # sensor faults of the model, as they are part of the record
    header = replace(recording.header, position_side="motor", torque_semantics="motor_side", hold="sampled", phases=())
    seen = run.machine.seen(Recording(columns=columns, header=header))
    hidden = ("link.",) if log.link is None else ()  # trackers that err need it, but the log has none
    columns = {name: values for name, values in seen.columns.items() if not name.startswith(hidden)}
    return seen.derive(columns, header)
