"""Thesis 6.2: NARX networks on data of a LuGre model, as the thesis fitted them, and with other regressors and data.

Beside them stand linear models of (3.5) on the same problems: ARX, output error (OE), and slip elements.

What the thesis chose is kept: three sigmoid neurons, no linear term, Levenberg-Marquardt on the prediction error with
at most 1000 iterations, data of (6.14) every 0.5 ms. It shows one fit of each model; here each is fitted from several
random weights, since different weights end in different minima.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np

from ffgym.core.errors import check_whole
from ffgym.core.types import Array
from ffgym.diagnosis.identification.narx import (
    Errors,
    Focus,
    LinearModel,
    Misfit,
    NarxModel,
    Regressors,
    Samples,
    Structure,
    fit_linear,
    fit_network,
    lags_of,
)
from ffgym.diagnosis.identification.narx.fit import N_EVALUATIONS
from ffgym.published import ESTIMATION_RECORDS, FRICTION_RECORDS
from ffgym.robot.friction import WIDTHS, LuGreParameters
from ffgym.studies import lugre_samples, sine
from ffgym.studies.friction_data import SAMPLE_TIME

DURATION = 6.0
"""[s], thesis 6.2.2."""
AMPLITUDE = 1.0
"""A of (6.21) [rad/s], thesis 6.2.2."""
ESTIMATION, VALIDATION = "A = 1, f = 1", "A = 1, f = 0.5"
"""Names of the two sines of thesis 6.2.2."""
N_STARTS = 10
"""Random starts of each fit; chosen for a median and a spread."""
FEWER_EVALUATIONS = 300
"""Evaluations for what goes beyond the thesis; chosen: 1000 change no median fit by more than 1 %."""
N_PERIODS, SHORTEST = 2, 2.0
"""Periods of a record of Table 6.1, which does not say its length, and the shortest one [s]; chosen."""

MIXTURE = ((2.0, 0.3), (1.5, 0.9), (1.2, 2.3), (0.8, 4.1))
"""Amplitudes [rad/s] and frequencies [Hz] of a motion whose reversals differ, with loops within loops; chosen."""

Data = Literal["sine", "set D"]
"""Data that a network is fitted to: the one sine of thesis 6.2.2, or the records of set D of Table 6.1."""


Kind = Literal["network", "linear"]
"""Sigmoid neurons, or a linear difference equation."""


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """A structure, and how it is fitted."""

    name: str
    """Unique, short."""
    label: str
    """Words for readers."""
    regressors: Regressors
    data: Data = "sine"
    focus: Focus = "prediction"
    n_evaluations: int = N_EVALUATIONS
    """At most, of a network; thesis 6.2.3 allows 1000 iterations."""
    kind: Kind = "network"


SPEEDS = Regressors(speed_lags=(0, 1), output_lags=())
"""Thesis (6.19)."""
OUTPUT = Regressors()
"""Thesis (6.20)."""
BOTH = Regressors(speed_lags=(0, 1), output_lags=(1,))
"""All that (6.19) and (6.20) have."""
LONG = Regressors(speed_lags=lags_of([0.0, 0.02, 0.04], SAMPLE_TIME), output_lags=())
"""Speeds 20 and 40 ms ago; chosen: the bristles of (6.18) take about as long to turn over at 1 Hz."""
SLIP = Regressors(slip_widths=tuple(WIDTHS), output_lags=())
"""Speed and slip elements, whose widths were chosen for the robots' bristles long before this study."""

PUBLISHED = (
    Candidate(name="speeds", label="v(k), v(k-1)  (6.19)", regressors=SPEEDS),
    Candidate(name="output", label="v(k), y(k-1)  (6.20)", regressors=OUTPUT),
)
"""The two models of the thesis."""

_beyond = partial(Candidate, n_evaluations=FEWER_EVALUATIONS)
EXTENDED = (
    _beyond(name="speeds_set_d", label="(6.19), set D", regressors=SPEEDS, data="set D"),
    _beyond(name="output_set_d", label="(6.20), set D", regressors=OUTPUT, data="set D"),
    _beyond(name="slip", label="v(k), slip elements", regressors=SLIP),
    _beyond(name="slip_set_d", label="v(k), slip elements, set D", regressors=SLIP, data="set D"),
)
"""More data alone, another regressor alone, and both."""

OTHERS = (
    Candidate(name="both", label="v(k), v(k-1), y(k-1)", regressors=BOTH),
    Candidate(name="long", label="v now, 20 and 40 ms ago", regressors=LONG),
    Candidate(
        name="free_run", label="(6.20), fitted in free run", regressors=OUTPUT, focus="simulation", n_evaluations=100
    ),
)
"""Changes that do not help enough: of the thesis' regressors, longer lags, and a fit to the free run."""


