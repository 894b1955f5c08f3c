"""Swing of an arm when its log begins: a replay lets springs rest there, and nobody logs how they moved before.

A log that begins right after a move, or while a brake lets go, has the arm swing on: freely, at its own frequencies and
damping. Where the springs' free motions after the first sample leave clearly less of a motion's residual, what they
take away counts as noise.
"""

from collections.abc import Mapping

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.fit.fit import evaluated
from ffgym.diagnosis.fit.leftover import without_calibration
from ffgym.diagnosis.fit.setting import Setting
from ffgym.diagnosis.replay import Replay
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.signatures.bending import changes
from ffgym.diagnosis.signatures.parts import Parts, shown
from ffgym.diagnosis.signatures.push import Push

_CLEAR = 0.7
"""Energy of a motion's residual that is left without its swing, as a share of it, at most, if there was one; chosen
on two drawn machines: motions that began with a swing left 0.2 to 0.6, those with other faults 0.8 and more."""

_BEND = 1e-4
"""Deflection of which free motions are computed [rad]; chosen: any would do, they are linear."""

_INDEPENDENT = 1e-8
"""Relative size of a singular value below which a free motion is that of others."""


def first_swing(setting: Setting) -> dict[Channel, Array]:
    """Fit free motions of springs to the residual of a log, (R, M, C) by channel; empty if joints are rigid.

    Args:
        setting: of the log, with the nominal machine's replay.
    """
    run = setting.like
    if run is None or run.robot.drive.is_rigid.all():
        return {}
    rest = without_calibration(setting, evaluated(setting, ()))
    free = _free_motions(run)
    keys = [key for key in free[0] if key in setting.weights]
    found = {channel: np.zeros_like(rest[channel]) for channel in dict.fromkeys(channel for channel, _ in keys)}
    for m in range(len(setting.log.recordings)):
        weights = {key: np.broadcast_to(setting.weights[key], free[0][key].shape)[:, m] for key in keys}
        columns = np.stack([_stacked({k: one[k][:, m] for k in keys}, weights) for one in free], axis=1)
        target = _stacked({(channel, c): rest[channel][:, m, c] for channel, c in keys}, weights)
        sizes = np.linalg.lstsq(columns, target, rcond=_INDEPENDENT)[0]
        if np.sum((target - columns @ sizes) ** 2) > _CLEAR * np.sum(target**2):
            continue
        for channel, c in keys:
            found[channel][:, m, c] = sum(size * one[channel, c][:, m] for size, one in zip(sizes, free, strict=True))
    return found


def _free_motions(run: Replay) -> list[Parts]:
    """What arms show that are let go or knocked at the first sample: one of each for every elastic joint."""
    pushes = []
    for j in run.springs.elastic.tolist():
        for sample in (0, 1):  # a load that is gone after the first sample, and one that comes and goes after it
            load = np.zeros_like(run.log.q)
            load[sample, :, j] = run.springs.stiffness[j] * _BEND
            pushes.append(Push(links=load))
    return [shown(run, change) for change in changes(run, pushes)]


def _stacked(rows: Mapping[tuple[Channel, int], Array], weights: Mapping[tuple[Channel, int], Array]) -> Array:
    """Weighted rows (R,) of all components, one after the other."""
    return np.concatenate([rows[key] * weights[key] for key in rows])
