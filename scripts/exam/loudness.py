r"""Loudness of a hidden effect: the energy that it adds to the residual over that of the noise.

.. math:: \chi_0 = 1 + \max_c \frac1R \sum_{m,i} \left( \frac{\Delta_{mic}}{n_{mc}} \right)^2

over the components c of all channels; R rows i of all motions, and the RMS n in motion m of what the nominal model
leaves of a log of the nominal robot itself. :math:`\Delta` is what the effect changes when that log is replayed, or
what it changes in the log where no replay knows of it, e.g. of joints that a description does not have; less what
errors of calibration within their bounds would explain of it: a link that is a per cent heavier is no effect that
anybody could know of.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.log import Log, assemble_log
from ffgym.diagnosis.normal_equations import DesignMatrix, build_design_matrix
from ffgym.diagnosis.nuisance import ParameterPrior, list_nuisance_parameters
from ffgym.diagnosis.perturbation import Parts
from ffgym.diagnosis.replay import predict, replay
from ffgym.diagnosis.replay.springs import FlownAwayError
from ffgym.diagnosis.resampling import cut_blocks
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.residual_rows import compute_residuals, find_valid_rows
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.solving import Priors, solve
from ffgym.effects import Effect
from ffgym.recordings import Recording
from ffgym.simulation.plant import Climate, Machine
from scripts.exam.bench import Bench
from scripts.exam.draw import Case, errors_beside
from scripts.exam.hidden import Hidden
from scripts.exam.tasks import Task

_NOISE_SEED = 0
"""Seed of the log that tells the noise; one for all exams, whose noise is the same to a per cent."""

_HALVINGS = 8
"""Times that an effect is halved which no arm would hold; chosen: some 2 kg m^2 on a spring, on a last link of 0.05."""

Rows = Mapping[Channel, Array]
"""Residual by channel (R, M, C); zero in rows that do not count."""


@dataclass(frozen=True, kw_only=True, eq=False)
class NoiseScale:
    """Noise and calibration errors in the motions of an exam."""

    rms: Mapping[Channel, Array]
    """RMS of noise, (M, C) by channel."""
    nuisance_columns: Sequence[Parts]
    """Columns per standard deviation."""
    design: DesignMatrix
    """Design matrix of those columns, weighted."""

    def energy(self, added: Rows) -> float:
        """Energy of a difference of residuals, in energies of the noise, of the component where that is largest.

        Without what calibration explains.
        """
        counts = self.design.blocks.of_row >= 0
        rows = {(channel, c): values[..., [c]] for channel, values in added.items() for c in range(values.shape[2])}
        # errors of calibration that explain most, in standard deviations
        n = len(self.nuisance_columns)
        bound = np.full(n, settings().prior.bound)
        priors = Priors(precision=np.ones(n), low=-bound, high=bound)
        sizes, found = solve(self.design.form_equations(rows), np.arange(n), priors), []
        for (channel, c), values in rows.items():
            rest = values[..., 0].copy()
            for size, column in zip(sizes, self.nuisance_columns, strict=True):
                rest -= size * column.get((channel, c), 0.0)
            weighted = counts * rest / self.rms[channel][:, c]
            found.append(float(np.sum(weighted**2)) / int(np.count_nonzero(counts)))
        return max(found)


def measure_noise_scale(
    noise: Rows, valid: BoolArray, row_dt: float, nuisance_columns: Sequence[Parts] = ()
) -> NoiseScale:
    """Measure noise by its residuals (R, M, C), 0 where rows are not `valid` (R, M), and columns of calibration."""
    count = np.maximum(valid.sum(axis=0), 1)[:, None]
    rms = {channel: np.sqrt(np.sum(values**2, axis=0) / count) for channel, values in noise.items()}
    weights = {(channel, c): 1 / column for channel, values in rms.items() for c, column in enumerate(values.T)}
    return NoiseScale(
        rms=rms,
        nuisance_columns=nuisance_columns,
        design=build_design_matrix(cut_blocks(valid, row_dt), nuisance_columns, weights),
    )


class EnergyMeter:
    """Measures the energy that effects add to the log of a robot that has none."""

    def __init__(self, bench: Bench, climate: Climate | None = None) -> None:
        """Record and replay a log without effects; `climate` is that of the day, None a day without warming."""
        self._bench, self._nominal, self._climate = bench, Machine(robot=bench.arm.robot), climate or Climate()
        self.log = log = self._log(())
        self._run = replay(log, self._nominal)
        self._without, self._valid = predict(self._run), find_valid_rows(log)
        self._residual = compute_residuals(log, self._without)
        nuisance_columns = [
            {key: rows * doubt.sigma for key, rows in doubt.column.parts.items()}
            for doubt in list_nuisance_parameters(self._run, ParameterPrior())
        ]
        noise = self._count(self._residual)
        self._scale = measure_noise_scale(noise, self._valid, log.sampling.row_dt, nuisance_columns)

    def energy(self, effect: Effect) -> float:
        """Compute the energy that an effect adds, in energies of the noise."""
        machine = replace(self._nominal, effects=(effect,))
        added = self._scale.energy(self._change(predict(replay(self._run.log, machine, self._run)), self._without))
        if added > 0:
            return added
        log = self._log((effect,))
        residual = compute_residuals(log, predict(replay(log, self._nominal)))
        return self._scale.energy(self._change(residual, self._residual))

    def _log(self, effects: tuple[Effect, ...]) -> Log:
        """Assemble a log with the same noise at all times."""
        machine = replace(self._nominal, effects=effects, climate=self._climate)
        return assemble_log(machine.robot, self._bench.record(machine, seed=_NOISE_SEED))

    def _change(self, one: Rows, other: Rows) -> Rows:
        return self._count({channel: values - other[channel] for channel, values in one.items()})

    def _count(self, rows: Rows) -> Rows:
        return {channel: np.where(self._valid[..., None], values, 0.0) for channel, values in rows.items()}


@cache
def build_energy_meter(bench: Bench) -> EnergyMeter:
    """Build the energy meter of the motions of a bench; once."""
    return EnergyMeter(bench)


@dataclass(frozen=True, kw_only=True, eq=False)
class OwnTask(Task):
    """A question about a machine of the project's own simulation."""

    case: Case
    """The question, with effects as large as they are in the log."""


