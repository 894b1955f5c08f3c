"""Problem that all fits of a diagnosis share, and tangents: changes of predictions by each number that is fitted.

The problem is a log with weights and blocks, its nominal replay and bias, and nuisance parameters with their columns.
Tangents are differences of replays to first order: only what an exchange of effects changes is computed anew.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.diagnosis.fit.hypothesis import Hypothesis, exchange_effects
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.normal_equations import DesignMatrix, Values, build_design_matrix
from ffgym.diagnosis.nuisance import NuisanceParameter, RowOffset, is_row_offset
from ffgym.diagnosis.perturbation import (
    Parts,
    Perturbation,
    perturb,
    perturb_motion,
    perturb_numbers,
    propagate,
    replay_change,
    shift_clocks,
)
from ffgym.diagnosis.replay import Replay, predict_feedback, predict_tracker
from ffgym.diagnosis.resampling import TimeBlocks
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.solving import Priors
from ffgym.effects import ClockEffect, ModelEffect, NativeEffect, TorqueEffect, TrackerEffect
from ffgym.effects.effect import Effect
from ffgym.simulation.plant import Machine

HELD = 1e-6
"""Standard deviations within which a calibration error is held; bounds must lie apart."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FitProblem:
    """A log, and all that does not depend on what is fitted to it."""

    log: Log
    nominal: Machine
    blocks: TimeBlocks
    weights: Values
    nuisance_columns: Sequence[Parts]
    """Columns of nuisance parameters, per standard deviation."""
    nuisances: tuple[NuisanceParameter, ...]
    """Nuisance parameters of those columns."""
    like: Replay
    """Nominal replay of the log, whose parts serve other replays."""
    bias: Mapping[Channel, Array]
    """Difference of replay and simulation of one model, (R, M, C), by steps of time; taken off every residual."""
    floor: Mapping[Channel, Array] = field(default_factory=dict)
    """RMS of noise alone, (M, C), without uncertainty of single rows; empty where it is not needed."""
    described: Mapping[tuple[Channel, int], float] = field(default_factory=dict)
    """Energy over that of noise, by component, that the model as described leaves, where this one has other numbers."""

    def inexact(self, component: tuple[Channel, int]) -> float:
        """Compute the energy over noise that fitted numbers may leave: they are fitted in steps."""
        return settings().search.inexact_numbers * max(self.described.get(component, 1.0) - 1.0, 0.0)

    def certain(self, component: tuple[Channel, int]) -> float:
        """Compute the share of a component's noise energy that is not uncertainty of single rows, from 0 to 1."""
        channel, c = component
        if channel not in self.floor:
            return 1.0
        weight = np.broadcast_to(self.weights[component], self.blocks.of_row.shape)
        counted = (weight > 0) & (self.blocks.of_row >= 0)
        certain = np.square(weight * self.floor[channel][:, c])[counted]
        return float(np.mean(certain)) if len(certain) else 0.0

    def nuisance_priors(self, hypotheses: Sequence[Hypothesis] = ()) -> Priors:
        """Build priors of nuisance parameters beside hypotheses, in standard deviations.

        A nuisance parameter that is a number of a cause is held: it is one number, with one prior.
        """
        if not self.nuisances:
            bound = np.full(len(self.nuisance_columns), settings().prior.bound)
            return Priors(precision=np.ones(len(bound)), low=-bound, high=bound)
        n = self.log.robot.n_joints
        is_cause = np.array(
            [any(is_parameter_of(nuisance, one, n) for one in hypotheses) for nuisance in self.nuisances]
        )
        low, high = np.array([nuisance.limits for nuisance in self.nuisances]).T
        low, high = np.where(is_cause, -HELD, low), np.where(is_cause, HELD, high)
        return Priors(precision=np.ones(len(low)), low=low, high=high)

    def as_described(self, hypotheses: Sequence[Hypothesis]) -> tuple[Hypothesis, ...]:
        """Refer hypotheses to the machine as it is described: add what its numbers were moved by before."""
        n, found = self.log.robot.n_joints, []
        for one in hypotheses:
            values = dict(one.values)
            for nuisance in self.nuisances:
                name = nuisance.column.parameter
                if is_parameter_of(nuisance, one, n) and name in values and nuisance.column.part is None:
                    share = one.kind.parameters()[name].unit == "1"
                    more, at = values[name], nuisance.at * nuisance.sigma
                    values[name] = (1 + more) * (1 + at) - 1 if share else more + at
            found.append(replace(one, values=values))
        return tuple(found)

    @cached_property
    def last_replays(self) -> dict[tuple[Any, ...], Replay]:
        """Last replays of the nominal machine with hypotheses, by these."""
        return {}

    @cached_property
    def design(self) -> DesignMatrix:
        """Design matrix of the nuisance parameters, weighted."""
        return build_design_matrix(self.blocks, self.nuisance_columns, self.weights)

    def with_bias(self, bias: Mapping[Channel, Array]) -> Self:
        """Exchange the bias, and keep the design matrix and replays, which do not depend on it and take long."""
        other = replace(self, bias=bias)
        other.__dict__.update(design=self.design, last_replays=self.last_replays)
        return other


def is_parameter_of(nuisance: NuisanceParameter, hypothesis: Hypothesis, n_joints: int) -> bool:
    """Tell whether a nuisance parameter is a number of a hypothesis."""
    column = nuisance.column
    if column.effect is RowOffset:
        return is_row_offset(hypothesis.kind, n_joints)
    is_there = (column.effect, column.joint) == (hypothesis.kind, hypothesis.joint)
    return is_there and column.parameter not in hypothesis.null


