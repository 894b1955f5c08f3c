"""The model as it is written: causes, and the numbers that were fitted beside them.

A fit to a log holds for causes and calibration errors together; with the nominal numbers in their place, a cause that
overlaps one of them would make the model worse. So both are put into one machine, which is replayed, and fitted once
more about where it then is.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.calibration import Calibration
from ffgym.diagnosis.evidence.solve import bounded
from ffgym.diagnosis.evidence.stack import Evidence
from ffgym.diagnosis.fit.fit import Fit, trial_of
from ffgym.diagnosis.fit.hypothesis import Hypothesis, moved
from ffgym.diagnosis.fit.numbers import are_of_the_machine, possible_numbers
from ffgym.diagnosis.fit.setting import HELD, Setting, values_of
from ffgym.diagnosis.fit.tangents import tangents
from ffgym.diagnosis.measured import residual_rows
from ffgym.diagnosis.replay import Replay, predicted
from ffgym.diagnosis.replay.clocks import in_step
from ffgym.diagnosis.residual import Channel
from ffgym.effects import Effect
from ffgym.recordings import Recording
from ffgym.simulation.plant import Machine

_ROUNDS = 2
"""Times that all is fitted and replayed; the second changes what is left by less than a per cent."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Written:
    """A model that can be written to a file."""

    numbers: Machine
    """The nominal machine with the numbers that were fitted beside the causes."""
    hypotheses: tuple[Hypothesis, ...]
    """Causes, with the values that they have beside these numbers."""
    run: Replay
    """Of the machine with both."""
    residual: Mapping[Channel, Array]
    """Measured minus predicted, (R, M, C); nothing is taken off but what the replay itself misses."""

    @property
    def machine(self) -> Machine:
        """The extended model."""
        return self.run.machine


def written(setting: Setting, fit: Fit, calibration: Calibration, train: BoolArray | None = None) -> Written | None:
    """Causes of a fit, and numbers beside them, as one model; None if no machine can be so.

    Args:
        setting: the log.
        fit: of the causes to all of it.
        calibration: how well nominal numbers are known, and how those that were fitted to the logs are fitted anew.
        train: blocks that are fitted to, shape (B,); None is all of them.
    """
    chosen = np.ones(len(setting.blocks), dtype=np.bool_) if train is None else train
    setting = setting.with_bias(_bias_of(setting, fit))
    if calibration.refit is not None:
        return _refitted(setting, fit, calibration, chosen)
    return _by_priors(setting, fit, chosen)


def _bias_of(setting: Setting, fit: Fit) -> Mapping[Channel, Array]:
    """What a fit took off its residual: a fit with causes knows what the replay of their machine misses."""
    missed = residual_rows(setting.log, predicted(fit.run))
    return {channel: missed[channel] - rows for channel, rows in fit.residual.items()}


def _by_priors(setting: Setting, fit: Fit, chosen: BoolArray) -> Written | None:
    """With calibration errors as their priors and the log have them."""
    n, evidence, hypotheses = fit.n_calibration, fit.evidence, fit.hypotheses
    low, high = fit.priors.low, fit.priors.high
    of_machine = are_of_the_machine(setting.doubts)
    sizes, best, least = np.zeros(n), None, np.inf
    for _ in range(_ROUNDS):
        x = _solved(evidence, fit, sizes, low, high, chosen)
        sizes, hypotheses = sizes + x[:n] * of_machine, moved(hypotheses, x[n:])
        sizes[np.abs(sizes) <= HELD] = 0.0
        numbers = possible_numbers(setting, sizes)
        tried = None if numbers is None else _replayed(setting, numbers, hypotheses, fit.run)
        if tried is None:
            break
        columns = tangents(tried.run, tried.numbers, hypotheses)
        evidence = setting.stack.beside(columns).evidence(values_of(tried.residual))
        left = float(evidence.energy[chosen].sum() + sizes @ sizes)
        if left >= least:
            break
        best, least = tried, left
    return best


def _solved(evidence: Evidence, fit: Fit, sizes: Array, low: Array, high: Array, chosen: BoolArray) -> Array:
    """Changes of calibration errors and free numbers where errors of `sizes` are in the model already."""
    n, precision = fit.n_calibration, fit.priors.precision
    there = np.concatenate([sizes, np.zeros(len(precision) - n)])
    pull = evidence.moment[chosen].sum(axis=0)[:, 0] - precision * there
    gram = evidence.gram[chosen].sum(axis=0)
    return bounded(gram, pull, precision, low - there, high - there)


def _refitted(setting: Setting, fit: Fit, calibration: Calibration, chosen: BoolArray) -> Written | None:
    """With the numbers that were fitted to the logs fitted anew, to what the causes leave of the torque."""
    assert calibration.refit is not None
    motions = np.unique(setting.blocks.motion[chosen]).tolist()
    numbers, hypotheses, best = setting.nominal, fit.hypotheses, None
    for last in (False, True):
        tried = _replayed(setting, numbers, hypotheses)
        plain = _replayed(setting, numbers, ())
        if tried is None or plain is None:
            return best
        added = tried.run.torque - plain.run.torque
        effects = tried.machine.effects
        left = [_without_causes(setting, i, effects, added[: setting.log.lengths[i], i]) for i in motions]
        numbers = replace(setting.nominal, robot=calibration.refit(left))
        best = _replayed(setting, numbers, hypotheses)
        if best is None or last or not hypotheses:
            return best
        columns = tangents(best.run, best.numbers, hypotheses)
        evidence = setting.stack.beside(columns).evidence(values_of(best.residual))
        nothing = np.zeros(fit.n_calibration)
        x = _solved(evidence, fit, nothing, fit.priors.low, fit.priors.high, chosen)
        hypotheses = moved(hypotheses, x[fit.n_calibration :])
    return best


def _without_causes(setting: Setting, motion: int, effects: Sequence[Effect], torque: Array) -> Recording:
    """The recording of a motion in step with its positions, less a torque (T, N), motor side [N m]."""
    recording = setting.log.recordings[motion]
    link = recording.header.torque_semantics == "link_side"
    own = setting.log.robot.drive.joint_torque(torque) if link else torque
    names = [f"motor.effort.{joint}" for joint in recording.header.joints]
    measured = np.stack([recording[name] for name in names], axis=1)
    rest = in_step(measured, "torque", effects, recording.dt) - own
    return recording.with_columns({name: rest[:, j] for j, name in enumerate(names)})


def _replayed(
    setting: Setting, numbers: Machine, hypotheses: Sequence[Hypothesis], beside: Replay | None = None
) -> Written | None:
    """Numbers and causes as one machine, replayed, maybe `beside` one with other numbers; None if none can be so."""
    tried = trial_of(setting, hypotheses, numbers, beside)
    if tried is None:
        return None
    return Written(numbers=numbers, hypotheses=tuple(hypotheses), run=tried.run, residual=tried.residual)
