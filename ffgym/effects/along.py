"""Torques of effects along a recording, where those with a memory must go from sample to sample."""

from dataclasses import fields

import numpy as np

from ffgym.effects.effect import TorqueEffect
from ffgym.effects.state import State, Torques
from ffgym.types import Array


def torques_along(effect: TorqueEffect, states: State, dt: float) -> Torques:
    """What an effect adds at T samples, (T, N) each; a machine that is at rest at the first of them is settled.

    Args:
        effect: of one machine.
        states: at samples `dt` apart; arrays of shape (T, N), or what spreads over that.
        dt: sample time [s].
    """
    shape = states.motor_angle.shape
    memory = effect.initial_memory(_at(states, 0, shape))
    if not memory.size:
        return effect.torques(states, effect.initial_memory(states), dt)[0]
    found: list[Torques] = []
    for k in range(len(states.motor_angle)):
        added, memory = effect.torques(_at(states, k, shape), memory, dt)
        found.append(added)
    return Torques(**{f.name: _stacked([getattr(added, f.name) for added in found]) for f in fields(Torques)})


def _at(states: State, k: int, shape: tuple[int, ...]) -> State:
    """The state at sample k, (N,) each."""
    return State(**{f.name: np.broadcast_to(getattr(states, f.name), shape)[k] for f in fields(State)})


def _stacked(samples: list[Array | None]) -> Array | None:
    given = [sample for sample in samples if sample is not None]
    return np.stack(given) if given else None
