"""Search for patterns of residuals, strongest first: each is found in what the stronger ones leave."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.patterns.forms import (
    DependenceForm,
    Periodic,
    Variable,
    VariableFunction,
    fit_columns,
    list_functions,
)
from ffgym.diagnosis.patterns.periodic import Amplitude, PerTurn, SpectralLine
from ffgym.diagnosis.patterns.rows import PatternRows, collect_pattern_rows, remove_slow
from ffgym.diagnosis.patterns.significance import (
    Dependence,
    FormTest,
    choose_simplest,
    find_dependence,
    find_wandering,
    judge_form,
)
from ffgym.diagnosis.residual import UNITS, Residual
from ffgym.diagnosis.result import Pattern, PatternKind
from ffgym.diagnosis.settings import settings

_VARIABLES: dict[Variable, str] = {
    "angle": "motor angle",
    "speed": "motor speed",
    "size of speed": "size of the motor speed",
    "acceleration": "motor acceleration",
    "travel": "travel since the last reversal",
    "rest": "time at rest before the move",
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


_Found = tuple[float, Pattern]
"""Energy above the noise that a pattern stands for, and the pattern."""


@dataclass(frozen=True, kw_only=True)
class _Levels:
    """Probabilities of single tests by chance: a quarter of FALSE_ALARMS for forms, ripple and each catch-all."""

    form: float
    ripple: float
    dependence: float


def find_patterns(residual: Residual, rng: np.random.Generator) -> tuple[Pattern, ...]:
    """Find patterns in the residuals of all channels, strongest against the noise floor first; none in noise."""
    limits = settings().patterns
    tables = [collect_pattern_rows(residual, channel, rng) for channel in residual.channels]
    enough = [rows for rows in tables if rows is not None and len(rows.block_starts) >= limits.fewest_blocks]
    # levels of single tests, so that all together raise the false alarms that are allowed
    forms = list_forms(len(residual.robot.joints))
    tests = sum(form.may_act_on(rows, c) for rows in enough for form in forms for c in range(len(rows.components)))
    levels = _Levels(
        form=limits.false_alarms / 4 / max(tests, 1),
        ripple=limits.false_alarms / 4 / (len(residual.robot.joints) * len(_AMPLITUDES) * limits.cuts),
        dependence=limits.false_alarms / 4 / max(sum(len(rows.components) for rows in enough), 1),
    )
    found = [one for rows in enough for one in _search_channel(rows, forms, levels, rng)]
    return tuple(pattern for _, pattern in sorted(found, key=lambda one: -one[0]))


def list_forms(n_joints: int) -> list[VariableFunction | Periodic]:
    """List all forms of dependence on the motion of N joints."""
    joints = range(n_joints)
    return [
        SpectralLine(),
        *(SpectralLine(joint=joint, own_only=True) for joint in joints),
        *list_functions(n_joints),
        *(PerTurn(joint=joint, amplitude=amplitude) for joint in joints for amplitude in _AMPLITUDES),
    ]


def _search_channel(
    rows: PatternRows, forms: Sequence[VariableFunction | Periodic], levels: _Levels, rng: np.random.Generator
) -> list[_Found]:
    """Search one channel: the best form of each component, then the best of what that leaves, and so on."""
    limits = settings().patterns
    left, found, energy = rows.values.copy(), list[_Found](), np.sum(rows.values**2, axis=0)
    without = active = rows.loud(left)
    # take off the best form of each component, and test what it leaves again
    for _ in range(limits.most):
        trials = [judge_form(form, rows, left, active) for form in forms] if active else []
        chosen = {
            c: choose_simplest(trials, rows, c, least=limits.least_share * float(energy[c]), level=levels.form)
            for c in active
        }
        for c, trial in chosen.items():
            if trial is not None:
                left[:, c] -= _adopt(trial, rows, left[:, c], c, energy, found)
        without = [c for c in without if chosen.get(c) is None]
        active = [c for c in rows.loud(left) if chosen.get(c) is not None]
    _find_ripple(rows, left, found, energy, levels.ripple, rng.spawn(1)[0])
    # what a component depends on that no form explains
    for c in without:
        values = left[:, c]
        form = find_wandering(rows, values, levels.dependence) or find_dependence(rows, values, levels.dependence, rng)
        if form is not None:
            strength = form.correlation * float(values @ values / rows.noise[:, c].sum())
            found.append((strength, _describe(form, rows, c, values)))
    return found


def _find_ripple(
    rows: PatternRows, left: Array, found: list[_Found], energy: Array, level: float, rng: np.random.Generator
) -> None:
    """Find what torque repeats with the turns of its motor, where slow misfits hide it.

    Ripple of a fast motor lies above most of what else a model lacks, and is a small share of that. It joins the
    patterns that were `found`, and is taken off what these have `left` (R, C); `energy` (C,) was there before them.
    """
    limits = settings().patterns
    if rows.channel != "torque":
        return
    known, fast = {one.component for _, one in found if one.kind == "periodic"}, remove_slow(rows, left)
    cuts = [rows, *(rows.redraw(rng) for _ in range(limits.cuts - 1))]
    for c in rows.loud(left):
        if rows.components[c] in known:
            continue
        # test all amplitudes on several draws of halves
        forms = [PerTurn(joint=c, amplitude=amplitude) for amplitude in _AMPLITUDES]
        trials = [judge_form(form, cut, fast, [c]) for cut in cuts for form in forms]
        trial = choose_simplest(trials, rows, c, least=limits.least_share * float(np.sum(fast[:, c] ** 2)), level=level)
        if trial is not None:
            left[:, c] -= _adopt(trial, rows, fast[:, c], c, energy, found)


def _adopt(trial: FormTest, rows: PatternRows, values: Array, c: int, energy: Array, found: list[_Found]) -> Array:
    """Fit a form to all rows of `values` (R,), add its pattern to `found`, and return the part that it explains."""
    form, frequency, fitted = trial.candidate, None, np.zeros_like(values)
    if isinstance(form, VariableFunction):
        columns = rows.centre(form.columns(rows))
        fitted = columns @ fit_columns(columns, values)
    elif peaks := form.search(rows, values[:, None], np.ones(len(values), dtype=np.bool_)):
        frequency = form.refine(rows, values, peaks[0])
        columns = rows.centre(form.columns(rows, frequency))
        fitted = columns @ fit_columns(columns, values)
    gain = float(trial.gain[:, c].sum())
    pattern = _describe(form, rows, c, fitted, gain / float(energy[c]), frequency)
    found.append((gain / float(np.sum(rows.noise, axis=0)[c]), pattern))
    return fitted


def _describe(
    form: DependenceForm | Dependence,
    rows: PatternRows,
    c: int,
    part: Array,
    share: float = 0.0,
    frequency: float | None = None,
) -> Pattern:
    """Describe in words the form of a component, the size of that `part` (R,) of it, and the share that it explains."""
    component, joint = rows.components[c], "" if form.joint is None else rows.joints[form.joint]
    words = "motor angle" if isinstance(form, PerTurn) else "time"
    if isinstance(form, VariableFunction | Dependence) and joint:
        words = _VARIABLES.get(form.variable, form.variable)
    named = f"{words} of {joint}" if joint else words
    # words for the form, which says more than the name of a variable
    kind: PatternKind = "dependence"
    match form:
        case SpectralLine():
            how = f"turned over with the direction of {joint}" if joint else "whatever moves"
            kind, says = "line", f"vibration at {frequency:.2f} Hz, {how}"
        case PerTurn():
            how = f"{frequency:.1f} cycles per turn, {_AMPLITUDES[form.amplitude]}"
            kind, says = "periodic", f"periodic in the {named}, {how}"
        case VariableFunction(signed=None):
            kind, says = "function", f"a function of the {named}"
        case VariableFunction(variable="none"):
            kind, says = "sign-locked function", f"goes with the sign of the {named}"
        case VariableFunction(signed=int(other)):
            kind = "sign-locked function"
            says = f"a function of the {named}, times the sign of the motor speed of {rows.joints[other]}"
        case Dependence(joint=None):
            says = "wanders with time, whatever moves"
        case _:
            says = f"depends on the {named}, in none of the forms that are known"
    # amplitude of a sine of the same energy, as readers compare peaks
    amplitude = float(np.sqrt(2 * np.mean(part**2)))
    size = f"{amplitude:.3g} {UNITS[rows.channel]}" + ("" if kind == "dependence" else f", {share:.0%} of the residual")
    return Pattern(
        channel=rows.channel,
        component=component,
        variable=words if joint in ("", component) else named,
        kind=kind,
        frequency=frequency,
        amplitude=amplitude,
        share=share,
        message=f"{rows.channel} of {component}: {says} ({size})",
    )
