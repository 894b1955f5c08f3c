"""What residuals depend on, strongest first: each pattern is what the stronger ones leave."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.patterns.forms import (
    Candidate,
    Fixed,
    Function,
    Periodic,
    Variable,
    fit,
    friction_of,
    functions_of,
    functions_of_time,
)
from ffgym.diagnosis.patterns.periodic import Amplitude, Line, PerTurn
from ffgym.diagnosis.patterns.rows import Rows, rows_of, without_slow
from ffgym.diagnosis.patterns.significance import Dependence, best_of, dependence, tried, wandering
from ffgym.diagnosis.residual import UNITS, Residual
from ffgym.diagnosis.result import Pattern

_VARIABLES: dict[Variable, str] = {
    "angle": "motor angle",
    "speed": "motor speed",
    "size of speed": "size of the motor speed",
    "acceleration": "motor acceleration",
    "load": "load",
    "temperature": "temperature",
    "travel": "travel since the last reversal",
    "rest": "time at rest before the move",
    "time": "time",
    "way": "way since the motion began",
    "power": "speed times torque",
    "none": "motor speed",
}

_AMPLITUDES: dict[Amplitude, str] = {
    "constant": "amplitude independent of torque",
    "torque": "amplitude proportional to the torque",
    "sign": "turned over with the direction of motion",
    "speed squared": "amplitude proportional to the square of the speed",
}


def variable_of(form: Candidate | Dependence, joints: tuple[str, ...], component: str) -> str:
    """What a residual depends on; of which joint is said if that is not the component's own."""
    if form.joint is None:
        return "time"
    words = "motor angle" if isinstance(form, PerTurn) else "time"
    if isinstance(form, Function | Dependence):
        words = _VARIABLES[form.variable]
    return words if joints[form.joint] == component else f"{words} of {joints[form.joint]}"


def message(pattern: Pattern, form: Candidate | Dependence, joints: tuple[str, ...]) -> str:
    """One sentence: what depends on what, how large that is, and how much of the residual it explains."""
    size = f"{pattern.amplitude:.3g} {UNITS[pattern.channel]}"
    known = "" if isinstance(form, Dependence) else f", {pattern.share:.0%} of the residual"
    return f"{pattern.channel} of {pattern.component}: {_depends(pattern, form, joints)} ({size}{known})"


def _depends(pattern: Pattern, form: Candidate | Dependence, joints: tuple[str, ...]) -> str:
    if pattern.kind == "line":
        how = "whatever moves" if form.joint is None else f"turned over with the direction of {joints[form.joint]}"
        return f"vibration at {pattern.frequency:.2f} Hz, {how}"
    joint = "" if form.joint is None else joints[form.joint]
    if isinstance(form, PerTurn):
        cycles = f"{pattern.frequency:.1f} cycles per turn"
        return f"periodic in the motor angle of {joint}, {cycles}, {_AMPLITUDES[form.amplitude]}"
    named = variable_of(form, joints, "")
    if isinstance(form, Dependence) and form.joint is None:
        return "wanders with time, whatever moves"
    if isinstance(form, Dependence):
        return f"depends on the {named}, in none of the forms that are known"
    if not isinstance(form, Function) or form.signed is None:
        return f"a function of the {named}"
    if form.variable == "none":
        return f"goes with the sign of the {named}"
    return f"a function of the {named}, times the sign of the motor speed of {joints[form.signed]}"


FALSE_ALARMS = 0.01
"""Probability that noise alone gives any pattern in any channel."""

LEAST_SHARE = 0.05
"""Least share of a component's residual that a pattern explains; less is not worth a word, however sure it is."""

MOST = 4
"""Most patterns of one component."""