_linear = partial(Candidate, kind="linear")
_output_error = partial(_linear, focus="simulation")
LINEAR = (
    _linear(name="linear_speeds", label="linear: v(k), v(k-1)", regressors=SPEEDS),
    _linear(name="arx_output", label="ARX: v(k), y(k-1)", regressors=OUTPUT),
    _output_error(name="oe_output", label="OE: v(k), y(k-1)", regressors=OUTPUT),
    _linear(name="arx_both", label="ARX: v(k), v(k-1), y(k-1)", regressors=BOTH),
    _output_error(name="oe_both", label="OE: v(k), v(k-1), y(k-1)", regressors=BOTH),
    _linear(name="arx_both_set_d", label="ARX: v(k), v(k-1), y(k-1), set D", regressors=BOTH, data="set D"),
    _output_error(name="oe_both_set_d", label="OE: v(k), v(k-1), y(k-1), set D", regressors=BOTH, data="set D"),
    _linear(name="linear_slip", label="linear: v(k), slip elements", regressors=SLIP),
    _linear(name="linear_slip_set_d", label="linear: v(k), slip elements, set D", regressors=SLIP, data="set D"),
)
"""Linear models of the thesis' regressors and of slip elements; without past outputs ARX and OE are the same."""


@dataclass(frozen=True, kw_only=True, eq=False)
class NarxFit:
    """Fits of one candidate from S random starts; of a linear model there is one."""

    candidate: Candidate
    model: NarxModel | LinearModel
    """One motor per start."""
    errors: Mapping[str, Errors]
    """Errors by record; shape (S,) each."""

    def rms(self, record: str) -> Array:
        """RMS error in free run [N m] of each start, shape (S,)."""
        return self.errors[record].simulation.rms

    @property
    def typical(self) -> int:
        """The start whose error in validation is the median, for figures (of an even number the lower one)."""
        order = np.argsort(self.rms(VALIDATION), kind="stable")
        return int(order[(len(order) - 1) // 2])


def record_name(number: int) -> str:
    """Name of a record of Table 6.1."""
    return f"record {number}"


def narx_records(friction: LuGreParameters) -> dict[str, Samples]:
    """The sines of thesis 6.2.2 and the fifteen of Table 6.1, by name; friction of one joint, motor side."""
    speeds = {ESTIMATION: sine(AMPLITUDE, 1.0, DURATION), VALIDATION: sine(AMPLITUDE, 0.5, DURATION)}
    for each in FRICTION_RECORDS:
        duration = max(N_PERIODS / each.frequency, SHORTEST)
        speeds[record_name(each.number)] = sine(each.amplitude, each.frequency, duration)
    return {name: lugre_samples(friction, speed) for name, speed in speeds.items()}


def reach_records(friction: LuGreParameters) -> dict[str, Samples]:
    """Motions unlike those of Table 6.1, by name: how far a network's validity reaches."""
    t = SAMPLE_TIME * np.arange(round(DURATION / SAMPLE_TIME) + 1)
    mixed = sum(a * np.sin(2 * np.pi * f * t) for a, f in MIXTURE)
    speeds = {
        "sum of four sines": mixed,
        "faster: A = 15, f = 0.5": sine(15.0, 0.5, DURATION),
        "slower: A = 0.3, f = 0.2": sine(0.3, 0.2, 2 / 0.2),
        "within presliding: A = 0.05, f = 5": sine(0.05, 5.0, SHORTEST),
    }
    return {name: lugre_samples(friction, speed) for name, speed in speeds.items()}


def fit_narx(
    candidate: Candidate, records: Mapping[str, Samples], *, n_starts: int = N_STARTS, seed: int = 0
) -> NarxFit:
    """Fit a candidate from several random starts, and score it on all records, as those of `narx_records`.

    A linear model begins with least squares, so that it has one start.
    """
    check_whole("n_starts", n_starts, low=1)
    n_starts = n_starts if candidate.kind == "network" else 1
    names = [ESTIMATION] if candidate.data == "sine" else [record_name(number) for number in ESTIMATION_RECORDS]
    # the same samples for as many motors, so that all starts are fitted and simulated side by side
    copies = {
        name: Samples(
            dt=samples.dt,
            motor_dq=np.repeat(samples.motor_dq, n_starts, axis=1),
            torque=np.repeat(samples.torque, n_starts, axis=1),
            scored=samples.scored,
            noise=np.repeat(samples.noise, n_starts),
        )
        for name, samples in records.items()
    }
    model = _fit(candidate, [copies[name] for name in names], seed)
    errors = {name: Errors.of(model, samples) for name, samples in copies.items()}
    return NarxFit(candidate=candidate, model=model, errors=errors)


def _fit(candidate: Candidate, records: Sequence[Samples], seed: int) -> NarxModel | LinearModel:
    if candidate.kind == "linear":
        return fit_linear(records, candidate.regressors, focus=candidate.focus)
    return fit_network(
        records,
        Structure(regressors=candidate.regressors),
        np.random.default_rng(seed),
        focus=candidate.focus,
        n_evaluations=candidate.n_evaluations,
    )


def static_misfit(friction: LuGreParameters, samples: Samples) -> Misfit:
    """Compute the misfit of the static curve to a record: the floor that a network with memory must beat."""
    rows = samples.scored
    return Misfit.of(friction.steady_torque(samples.motor_dq)[rows], samples.torque[rows])
