"""Effects that are no cause, with the reason: not in the log, not excited, or no better than chance; and a preview.

The preview replays once and simulates nothing, so that it has neither a threshold nor rivals: it is quick, and no
verdict.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ffgym.diagnosis.log import Log
from ffgym.diagnosis.noise import compute_torque_noise
from ffgym.diagnosis.normal_equations import Values
from ffgym.diagnosis.nuisance import ParameterPrior, list_nuisance_parameters
from ffgym.diagnosis.replay import predict, replay
from ffgym.diagnosis.resampling import cut_blocks, make_half_folds
from ffgym.diagnosis.residual_rows import compute_residuals, describes_low_speed, find_valid_rows
from ffgym.diagnosis.result import Cause, Pattern, Rival, UnjudgedEffect
from ffgym.diagnosis.search.candidates import build_candidates
from ffgym.diagnosis.search.rounds import SearchResult
from ffgym.diagnosis.sensitivity import compute_sensitivities
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.solving import screen
from ffgym.effects import EFFECTS, ClockEffect, Effect, ModelEffect, ResolverEffect, TrackerEffect
from ffgym.simulation.plant import Machine

LEAST_SPAN = {"temperature": 5.0, "running": 120.0}
"""Span that a log must have of what an effect varies with: temperature [K], and time since switching on [s]; chosen:
what moves friction by some per cent."""

_NO_FEEDBACK = "the log has no set-points, or no feedback torque (reference.position, feedback.effort)"

_UNITS = {"temperature": "K", "running": "s"}


_OPEN = "it is a number of the model that is not known any better than that: it is fitted beside the causes"


def sort_effects(
    log: Log, machine: Machine, prior: ParameterPrior, no_servo: str = ""
) -> tuple[list[type[Effect]], tuple[UnjudgedEffect, ...]]:
    """Sort out effects that a log cannot show, with the reason; `no_servo` is that of effects in the servo."""
    judgeable, others = [], []
    for kind in EFFECTS.values():
        reason = _OPEN if kind in prior.open_numbers else _explain_missing(kind, log, machine)
        if reason == _NO_FEEDBACK:
            reason = no_servo or reason
        if reason:
            others.append(UnjudgedEffect(effect=kind.name, joint="", reason=reason))
        else:
            judgeable.append(kind)
    return judgeable, tuple(others)


def _explain_missing(kind: type[Effect], log: Log, machine: Machine) -> str:
    """Explain why a log cannot show an effect at all; empty if it can."""
    # signals that the effect shows in
    if issubclass(kind, TrackerEffect) and log.tool is None:
        return "the log has no tracked tool position (tcp.position)"
    if issubclass(kind, ClockEffect) and "link.position" in kind.families and log.link is None:
        return "the log has no encoders behind the gearbox (link.position)"
    if kind.side == "controller" and not issubclass(kind, ClockEffect) and not log.shows_servo:
        return _NO_FEEDBACK
    # parts of the nominal model that the effect acts on
    if kind.needs_elasticity and bool(machine.physical.drive.is_rigid.all()):
        return "the joints are described as rigid"
    if kind.at_low_speed and not describes_low_speed(log.robot).any():
        return "the model has no friction of its own at low speed (static equals coulomb), where this effect acts"
    if issubclass(kind, ModelEffect) and any(isinstance(effect, kind) for effect in machine.effects):
        return "the model has it already, and a machine cannot have it twice"
    if kind.needs_tool and log.robot.tool is None:
        return "the robot has no tool"
    # variables that the effect depends on, which must change enough to tell it from a constant
    for name in kind.varies_with:
        if name == "temperature" and log.temperature is None and machine.climate is None:
            return "the log has no temperature"
        span = _measure_span(log, machine, name)
        if span < LEAST_SPAN[name]:
            return f"{name} changes by {span:.3g} {_UNITS[name]} only, of {LEAST_SPAN[name]:g} that it takes"
    return ""


def _measure_span(log: Log, machine: Machine, name: str) -> float:
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


def list_not_excited(found: SearchResult) -> tuple[UnjudgedEffect, ...]:
    """List effects that would stay below the threshold even at their largest plausible size, joint by joint."""
    ranking, candidates = found.rounds[0].ranking, found.candidates
    listed: dict[tuple[str, str], bool] = {}
    for group, most in zip(candidates.groups, ranking.most, strict=True):
        column = candidates.first(group)
        key = (column.effect.name, column.joint)
        listed[key] = listed.get(key, True) and bool(most <= ranking.threshold)
    reason = "these motions would not show even the largest that is plausible above the noise"
    return tuple(UnjudgedEffect(effect=e, joint=j, reason=reason) for (e, j), quiet in listed.items() if quiet)


_QUIET = "it explains no more of motions that were not used than chance, or than a cause must"


def add_leads(
    patterns: Sequence[Pattern],
    causes: Sequence[Cause],
    rivals: Sequence[Rival],
    not_excited: Sequence[UnjudgedEffect],
    not_judgeable: Sequence[UnjudgedEffect],
) -> tuple[Pattern, ...]:
    """Add to patterns the effects that have their form, each with the reason why it is no cause."""
    unjudged = (*not_judgeable, *not_excited)
    found = []
    for pattern in patterns:
        kinds = [kind for kind in find_effects_of_form(pattern) if kind.side == "motor" or pattern.channel != "servo"]
        reasons = [_explain(kind.name, pattern.component, causes, rivals, unjudged) for kind in kinds]
        leads = tuple(f"{kind.title}: {reason}" for kind, reason in zip(kinds, reasons, strict=True))
        found.append(replace(pattern, leads=leads))
    return tuple(found)


def find_effects_of_form(pattern: Pattern) -> list[type[Effect]]:
    """Find effects whose equation has the form of a pattern of its own joint, the nearest first.

    Of those that are as near, torques come before springs, and what acts before what is measured.
    """
    form = (pattern.kind, pattern.variable)
    found = [kind for kind in EFFECTS.values() if form in kind.patterns]
    return sorted(
        found, key=lambda kind: (kind.patterns.index(form), issubclass(kind, ResolverEffect), kind.needs_elasticity)
    )


def _explain(
    effect: str, joint: str, causes: Sequence[Cause], rivals: Sequence[Rival], unjudged: Sequence[UnjudgedEffect]
) -> str:
    """Explain why an effect of a joint does not explain a pattern."""
    here = ("", joint)
    if any(cause.effect == effect and cause.joint in here for cause in causes):
        return "it is a cause; what is left has another form than its equation"
    for one in unjudged:
        if one.effect == effect and one.joint in here:
            return one.reason
    lost = [rival for rival in rivals if rival.effect == effect and rival.joint in here]
    return lost[0].reason if lost else _QUIET


@dataclass(frozen=True, kw_only=True)
class Preview:
    """Effect that would explain most of the torque before a full diagnosis, if one stands out."""

    effect: type[Effect] | None
    joint: str
    share: float
    """Share of the residual's energy above noise, on halves of motions that were not fitted."""

    @property
    def sentence(self) -> str:
        """Sentence for the terminal."""
        if self.effect is None:
            return (
                "Preview, at torque alone: no effect before the gearbox stands out. What repeats with the turn of a "
                "motor, and the arm, are not examined yet."
            )
        where = f" of {self.joint}" if self.joint else ""
        return (
            f"Preview, at torque alone: {self.effect.title}{where} would explain {self.share:.0%} of what noise and "
            f"calibration do not; rivals, chance and the arm are not examined yet."
        )


