"""Effects that a log cannot show: those that take columns that it lacks, and those that its motions leave at rest."""

import numpy as np

from ffgym.diagnosis.calibration import Calibration
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.low_speed import knows_low_speed
from ffgym.diagnosis.result import Unjudged
from ffgym.diagnosis.search.found import Found
from ffgym.effects import EFFECTS, ClockEffect, Effect, ModelEffect, TrackerEffect
from ffgym.simulation.plant import Machine

LEAST_SPAN = {"temperature": 5.0, "running": 120.0}
"""Span that a log must have of what an effect varies with: temperature [K], and time since switching on [s]; chosen:
what moves friction by some per cent."""

_NO_FEEDBACK = "the log has no set-points, or no feedback torque (reference.position, feedback.effort)"

_UNITS = {"temperature": "K", "running": "s"}


_OPEN = "it is a number of the model that is not known any better than that: it is fitted beside the causes"


def judgeable_kinds(
    log: Log, machine: Machine, calibration: Calibration, no_servo: str = ""
) -> tuple[list[type[Effect]], tuple[Unjudged, ...]]:
    """Effects that a log may show, and the others with the reason; `no_servo` is that of effects in the servo."""
    judgeable, others = [], []
    for kind in EFFECTS.values():
        reason = _OPEN if kind in calibration.open_numbers else _missing(kind, log, machine)
        if reason == _NO_FEEDBACK:
            reason = no_servo or reason
        if reason:
            others.append(Unjudged(effect=kind.name, joint="", reason=reason))
        else:
            judgeable.append(kind)
    return judgeable, tuple(others)


def _missing(kind: type[Effect], log: Log, machine: Machine) -> str:
    """Why a log cannot show an effect at all; empty if it can."""
    if issubclass(kind, TrackerEffect) and log.tool is None:
        return "the log has no tracked tool position (tcp.position)"
    if issubclass(kind, ClockEffect) and "link.position" in kind.families and log.link is None:
        return "the log has no encoders behind the gearbox (link.position)"
    if kind.side == "controller" and not issubclass(kind, ClockEffect) and not log.shows_servo:
        return _NO_FEEDBACK
    if kind.needs_elasticity and bool(machine.physical.drive.is_rigid.all()):
        return "the joints are described as rigid"
    if kind.at_low_speed and not knows_low_speed(log.robot).any():
        return "the model has no friction of its own at low speed (static equals coulomb), where this effect acts"
    if issubclass(kind, ModelEffect) and any(isinstance(effect, kind) for effect in machine.effects):
        return "the model has it already, and a machine cannot have it twice"
    if kind.needs_tool and log.robot.tool is None:
        return "the robot has no tool"
    for name in kind.varies_with:
        if name == "temperature" and log.temperature is None and machine.climate is None:
            return "the log has no temperature"
        span = _span(log, machine, name)
        if span < LEAST_SPAN[name]:
            return f"{name} changes by {span:.3g} {_UNITS[name]} only, of {LEAST_SPAN[name]:g} that it takes"
    return ""


def _span(log: Log, machine: Machine, name: str) -> float:
    if name == "running":
        lasted = [recording.t[-1] - recording.t[0] for recording in log.recordings]
        return float(np.max(log.started + lasted) - np.min(log.started))
    if log.temperature is not None:
        return float(np.max(np.ptp(log.temperature, axis=(0, 1))))
    if machine.climate is None:
        return 0.0
    at = [machine.climate.at(machine.climate.running_since + float(s)) for s in log.started]
    seen = np.concatenate([climate.temperature(np.array([0.0]), log.robot.n_joints) for climate in at])
    return float(np.max(np.ptp(seen, axis=0)))


def not_excited(found: Found) -> tuple[Unjudged, ...]:
    """Effects that would not show even at the largest plausible size, joint by joint."""
    ranking, candidates = found.rounds[0].ranking, found.candidates
    listed: dict[tuple[str, str], bool] = {}
    for group, most in zip(candidates.groups, ranking.most, strict=True):
        column = candidates.first(group)
        key = (column.effect.name, column.joint)
        listed[key] = listed.get(key, True) and bool(most <= ranking.threshold)
    reason = "these motions would not show even the largest that is plausible above the noise"
    return tuple(Unjudged(effect=e, joint=j, reason=reason) for (e, j), quiet in listed.items() if quiet)
