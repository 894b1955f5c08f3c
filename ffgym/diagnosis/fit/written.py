"""The model as it is written: causes, and the numbers that were fitted beside them.

A fit to a log holds for causes and calibration errors together; with the nominal numbers in their place, a cause that
overlaps one of them would make the model worse. So both are put into one machine, which is replayed, and fitted once
more about where it then is.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.calibration import Calibration, Doubt
from ffgym.diagnosis.evidence import Evidence
from ffgym.diagnosis.fit.fit import Fit, trial_of
from ffgym.diagnosis.fit.hypothesis import Hypothesis, moved
from ffgym.diagnosis.fit.setting import HELD, Setting, tangents, values_of
from ffgym.diagnosis.measured import residual_rows
from ffgym.diagnosis.replay import Replay, predicted
from ffgym.diagnosis.replay.channels import in_step
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.solving import bounded
from ffgym.effects import ClockEffect, Effect, NativeEffect
from ffgym.effects.friction_levels import StribeckPeak
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription
from ffgym.simulation.plant import Machine

_ROUNDING = 1e-12
"""By which a breakaway torque is more than the Coulomb torque at least, as a share of it: sums are rounded."""


def are_of_the_machine(doubts: Sequence[Doubt]) -> BoolArray:
    """Tell calibration errors of the machine from those of how rows were written, shape (len(doubts),)."""
    return np.array([not issubclass(doubt.column.effect, ClockEffect) for doubt in doubts], dtype=np.bool_)


def with_numbers(nominal: Machine, doubts: Sequence[Doubt], sizes: Array) -> Machine:
    """The nominal machine with its calibration errors corrected.

    Args:
        nominal: the machine whose numbers they are.
        doubts: what is open of it.
        sizes: in standard deviations, shape (len(doubts),); 0 for those that are not of the machine.
    """
    robot, beside = nominal.robot, list[Effect]()
    for effect in _effects(nominal, doubts, sizes):
        if effect.is_null:
            continue
        if isinstance(effect, StribeckPeak):
            effect = _not_below_coulomb(effect, robot)
        if isinstance(effect, NativeEffect):
            robot = effect.in_description(robot)
        else:
            beside.append(effect)
    return replace(nominal, robot=robot, effects=(*nominal.effects, *beside))


def possible_numbers(setting: Setting, sizes: Array) -> Machine | None:
    """The machine with its numbers corrected; None if none can be so."""
    try:
        machine = with_numbers(setting.nominal, setting.doubts, sizes)
        _ = machine.physical
    except FFGymError:
        return None
    return machine


def _not_below_coulomb(peak: StribeckPeak, robot: RobotDescription) -> StribeckPeak:
    """A breakaway torque that is less by as much as it may be: it is no less than the Coulomb torque."""
    friction = robot.friction
    return replace(peak, level=np.maximum(peak.level, (1 + _ROUNDING) - friction.static / friction.coulomb))


def _effects(nominal: Machine, doubts: Sequence[Doubt], sizes: Array) -> list[Effect]:
    """Calibration errors as effects, one of each kind with the numbers of all its joints."""
    n, values = nominal.robot.n_joints, dict[type[Effect], dict[str, Array]]()
    for doubt, size in zip(doubts, sizes.tolist(), strict=True):
        column, known = doubt.column, doubt.column.effect.parameters()
        own = values.setdefault(
            column.effect, {name: np.full(p.shape(n), p.neutral) for name, p in known.items() if p.null is not None}
        )
        place = _place(doubt, nominal)
        own[column.parameter][place] += size * doubt.sigma
    return [kind(**own) for kind, own in values.items()]


def _place(doubt: Doubt, nominal: Machine) -> int | tuple[()]:
    """Where the number of a column stands among those of its parameter."""
    column = doubt.column
    if column.joint:
        return nominal.robot.joints.index(column.joint)
    return () if column.part is None else column.part


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