def preview(log: Log, nominal: Machine, prior: ParameterPrior) -> Preview:
    """Screen the effects before the gearbox on the torque of a log."""
    # residual of torque in units of its noise
    run = replay(log.torque_alone, nominal)
    residual = compute_residuals(run.log, predict(run))["torque"]
    values: Values = {("torque", j): residual[..., j : j + 1] for j in range(residual.shape[2])}
    weights: Values = {("torque", j): 1 / column for j, column in enumerate(compute_torque_noise(run).T)}
    blocks = cut_blocks(find_valid_rows(run.log), log.sampling.row_dt)
    # effects whose columns take no arm
    kinds, _ = sort_effects(run.log, nominal, prior)
    plain = [kind for kind in kinds if kind.side == "motor" and not issubclass(kind, ResolverEffect)]
    candidates = build_candidates(
        list_nuisance_parameters(run, prior), compute_sensitivities(run, plain, {}), blocks, weights
    )
    if not len(blocks) or not candidates.groups:
        return Preview(effect=None, joint="", share=0.0)
    # held-out gain of the best effect as a share of what is above the noise
    equations = candidates.design.form_equations(values)
    gain, left = screen(
        equations, make_half_folds(blocks), candidates.nuisance_places, candidates.groups, candidates.priors
    )
    best = int(np.argmax(gain[:, 0]))
    above = float(left[0] - equations.rows.sum())
    share = float(gain[best, 0]) / above if above > 0 else 0.0
    if share < settings().verdict.stands_out:
        return Preview(effect=None, joint="", share=max(share, 0.0))
    first = candidates.first(candidates.groups[best])
    return Preview(effect=first.effect, joint=first.joint, share=min(share, 1.0))