def record_task(case: Case, meter: EnergyMeter | None = None) -> OwnTask:
    """Record the log of a question, with effects as loud as asked for, or as loud as their plausible size allows.

    The `meter` is that of the motions of its log, by default that of the exam.
    """
    sized, heard = tuple[Hidden, ...](), tuple[float, ...]()
    if case.hidden:
        meter = meter or build_energy_meter(case.audible)
        full = [limit_effect(meter, one) for one in case.hidden]
        sized = tuple(one for one, _ in full)
        if case.loudness:
            # energy grows with the square of the size
            factors = [
                1.0 if added <= wanted - 1 else float(np.sqrt((wanted - 1) / added))
                for (_, added), wanted in zip(full, case.loudness, strict=True)
            ]
            sized = tuple(one.times(factor) for one, factor in zip(sized, factors, strict=True))
        heard = tuple(1 + meter.energy(one.effect) for one in sized)
    case, robot = replace(case, hidden=sized), case.robot
    log = record_case(case)
    sized = tuple(
        replace(one, beside=errors_beside(one, robot, case.machine, case.current_offset)) for one in case.hidden
    )
    return OwnTask(
        row=case.row,
        number=case.number,
        robot=robot,
        log=tuple(log),
        truth=tuple(one.truth(robot, loud) for one, loud in zip(sized, heard, strict=True)),
        clue=sized[0].clue(robot) if sized else None,
        case=replace(case, hidden=sized),
    )


def record_case(case: Case) -> list[Recording]:
    """Record the log of a question."""
    seed = int(case.generator().integers(2**32))
    return case.bench.record(case.complete, seed=seed, current_offset=case.current_offset)


def limit_effect(meter: EnergyMeter, hidden: Hidden) -> tuple[Hidden, float]:
    """Reduce an effect to what a machine can have, and compute its energy.

    Raises:
        FFGymError: if the arm does not hold even a little of it.
    """
    for _ in range(_HALVINGS):
        try:
            return hidden, meter.energy(hidden.effect)
        except FlownAwayError:
            hidden = hidden.times(0.5)
    return hidden, meter.energy(hidden.effect)
