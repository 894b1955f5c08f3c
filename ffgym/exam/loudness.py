r"""How loud a hidden effect is: how far what it adds to the residual stands above what noise makes of it.

.. math:: \chi_0 = 1 + \max_c \frac1R \sum_{m,i} \left( \frac{r_{mic} - r^0_{mic}}{n_{mc}} \right)^2

over the components c of all channels, with the residual r of the nominal model on the machine's log, r^0 on the log of
the same machine without the effect, and the RMS n of that on a log of the nominal robot itself in motion m, all with
the same sensors; R rows i of all motions. Errors of calibration are in both residuals: they make the question harder,
not the effect louder. What errors of calibration within their bounds would explain of the difference is taken off it:
a link that is a per cent heavier is no effect that anybody could know of.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import final

import numpy as np

from ffgym.diagnosis.calibration import BOUND, Calibration, doubts_of
from ffgym.diagnosis.evidence.screen import Priors, fitted
from ffgym.diagnosis.evidence.stack import Stack, Values, blocks_of, stack_of
from ffgym.diagnosis.log import Log, log_of
from ffgym.diagnosis.measured import residual_rows, valid_rows
from ffgym.diagnosis.replay import predicted, replay
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.signatures.column import Parts
from ffgym.exam.case import Case, protocol_of
from ffgym.exam.hidden import Hidden
from ffgym.exam.recording import log_of_case, recorded
from ffgym.plant import Climate, Machine
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, RobotDescription
from ffgym.types import Array, BoolArray

_NOISE_SEED = 0
"""Of the log that tells the noise; one for all exams, whose noise is the same to a per cent."""

Rows = Mapping[Channel, Array]
"""Residual by channel (R, M, C); zero in rows that do not count."""


def residual_of(robot: RobotDescription, recordings: Sequence[Recording]) -> Rows:
    """What the nominal model leaves of a log."""
    log = log_of(robot, recordings)
    return _counted(log, residual_rows(log, predicted(replay(log, Machine(robot=robot)))))


def _less(one: Rows, other: Rows) -> Rows:
    return {channel: values - other[channel] for channel, values in one.items()}


def _counted(log: Log, rows: Mapping[Channel, Array]) -> Rows:
    valid: BoolArray = valid_rows(log)[..., None]
    return {channel: np.where(valid, values, 0.0) for channel, values in rows.items()}


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Yardstick:
    """What noise and calibration come to in the motions of an exam."""

    rms: Mapping[Channel, Array]
    """Of noise, (M, C) by channel."""
    calibration: Sequence[Parts]
    """Columns per standard deviation."""
    stack: Stack
    """Those columns, weighted."""

    def energy(self, added: Rows) -> float:
        """Energy of a difference of residuals, in energies of the noise, of the component where that is largest.

        Without what calibration explains.
        """
        counts, n_rows = self.stack.blocks.of_row >= 0, int(np.count_nonzero(self.stack.blocks.of_row >= 0))
        rows = {(channel, c): values[..., [c]] for channel, values in added.items() for c in range(values.shape[2])}
        sizes, found = self._errors(rows), []
        for (channel, c), values in rows.items():
            rest = values[..., 0].copy()
            for size, column in zip(sizes, self.calibration, strict=True):
                rest -= size * column.get((channel, c), 0.0)
            found.append(float(np.sum((counts * rest / self.rms[channel][:, c]) ** 2)) / n_rows)
        return max(found)

    def _errors(self, rows: Values) -> Array:
        """Errors of calibration that explain most, in standard deviations."""
        n = len(self.calibration)
        bound = np.full(n, BOUND)
        priors = Priors(precision=np.ones(n), low=-bound, high=bound)
        return fitted(self.stack.evidence(rows), np.arange(n), priors)


def yardstick_of(noise: Rows, valid: BoolArray, row_dt: float, calibration: Sequence[Parts] = ()) -> Yardstick:
    """Yardstick by residuals of noise (R, M, C), 0 where rows are not `valid` (R, M), and columns of calibration."""
    count = np.maximum(valid.sum(axis=0), 1)[:, None]
    rms = {channel: np.sqrt(np.sum(values**2, axis=0) / count) for channel, values in noise.items()}
    weights = {(channel, c): 1 / column for channel, values in rms.items() for c, column in enumerate(values.T)}
    return Yardstick(rms=rms, calibration=calibration, stack=stack_of(blocks_of(valid, row_dt), calibration, weights))


@cache
def yardstick_of_exam(arm: RigidArm, poor: bool, lacks: tuple[str, ...]) -> Yardstick:
    """By a log of the nominal robot itself, of the same motions and columns."""
    machine = Machine(robot=arm.robot, climate=Climate())
    recordings = recorded(arm, machine, [protocol_of(arm.robot, poor=poor)], seed=_NOISE_SEED, lacks=lacks)
    log = log_of(arm.robot, recordings)
    run = replay(log, Machine(robot=arm.robot))
    calibration = [
        {key: rows * doubt.sigma for key, rows in doubt.column.parts.items()} for doubt in doubts_of(run, Calibration())
    ]
    noise = _counted(log, residual_rows(log, predicted(run)))
    return yardstick_of(noise, valid_rows(log), log.sampling.row_dt, calibration)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Paper:
    """A question as it is handed out, and what only the examiner knows of it."""

    case: Case
    """With effects as large as they are in the log."""
    log: tuple[Recording, ...]
    loudness: tuple[float, ...]
    """Of each hidden effect."""


def handed_out(case: Case) -> Paper:
    """The log of a question, with effects as loud as they are to be, or as they can be within their plausible size."""
    if not case.hidden:
        return Paper(case=case, log=tuple(log_of_case(case)), loudness=())
    quiet = log_of_case(case, case.machine)
    yardstick, without = yardstick_of_exam(case.arm, case.is_poor, case.lacks), residual_of(case.arm.robot, quiet)

    def simulated(*hidden: Hidden) -> tuple[float, list[Recording]]:
        log = log_of_case(case, case.with_hidden(hidden))
        return yardstick.energy(_less(residual_of(case.arm.robot, log), without)), log

    sized, expected = case.hidden, []
    if case.loudness:
        replayed = _replayed(case, log_of(case.arm.robot, quiet), yardstick)
        full = [replayed(one) or simulated(one)[0] for one in case.hidden]  # what no replay knows is simulated
        factors = [_factor(wanted, added) for wanted, added in zip(case.loudness, full, strict=True)]
        sized = tuple(one.times(factor) for one, factor in zip(case.hidden, factors, strict=True))
        expected = [factor**2 * added for factor, added in zip(factors, full, strict=True)]
    together, log = simulated(*sized)
    heard = tuple(1 + added for added in (expected if len(sized) > 1 else [together]))
    return Paper(case=replace(case, hidden=sized), log=tuple(log), loudness=heard)


def _factor(wanted: float, full: float) -> float:
    """Size at which an effect is as loud as wanted, as a share of the full one; energy grows with its square."""
    return 1.0 if full <= wanted - 1 else float(np.sqrt((wanted - 1) / full))


def _replayed(case: Case, quiet: Log, yardstick: Yardstick) -> Callable[[Hidden], float]:
    """Energy that an effect would add to the residual, by what it changes when a log without it is replayed.

    It is 0 for what no replay knows, e.g. joints that a description does not have.
    """
    nominal = Machine(robot=case.arm.robot)
    without = _counted(quiet, predicted(replay(quiet, nominal)))

    def energy(one: Hidden) -> float:
        with_it = predicted(replay(quiet, replace(nominal, effects=(one.effect,))))
        return yardstick.energy(_less(_counted(quiet, with_it), without))

    return energy
