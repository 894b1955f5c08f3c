r"""Several effects together: the one sum of their torques, of a plant, of a replay and of feed-forward from a model.

Effects on springs and links come first. By the torque with which an effect winds the spring, the load is larger for all
effects after it.

Outputs that lead their motors by :math:`e_i(\theta)`, as waves of a kinematic error, wind the spring by torques
:math:`\tau_i`. What acts back on the motor is the whole load times the slope of all of them,

.. math:: -(\tau_l + \sum_i \tau_i) \sum_j \partial e_j / \partial \theta

of which each effect by itself knows :math:`-(\tau_l + \sum_{j \le i} \tau_j)\, \partial e_i / \partial \theta`. The
rest is added here: without it, two waves would make energy that one wave of the same shape does not.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, BoolArray
from ffgym.effects.along import torques_along
from ffgym.effects.effect import Effect, TorqueEffect
from ffgym.effects.state import State, Torques

E = TypeVar("E", bound=Effect)

_FIRST_REACH = 1e-4
"""Deflection [rad] beyond that of linear springs in which a rest is looked for first; chosen: a third of an
arc minute."""
_DOUBLINGS = 20
"""Doublings of that reach, to 100 rad."""
_HALVINGS = 60
"""Halvings of the bracket, to less than rounding."""


def sort_effects(effects: Iterable[E]) -> list[E]:
    """Sort effects into the order in which they act, so that sums do not depend on how they were listed."""
    return sorted(effects, key=lambda effect: (effect.side != "link", effect.name))


def step(
    effects: Sequence[TorqueEffect],
    state: State,
    memories: Sequence[Array],
    dt: float,
    present: Sequence[BoolArray | None] | None = None,
) -> tuple[Torques, list[Array]]:
    """Sum torques of effects at a state.

    Args:
        effects: in the order in which they act.
        state: at which they are asked, (..., N).
        memories: what each remembers, (..., N, M).
        dt: time to the next state [s].
        present: which machines have each effect, (B, 1); None is all.

    Returns:
        Torques of all effects, and what each remembers `dt` later.
    """
    later: list[Array] = []

    def ask(effect: TorqueEffect, state: State) -> Torques:
        found = effect.torques(state, memories[len(later)], dt)
        if not isinstance(found, tuple) or len(found) != 2 or not isinstance(found[0], Torques):
            got = type(found).__name__
            raise FFGymError(f"torques of effect {effect.name!r} must return Torques and the memory, got {got}.")
        later.append(found[1])
        return found[0]

    return _sum(effects, state, ask, present), later


def relax(effects: Sequence[TorqueEffect], state: State) -> list[Array]:
    """Compute memories of effects of machines that rest at `state`."""
    return [effect.initial_memory(state) for effect in effects]


def sum_along(effects: Sequence[TorqueEffect], states: State, dt: float) -> Torques:
    """Sum torques of effects, in the order in which they act, at T samples `dt` [s] apart, (T, ..., N) each."""
    return _sum(effects, states, lambda effect, now: torques_along(effect, now, dt))


def _sum(
    effects: Sequence[TorqueEffect],
    state: State,
    ask: Callable[[TorqueEffect, State], Torques],
    present: Sequence[BoolArray | None] | None = None,
) -> Torques:
    total, slopes = Torques(), None
    for k, effect in enumerate(effects):
        here, added = None if present is None else present[k], ask(effect, state)
        spring = _where(here, added.spring)
        total.motor = add(total.motor, _where(here, added.motor))
        # outputs that lead their motors act back on these by the slopes of one another
        slope = None if spring is None else _where(here, effect.lead_slope(state))
        if spring is not None and slope is not None:
            if slopes is not None:
                total.motor = add(total.motor, -spring * slopes)
            slopes = add(slopes, slope)
        total.link = add(total.link, _where(here, added.link))
        if spring is not None:
            total.spring = add(total.spring, spring)
            state = state.with_values(wound=total.spring)
    return total


def add(total: Array | None, more: Array | None) -> Array | None:
    """Add what there is; None is nothing."""
    if more is None:
        return total
    return more if total is None else total + more


def _where(present: BoolArray | None, torque: Array | None) -> Array | None:
    """Torque of those machines that have an effect; others are not touched, whatever rounding does."""
    return torque if present is None or torque is None else np.where(present, torque, 0.0)


def find_rest(pull: Callable[[Array], Array], near: Array) -> Array:
    """Find deflections (..., N) at which `pull`, which grows with the deflection of its own joint, is 0; by bisection.

    Backlash and hardening are steeper than a fixed-point iteration bears. In a gap, where nothing pulls, a place in it
    is taken, `near` itself if that is one. Each joint is looked for by itself in a fixed number of steps, so that it
    does not depend on others.
    """
    reach: Array = np.abs(near) + _FIRST_REACH
    low, high = near - reach, near + reach
    # what is not yet between both ends; those that are stay as they are
    below, above = True, True
    for _ in range(_DOUBLINGS):
        if below:
            wrong = pull(low) > 0
            low, below = np.where(wrong, low - reach, low), bool(wrong.any())
        if above:
            wrong = pull(high) < 0
            high, above = np.where(wrong, high + reach, high), bool(wrong.any())
        reach = 2 * reach
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        value = pull(middle)
        low, high = np.where(value <= 0, middle, low), np.where(value >= 0, middle, high)
    rest: Array = 0.5 * (low + high)
    return rest
