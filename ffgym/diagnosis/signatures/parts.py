"""What is changed in each channel and component of a log, by effects in any place."""

from collections.abc import Mapping, Sequence

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.replay import Replay, predicted, replay
from ffgym.diagnosis.replay.clocks import late
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.signatures.bending import Change
from ffgym.effects import Effect
from ffgym.simulation.plant import Machine

Parts = Mapping[tuple[Channel, int], Array]
"""By channel and component, shape (R, M) each; what is not there does not change."""


def shown(run: Replay, change: Change) -> Parts:
    """What a change shows in each channel that the log has."""
    parts: dict[tuple[Channel, int], Array] = {}
    for j in range(run.robot.n_joints):
        parts["torque", j] = change.torque[..., j]
        if run.log.link is not None:
            parts["link", j] = change.link[..., j]
    if run.log.tool is not None:
        tool = np.matmul(run.tool_jacobian, change.link[..., None])[..., 0]
        parts |= {("tool", k): tool[..., k] for k in range(3)}
    return parts


def clock_parts(run: Replay, gone: Sequence[Effect], come: Sequence[Effect]) -> Parts:
    """Change of the channels whose clocks are exchanged."""
    found: dict[tuple[Channel, int], Array] = {}
    of_channel: list[tuple[Channel, Array]] = [("torque", run.torque)]
    if run.log.link is not None:
        of_channel.append(("link", run.link_q))
    for channel, values in of_channel:
        before, after = late(values, channel, gone, run.log), late(values, channel, come, run.log)
        if before is not after:
            rows = run.log.sampling(after - before)
            found |= {(channel, j): rows[..., j] for j in range(run.robot.n_joints)}
    return found


def replayed_parts(run: Replay, machine: Machine) -> Parts:
    """Change of all channels if the log is replayed on another machine: of what has joints of its own."""
    before, after = predicted(run), predicted(replay(run.log, machine, run))
    return {(c, k): after[c][..., k] - rows[..., k] for c, rows in before.items() for k in range(rows.shape[2])}
