"""Result of a diagnosis: verdict, causes with sizes, rivals, effects without a statement, and the next motion."""

from dataclasses import dataclass, field
from typing import Any, Literal

from ffgym.diagnosis.residual import Channel

Verdict = Literal["none", "named", "partly", "ambiguous", "unknown", "wiring", "insufficient"]
"""`none`: these motions do not falsify the model; `named`: causes explain what it lacks; `partly`: a cause explains
much and something is left; `ambiguous`: several causes explain it as well, see the separating motion; `unknown`:
something is there that no effect of the library explains; `wiring`: columns are not what they are called, and no
physical cause was looked for; `insufficient`: these logs do not allow a diagnosis."""


NEAR_NOISE = 1.25
"""RMS over that of noise up to which what is left is noise: one and a half times its energy, as of verdicts."""

SMALL = 0.05
"""Share of what was measured up to which what is left is small; chosen: rigid-body fits of recorded robots leave as
much at best."""


@dataclass(frozen=True, kw_only=True)
class Size:
    """Size of a parameter with its interval."""

    name: str
    """Name of the parameter; then a dot and the axis of a vector, or the other joint of a pair."""
    value: float
    unit: str
    interval: tuple[float, float]
    """90 % interval, by resampled blocks."""


def make_label(effect: str, joint: str) -> str:
    """Make the label of an effect on a joint, such as 'backlash on j2'."""
    return f"{effect} on {joint}" if joint else effect


@dataclass(frozen=True, kw_only=True)
class Cause:
    """An effect that explains part of the residual."""

    effect: str
    """Its name in `ffgym.effects`."""
    code: str
    title: str
    joint: str
    """Joint on which it acts; empty for the machine as a whole."""
    parameters: tuple[Size, ...]
    fixed: dict[str, float]
    """Parameters of shape that were chosen, not estimated, by name; SI units."""
    held_out_gain: float
    """Share of the residual's energy above the noise floor, in the channels it acts on, that it explained when the
    search adopted it, by fits to all rows; above 1 where a fit takes noise away. `levels` has shares of motions that
    were left out; the name is kept for readers of diagnosis.json."""

    @property
    def label(self) -> str:
        """Name by which rivals refer to it."""
        return make_label(self.effect, self.joint)


@dataclass(frozen=True, kw_only=True)
class FittedNumber:
    """A number of the nominal model that was fitted beside the causes, as the extended model has it."""

    entry: str
    """Entry of a description, such as 'friction.coulomb'; or 'effects.' with the name of an effect and its
    parameter."""
    unit: str
    """Unit as the entry is kept: SI units, on the side that descriptions keep it on."""
    before: tuple[float, ...]
    """All its values, row by row."""
    after: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class Rival:
    """An effect that was considered and lost, or tied."""

    effect: str
    joint: str
    held_out_gain: float
    tied: bool
    """True if these logs cannot tell it from the cause."""
    against: str
    """Label of the cause that it rivals."""
    reason: str
    """Why it lost, or what would tell both apart."""


PatternKind = Literal["periodic", "function", "sign-locked function", "line", "dependence"]
"""Periodic in an angle; a function of a variable; the same times the sign of the speed; a frequency in time; dependent
in a form that is none of these."""


@dataclass(frozen=True, kw_only=True)
class Pattern:
    """Dependence of a residual on a variable, without any effect as its reason."""

    channel: Channel
    component: str
    """Joint or axis."""
    variable: str
    """E.g. 'motor angle', 'motor speed', 'time', 'speed of joint_2'."""
    kind: PatternKind
    frequency: float | None
    """Cycles per motor turn, or [Hz] of a line; None for others."""
    amplitude: float
    """Amplitude of a sine with the same energy, in the unit of the channel."""
    share: float
    """Share of the residual's energy in this component that it explains, on rows that were not used; 0 for a
    dependence, which foretells nothing."""
    message: str
    """One sentence."""
    leads: tuple[str, ...] = ()
    """Effects whose equation has this form, each with the reason why it is no cause."""