_CUTS = 3
"""Ways of cutting the rows into halves in which ripple is looked for: a motor may be fast enough to show it in a few
stretches alone, which may all come to lie in one half; chosen."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Found:
    """A pattern, and how much energy above the noise it stands for."""

    pattern: Pattern
    strength: float


@dataclass(frozen=True, kw_only=True)
class _Levels:
    """Probabilities of single tests by chance: a quarter of FALSE_ALARMS for forms, ripple and each catch-all."""

    form: float
    ripple: float
    dependence: float


def find_patterns(residual: Residual, rng: np.random.Generator) -> tuple[Pattern, ...]:
    """What the residuals of all channels depend on, strongest against the noise floor first; none in noise."""
    tables = [rows_of(residual, channel, rng) for channel in residual.channels]
    enough = [rows for rows in tables if rows is not None and rows.has_enough]
    forms = candidates(len(residual.robot.joints))
    tests = sum(form.may_act_on(rows, c) for rows in enough for form in forms for c in range(len(rows.components)))
    levels = _Levels(
        form=FALSE_ALARMS / 4 / max(tests, 1),
        ripple=FALSE_ALARMS / 4 / (len(residual.robot.joints) * len(_AMPLITUDES) * _CUTS),
        dependence=FALSE_ALARMS / 4 / max(sum(len(rows.components) for rows in enough), 1),
    )
    found = [one for rows in enough for one in _of_channel(rows, forms, levels, rng)]
    return tuple(one.pattern for one in sorted(found, key=lambda one: -one.strength))


def candidates(n_joints: int) -> list[Fixed | Periodic]:
    """All forms of dependence on the motion of N joints."""
    joints = range(n_joints)
    return [
        Line(),
        *(Line(joint=joint, own_only=True) for joint in joints),
        *functions_of_time(),
        *(function for joint in joints for function in functions_of(joint)),
        *(function for joint, other in permutations(joints, 2) for function in friction_of(joint, other)),
        *(PerTurn(joint=joint, amplitude=amplitude) for joint in joints for amplitude in _AMPLITUDES),
    ]


def _of_channel(
    rows: Rows, forms: Sequence[Fixed | Periodic], levels: _Levels, rng: np.random.Generator
) -> list[_Found]:
    """Patterns of one channel: the best form of each component, then the best of what that leaves, and so on."""
    left, found = rows.values.copy(), []
    energy, noise = np.sum(left**2, axis=0), np.sum(rows.noise, axis=0)
    without = active = rows.loud(left)
    for _ in range(MOST):
        trials = [tried(form, rows, left, active) for form in forms] if active else []
        chosen = {c: best_of(trials, rows, c, least=LEAST_SHARE * float(energy[c]), level=levels.form) for c in active}
        for c, trial in chosen.items():
            if trial is not None:
                gain = float(trial.gain[:, c].sum())
                pattern, fitted = _pattern(trial.candidate, rows, left[:, c], c, gain / float(energy[c]))
                left[:, c] -= fitted
                found.append(_Found(pattern=pattern, strength=gain / float(noise[c])))
        without = [c for c in without if chosen.get(c) is None]
        active = [c for c in rows.loud(left) if chosen.get(c) is not None]
    found += _ripple(rows, left, found, energy, levels.ripple, rng.spawn(1)[0])
    others = [_catch_all(rows, left[:, c], c, levels.dependence, rng) for c in without]
    return found + [one for one in others if one is not None]


def _ripple(
    rows: Rows, left: Array, found: Sequence[_Found], energy: Array, level: float, rng: np.random.Generator
) -> list[_Found]:
    """What torque repeats with the turns of its motor, where slow misfits hide it; `left` (R, C) is lessened by it.

    Ripple of a fast motor lies above most of what else a model lacks, and is a small share of that.

    Args:
        rows: of a channel.
        left: what the patterns that were found leave of them.
        found: these patterns.
        energy: of each component before them, (C,).
        level: largest probability that a test may have by chance.
        rng: cuts the rows into other halves.
    """
    if rows.channel != "torque":
        return []
    known, more = {one.pattern.component for one in found if one.pattern.kind == "periodic"}, list[_Found]()
    fast, noise = without_slow(rows, left), np.sum(rows.noise, axis=0)
    cuts = [rows, *(rows.redrawn(rng) for _ in range(_CUTS - 1))]
    for c in rows.loud(left):
        if rows.components[c] in known:
            continue
        forms = [PerTurn(joint=c, amplitude=amplitude) for amplitude in _AMPLITUDES]
        trials = [tried(form, cut, fast, [c]) for cut in cuts for form in forms]
        trial = best_of(trials, rows, c, least=LEAST_SHARE * float(np.sum(fast[:, c] ** 2)), level=level)
        if trial is not None:
            gain = float(trial.gain[:, c].sum())
            pattern, fitted = _pattern(trial.candidate, rows, fast[:, c], c, gain / float(energy[c]))
            left[:, c] -= fitted
            more.append(_Found(pattern=pattern, strength=gain / float(noise[c])))
    return more


def _pattern(candidate: Fixed | Periodic, rows: Rows, values: Array, c: int, share: float) -> tuple[Pattern, Array]:
    """The pattern as fitted to all rows, and its part of the residual (R,)."""
    frequency, fitted = _part(candidate, rows, values)
    pattern = Pattern(
        channel=rows.channel,
        component=rows.components[c],
        variable=variable_of(candidate, rows.joints, rows.components[c]),
        kind=candidate.kind,
        frequency=frequency,
        amplitude=float(np.sqrt(2 * np.mean(fitted**2))),
        share=share,
        message="",
    )
    return replace(pattern, message=message(pattern, candidate, rows.joints)), fitted


def _part(candidate: Fixed | Periodic, rows: Rows, values: Array) -> tuple[float | None, Array]:
    """Frequency, if any, and the part of values (R,) that a form explains, fitted to all rows."""
    if isinstance(candidate, Fixed):
        columns = rows.centred(candidate.columns(rows))
        return None, columns @ fit(columns, values)
    peaks = candidate.search(rows, values[:, None], np.ones(len(values), dtype=np.bool_))
    if peaks is None:
        return None, np.zeros_like(values)
    frequency = candidate.refine(rows, values, peaks[0])
    columns = rows.centred(candidate.columns(rows, frequency))
    return frequency, columns @ fit(columns, values)


def _catch_all(rows: Rows, values: Array, c: int, level: float, rng: np.random.Generator) -> _Found | None:
    """What a component depends on that no form explains."""
    form = wandering(rows, values, level) or dependence(rows, values, level, rng)
    if form is None:
        return None
    pattern = Pattern(
        channel=rows.channel,
        component=rows.components[c],
        variable=variable_of(form, rows.joints, rows.components[c]),
        kind="dependence",
        frequency=None,
        amplitude=float(np.sqrt(2 * np.mean(values**2))),
        share=0.0,
        message="",
    )
    pattern = replace(pattern, message=message(pattern, form, rows.joints))
    return _Found(pattern=pattern, strength=form.correlation * float(values @ values / rows.noise[:, c].sum()))