def split_components(residual: Mapping[Channel, Array]) -> Values:
    """Split residuals (R, M, C) by component, (R, M, 1) each."""
    return {(channel, k): rows[..., k : k + 1] for channel, rows in residual.items() for k in range(rows.shape[2])}


def compute_exchange_changes(run: Replay, machines: Sequence[Machine]) -> list[Parts]:
    """Compute the change of all predictions for each of several machines in place of that of the replay."""
    # torques of all machines pass through the springs of the arm together, as one solution serves many loads
    known: dict[TorqueEffect, Perturbation] = {}
    pushes = [_perturb_exchange(run, machine, known) for machine in machines]
    found: list[Parts] = []
    for machine, pushed in zip(machines, propagate(run, pushes), strict=True):
        gone, come = _list_exchange(run.machine, machine)
        both = (*gone, *come)
        # an effect with joints of its own has no torque that acts on the nominal arm: replay it
        if any(isinstance(effect, ModelEffect) for effect in both):
            found.append(replay_change(run, machine))
            continue
        # add the changes by trackers, clocks and the controller along the same motion
        parts = dict(pushed)
        if run.log.tool is not None and any(isinstance(effect, TrackerEffect) for effect in both):
            every = run.log.sampling.stride
            seen = predict_tracker(run, machine, every) - predict_tracker(run, run.machine, every)
            for k in range(3):
                parts["tool", k] = parts["tool", k] + seen[..., k]
        if any(isinstance(effect, ClockEffect) for effect in both):
            for key, rows in shift_clocks(run, gone, come).items():
                parts[key] = parts[key] + rows
        if any(effect.side == "controller" for effect in both) and run.log.shows_servo:
            servo = run.log.sampling(
                predict_feedback(run.read, machine.physical) - predict_feedback(run.read, run.robot)
            )
            parts |= {("servo", j): servo[..., j] for j in range(run.robot.n_joints)}
        found.append(parts)
    return found


def _list_exchange(before: Machine, after: Machine) -> tuple[list[Effect], list[Effect]]:
    """List effects that go, and effects that come."""
    gone = [effect for effect in before.effects if effect not in after.effects]
    return gone, [effect for effect in after.effects if effect not in before.effects]


def _perturb_exchange(run: Replay, machine: Machine, known: dict[TorqueEffect, Perturbation]) -> Perturbation:
    """Compute the perturbation by an exchange of machines; perturbations of effects are kept in `known`."""
    gone, come = _list_exchange(run.machine, machine)
    # effects that change numbers of the description: one perturbation by all new numbers
    total = Perturbation()
    if any(isinstance(effect, NativeEffect) for effect in (*gone, *come)):
        total = perturb_numbers(run, machine.physical)
    # torques add up: subtract those that are gone, and add those that come
    for sign, effects in ((-1.0, gone), (1.0, come)):
        for effect in effects:
            if isinstance(effect, TorqueEffect):
                if effect not in known:
                    known[effect] = perturb(run, effect)
                total = total.plus(known[effect], sign)
    # motors truly were elsewhere, as another resolver read what was read
    if machine.resolver_effects != run.machine.resolver_effects:
        angle, speed = run.state.motor_angle, run.state.motor_speed
        was, is_now = run.machine.read_by_resolver(angle, speed), machine.read_by_resolver(angle, speed)
        total = total.plus(perturb_motion(run, run.robot.drive.joint_angle(was[0] - is_now[0])))
    return total


def compute_tangents(
    run: Replay, before: Machine, hypotheses: Sequence[Hypothesis], known: Mapping[int, Sequence[Parts]] | None = None
) -> list[Parts]:
    """Compute one column per free number of all `hypotheses`, per its practical step.

    `run` is of the machine that has them in that order, `before` the machine without them; columns of some may be
    `known`, by their places.
    """
    known = known or {}
    # machines with one free number moved by its practical step, for finite differences
    machines, steps = [], []
    for i, hypothesis in enumerate(hypotheses):
        for k in range(0 if i in known else len(hypothesis.list_free())):
            machine, step = _nudge(run.machine, len(before.effects) + i, hypothesis, k)
            machines.append(machine)
            steps.append(step)
    # changes by all machines at once, put back in the order of the hypotheses
    parts = iter(zip(compute_exchange_changes(run, machines), steps, strict=True))
    columns: list[Parts] = []
    for i, hypothesis in enumerate(hypotheses):
        if i in known:
            columns += known[i]
            continue
        for _, (one, step) in zip(hypothesis.list_free(), parts, strict=False):
            columns.append({key: values / step for key, values in one.items()})
    return columns


def _nudge(machine: Machine, place: int, hypothesis: Hypothesis, k: int) -> tuple[Machine, float]:
    """Nudge number `k` of the hypothesis at `place` up, or down at its bound; return the machine and the change."""
    free = hypothesis.list_free()
    for change in (free[k].nudge, -free[k].nudge):
        changes = [0.0] * len(free)
        changes[k] = change
        if not free[k].low <= free[k].value + changes[k] <= free[k].high:
            continue
        effects = list(machine.effects)
        effects[place] = hypothesis.move(changes).effect(machine.robot)
        beside = exchange_effects(machine, effects)
        if beside is not None:
            return beside, change / free[k].step
    raise FFGymError(f"{free[k].name} of {hypothesis.label} = {free[k].value:g} can be neither higher nor lower.")
