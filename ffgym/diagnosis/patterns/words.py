"""Patterns in words."""

from ffgym.diagnosis.patterns.candidate import Candidate
from ffgym.diagnosis.patterns.dependence import Dependence
from ffgym.diagnosis.patterns.functions import Function, Variable
from ffgym.diagnosis.patterns.periodic import Amplitude, PerTurn
from ffgym.diagnosis.residual import UNITS
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
