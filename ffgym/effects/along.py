"""Torques of effects along a recording, where those with a memory must go from sample to sample."""

from collections.abc import Iterator
from dataclasses import fields

import numpy as np

from ffgym.effects.effect import TorqueEffect
from ffgym.effects.state import State, Torques


def torques_along(effect: TorqueEffect, states: State, dt: float) -> Torques:
    """Compute torques of an effect at T samples, (T, ..., N) each; a machine at rest at the first of them is settled.

    Args:
        effect: of one machine.
        states: at samples `dt` apart; arrays of shape (T, ..., N), e.g. of several motions side by side, or what
            spreads over that.
        dt: sample time [s].
    """
    shape = states.motor_angle.shape
    memory = effect.initial_memory(states.each(lambda values: np.broadcast_to(values, shape)[0]))
    if not memory.size:
        return effect.torques(states, effect.initial_memory(states), dt)[0]
    if (at_once := effect.torques_over(states, dt)) is not None:
        return at_once
    found = []
    for state in iterate_samples(states):
        added, memory = effect.torques(state, memory, dt)
        found.append(added)
    names = [f.name for f in fields(Torques) if getattr(found[0], f.name) is not None]
    return Torques(**{name: np.stack([getattr(added, name) for added in found]) for name in names})


def iterate_samples(states: State) -> Iterator[State]:
    """Yield the states at each sample in turn, (..., N) each: views, made cheaply, as there are many of them."""
    shape, names = states.motor_angle.shape, states.names()
    for name in names:  # what follows from the rest is computed once, for all samples
        getattr(states, name, None)
    same, columns = {}, []
    for name, values in vars(states).items():
        if name not in names or values is None:
            same[name] = values
        elif np.ndim(values) < len(shape) or len(values) == 1:  # the same at all samples
            same[name] = np.broadcast_to(values, (1, *shape[1:]))[0]
        else:
            columns.append((name, np.broadcast_to(values, shape)))
    for k in range(shape[0]):
        state = object.__new__(State)
        vars(state).update(same)
        vars(state).update([(name, column[k]) for name, column in columns])
        yield state
