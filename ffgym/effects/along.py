"""Torques of effects along a recording, where those with a memory must go from sample to sample."""

from collections.abc import Iterator
from dataclasses import fields
from itertools import chain

import numpy as np

from ffgym.effects.effect import TorqueEffect
from ffgym.effects.state import State, Torques

_STATE = tuple(f.name for f in fields(State))


def torques_along(effect: TorqueEffect, states: State, dt: float) -> Torques:
    """What an effect adds at T samples, (T, ..., N) each; a machine that is at rest at the first of them is settled.

    Args:
        effect: of one machine.
        states: at samples `dt` apart; arrays of shape (T, ..., N), e.g. of several motions side by side, or what
            spreads over that.
        dt: sample time [s].
    """
    each = samples(states)
    first = next(each)
    memory = effect.initial_memory(first)
    if not memory.size:
        return effect.torques(states, effect.initial_memory(states), dt)[0]
    if (at_once := effect.torques_over(states, dt)) is not None:
        return at_once
    found = []
    for state in chain([first], each):
        added, memory = effect.torques(state, memory, dt)
        found.append(added)
    names = [f.name for f in fields(Torques) if getattr(found[0], f.name) is not None]
    return Torques(**{name: np.stack([getattr(added, name) for added in found]) for name in names})


def samples(states: State) -> Iterator[State]:
    """The states at each sample in turn, (..., N) each: views, made cheaply, as there are many of them."""
    shape = states.motor_angle.shape
    same, columns = {}, []
    for name in _STATE:
        values = getattr(states, name)
        if np.ndim(values) < len(shape) or len(values) == 1:  # the same at all samples
            same[name] = np.broadcast_to(values, (1, *shape[1:]))[0]
        else:
            columns.append((name, np.broadcast_to(values, shape)))
    for k in range(shape[0]):
        yield State(**same, **{name: column[k] for name, column in columns})
