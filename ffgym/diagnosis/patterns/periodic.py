"""What repeats: with the angle of a motor, or in time."""

from dataclasses import dataclass
from typing import Literal, final

import numpy as np

from ffgym.core.errors import check_choice
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.patterns.forms import Periodic
from ffgym.diagnosis.patterns.rows import Rows, rows_of
from ffgym.diagnosis.patterns.spectra import Spectrum, Turning, angle_spectrum, passed, refined, time_spectrum
from ffgym.diagnosis.residual import Channel, Residual, components
from ffgym.diagnosis.result import PatternKind

Amplitude = Literal["constant", "torque", "sign", "speed squared"]
"""What the amplitude goes with: nothing, the motor torque, the sign of the speed, or its square."""

LEAST_CYCLES, MOST_CYCLES = 0.5, 72.0
"""Cycles per motor turn that are looked for: from half a turn of a two-pole-pair resolver's error to slots of a large
motor times two; what rows cannot show is left out."""

FEWEST_PERIODS = 1.5
"""Periods over the whole way of a motor that make a periodic function; with fewer it is any smooth function."""

LOWEST_LINE = 1.0
"""Lowest line in time [Hz]; slower ones are rhythms of the motions."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PerTurn(Periodic):
    """A sine of the angle of a motor."""

    joint: int
    amplitude: Amplitude = "constant"
    own_only: bool = True

    def may_act_on(self, rows: Rows, component: int) -> bool:
        """Whether a component of a channel may depend on it; a gear that errs moves the tool as it turns, no more."""
        return super().may_act_on(rows, component) and (rows.channel != "tool" or self.amplitude == "constant")

    @property
    def kind(self) -> PatternKind:
        """See base class."""
        return "periodic"

    def spectra(self, rows: Rows, values: Array, train: BoolArray) -> list[Spectrum] | None:
        """Periodograms of values (R, C) over the angle; None where the motor turns too little."""
        j, did = self.joint, rows.did
        turning = Turning(
            angle=did.angle[train, j],
            speed=did.speed[train, j],
            gain=self._gain(rows)[train],
            motion=rows.motion[train],
            highest=rows.highest,
        )
        turns = np.ptp(turning.angle) / (2 * np.pi)
        if turns * MOST_CYCLES < 2 * FEWEST_PERIODS:
            return None
        low = max(LEAST_CYCLES, FEWEST_PERIODS / turns)
        return angle_spectrum(turning, values[train], low=low, high=MOST_CYCLES)

    def search(self, rows: Rows, values: Array, train: BoolArray) -> list[float] | None:
        """See base class."""
        spectra = self.spectra(rows, values, train)
        return None if spectra is None else [spectrum.best for spectrum in spectra]

    def refine(self, rows: Rows, values: Array, frequency: float) -> float:
        """See base class."""
        width = 1 / max(np.ptp(rows.did.angle[:, self.joint]) / (2 * np.pi), 1.0)
        return refined(frequency, width / 2, lambda n: rows.centred(self.columns(rows, n)), values)

    def columns(self, rows: Rows, frequency: float) -> Array:
        """See base class."""
        j = self.joint
        gain = self._gain(rows) * passed(rows.did.speed[:, j], frequency, rows.highest)
        phase = frequency * rows.did.angle[:, j]
        return gain[:, None] * np.stack([np.cos(phase), np.sin(phase)], axis=1)

    def complexity(self, rows: Rows) -> int:
        """See base class."""
        return 3

    def _gain(self, rows: Rows) -> Array:
        did, j = rows.did, self.joint
        match self.amplitude:
            case "torque":
                gain = did.torque[:, j]
            case "sign":
                gain = did.sign[:, j]
            case "speed squared":
                gain = did.speed[:, j] ** 2
            case _:
                return np.ones(len(did.t))
        size = float(np.sqrt(np.mean(gain**2)))
        return gain / size if size > 0 else gain


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Line(Periodic):
    """A vibration of one frequency in time, with a phase and an amplitude of its own in each motion.

    Of a joint, it turns over with the direction of its motor: friction that comes and goes, as of a brake that drags.
    """

    joint: int | None = None
    own_only: bool = False

    def may_act_on(self, rows: Rows, component: int) -> bool:
        """Whether a component of a channel may depend on it; what drags at a motor takes torque."""
        return super().may_act_on(rows, component) and (self.joint is None or rows.channel != "tool")

    @property
    def kind(self) -> PatternKind:
        """See base class."""
        return "line"

    def search(self, rows: Rows, values: Array, train: BoolArray) -> list[float] | None:
        """See base class."""
        if rows.highest <= LOWEST_LINE:
            return None
        signed = values * self._sign(rows)[:, None]
        return [time_spectrum(rows, column, train, low=LOWEST_LINE, high=rows.highest).best for column in signed.T]

    def refine(self, rows: Rows, values: Array, frequency: float) -> float:
        """See base class."""
        longest = max(np.ptp(rows.did.t[rows.motion == m]) for m in range(len(rows.motion_starts)))
        return refined(frequency, 0.5 / longest, lambda f: rows.centred(self.columns(rows, f)), values)

    def columns(self, rows: Rows, frequency: float) -> Array:
        """See base class."""
        phase = 2 * np.pi * frequency * rows.did.t
        in_motion = rows.motion[:, None] == np.arange(len(rows.motion_starts))
        waves = np.stack([np.cos(phase), np.sin(phase)]) * self._sign(rows)
        return np.concatenate([in_motion * wave[:, None] for wave in waves], axis=1)

    def complexity(self, rows: Rows) -> int:
        """See base class."""
        return 2 * len(rows.motion_starts) + 1

    def _sign(self, rows: Rows) -> Array:
        """What turns it over, (R,)."""
        return np.ones(len(rows.did.t)) if self.joint is None else rows.did.sign[:, self.joint]


def cycles_per_turn(
    residual: Residual, channel: Channel, component: str, joint: str, *, amplitude: Amplitude = "constant"
) -> Spectrum | None:
    """Periodogram of one component of a residual over the motor angle of a joint, 0.5 to 72 cycles per turn.

    Frequencies are a quarter of the resolution apart, which is one over the turns that the motor makes in all.

    Args:
        residual: what a model leaves.
        channel: which of its channels.
        component: joint or axis of the channel.
        joint: whose motor turns.
        amplitude: what the amplitude goes with.

    Returns:
        None where there are no rows, or the motor turns too little for any period.

    Raises:
        FFGymError: if there is no such channel, component or joint.
    """
    check_choice("channel", channel, residual.channels)
    names = components(channel, residual.robot)
    check_choice("component", component, names)
    check_choice("joint", joint, residual.robot.joints)
    rows = rows_of(residual, channel, np.random.default_rng(0))  # halves are not used
    if rows is None:
        return None
    values = rows.values[:, names.index(component)]
    everything = np.ones(len(values), dtype=np.bool_)
    spectra = PerTurn(joint=rows.joints.index(joint), amplitude=amplitude).spectra(rows, values[:, None], everything)
    return None if spectra is None else spectra[0]