@dataclass(frozen=True, kw_only=True)
class Drift:
    """A friction level that changes from day to day."""

    effect: str
    """`coulomb_level` or `viscous_level`."""
    joint: str
    motions: tuple[str, ...]
    days: tuple[float, ...]
    """Day of each motion, since the first one."""
    changes: tuple[float, ...]
    """Against the model of all recordings, as a share of its level."""
    errors: tuple[float, ...]
    """Standard errors of these, by blocks of rows."""
    per_day: float
    """Change of the level per day, as a share of it."""
    per_day_error: float
    """Its standard error; scatter between recordings is in it."""

    @property
    def message(self) -> str:
        """One sentence."""
        what = "viscous" if self.effect == "viscous_level" else "Coulomb"
        way, span = "falls" if self.per_day < 0 else "rises", max(self.days) - min(self.days)
        total, error = abs(self.per_day) * span, self.per_day_error * span
        return f"{what} friction of {self.joint} {way} over {span:.0f} days by {total:.0%} (standard error {error:.0%})"


@dataclass(frozen=True, kw_only=True)
class UnjudgedEffect:
    """An effect on which no statement is made."""

    effect: str
    joint: str
    """Empty for all joints."""
    reason: str


@dataclass(frozen=True, kw_only=True)
class Level:
    """RMS of one component of a channel over all motions."""

    channel: Channel
    component: str
    unit: str
    measured: float
    """RMS of what was measured, about its mean."""
    noise_floor: float
    before: float
    """RMS of the residual of the nominal model as it is."""
    after: float
    """RMS of the residual of the extended model as it is written, each motion by one that was fitted without it."""

    @property
    def is_small(self) -> bool:
        """True if the extended model leaves hardly more than noise, or a small share of what was measured."""
        return self.after <= max(NEAR_NOISE * self.noise_floor, SMALL * self.measured)


@dataclass(frozen=True, kw_only=True)
class SeparatingMotion:
    """Session to record next, which tells two causes apart."""

    between: tuple[str, str]
    """'effect on joint' each."""
    protocol: str
    """Motions that `ffgym record` runs: name of the protocol."""
    toml: str
    """Text of the protocol file."""
    expected: float
    """Log-likelihood ratio that noise-limited data would give, per second."""


@dataclass(frozen=True, kw_only=True)
class Miswiring:
    """Columns that are not what they are called."""

    kind: str
    """sign, unit, side, swap, axes, zero, delay, clock or current."""
    families: tuple[str, ...]
    """Families of columns; empty for the clock."""
    joints: tuple[str, ...]
    """Joints, or axes of the tracker; empty for the clock."""
    message: str
    """One sentence: what is wrong, what shows it, the way out."""


@dataclass(frozen=True, kw_only=True)
class Diagnosis:
    """Answer of a diagnosis: errors of the simulation, their causes, and how sure they are."""

    verdict: Verdict
    sentence: str
    """The verdict in one sentence."""
    robot: str
    motions: tuple[str, ...]
    causes: tuple[Cause, ...] = ()
    numbers: tuple[FittedNumber, ...] = ()
    """Numbers of the nominal model that were fitted beside the causes, as the extended model has them."""
    drifts: tuple[Drift, ...] = ()
    """Friction levels that change between recordings, beside the model of all of them."""
    rivals: tuple[Rival, ...] = ()
    patterns: tuple[Pattern, ...] = ()
    not_excited: tuple[UnjudgedEffect, ...] = ()
    """Effects that these motions would not show."""
    not_judgeable: tuple[UnjudgedEffect, ...] = ()
    """Effects that take columns, or a description, that are not there."""
    separating_motion: SeparatingMotion | None = None
    wiring: tuple[Miswiring, ...] = ()
    """Columns that are not what they are called, the most telling first; then there is nothing else."""
    levels: tuple[Level, ...] = ()
    gains: bool = False
    """True if the extended model leaves less than the nominal one of motions that it was not fitted to; if it does not,
    it is worse than before, and is not written."""
    threshold: float = 0.0
    """Energy that the best effect removes by chance in one of a thousand logs of a perfect model, on rows that were not
    used; 1 is the energy of noise in one component. Effects are tried whose score is larger. No share."""
    quality: tuple[str, ...] = ()
    """Sentences on how a long log was thinned, and on what the quality gate flagged or refused."""
    provenance: dict[str, Any] = field(default_factory=dict)
    """Seed, versions, fingerprints, options."""

    def tell_left(self, level: Level) -> str:
        """Tell how much is left of a component: 'small', 'allowed for' or 'not small'.

        Errors of calibration, and friction at motion that a log does not show, are allowed for where nothing else is
        needed.
        """
        if level.is_small:
            return "small"
        return "allowed for" if self.verdict == "none" else "not small"
