"""What effects on the motors ask for within a control step."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.agents.effects.states import Place, States
from ffgym.core.types import Array
from ffgym.effects import State, TorqueEffect
from ffgym.effects.along import samples

ROUNDS = 5
"""Of the search for the command whose effects are a share of it: 0.1 to this power is below what matters."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Motors:
    """Effects that act on the motors alone, of one machine."""

    states: States
    effects: tuple[TorqueEffect, ...]

    @classmethod
    def of(cls, states: States) -> "Motors":
        """Those of a machine."""
        chosen = [effect for effect in states.machine.torque_effects if effect.side != "link"]
        return cls(states=states, effects=tuple(sorted(chosen, key=lambda effect: effect.name)))

    def rest(self, place: Place) -> tuple[Array, list[Array]]:
        """What effects add to motors at rest [N m], (..., N), and what they remember there."""
        none, added = np.zeros_like(place.load), np.zeros_like(place.load)
        memories: list[Array] = []
        for _ in range(ROUNDS + 1):
            state = self.states.at(place, bristle=none, command=place.needed - added)
            memories = [effect.initial_memory(state) for effect in self.effects]
            added = none
            for effect, memory in zip(self.effects, memories, strict=True):
                added = _with(added, effect.torques(state, memory, 1.0)[0].motor)
        return added, memories

    def within(
        self, between: Place, bristles: Array, friction: Array, memories: Sequence[Array], dt: float
    ) -> tuple[Array, list[Array]]:
        """What effects add within a control step [N m], motor side, (S, ..., N), and what they remember after it.

        Args:
            between: where motors and links are in the middle of S sub-steps, (S, ..., N).
            bristles: deflection of the bristles there [rad], (S, ..., N).
            friction: LuGre friction there [N m], (S, ..., N).
            memories: what effects remember before, (..., N, M) each.
            dt: length of the step [s].
        """
        needed = between.needed + friction
        added, later = np.zeros_like(needed), list[Array]()
        if not self.effects:
            return added, later
        states = self.states.at(between, bristle=bristles, command=needed)
        for effect, memory in zip(self.effects, memories, strict=True):
            if memory.shape[-1]:
                torque, memory = _stepped(effect, states, memory, dt / len(needed))
                added = added + torque
            later.append(memory)
        return added + self._at_once(states, needed - added, memories), later

    def _at_once(self, states: State, needed: Array, memories: Sequence[Array]) -> Array:
        """What effects without memory add to a command that gives `needed` with them [N m], (S, ..., N)."""
        added = np.zeros_like(needed)
        for _ in range(ROUNDS):
            states.motor_torque = self.states.limited(needed - added)
            before, added = added, np.zeros_like(needed)
            for effect, memory in zip(self.effects, memories, strict=True):
                if not memory.shape[-1]:
                    added = _with(added, effect.torques(states, memory, 1.0)[0].motor)
            if np.array_equal(before, added):  # further rounds change no bit
                break
        return added


def _stepped(effect: TorqueEffect, states: State, memory: Array, dt: float) -> tuple[Array, Array]:
    """What an effect with memory adds at sub-steps (S, ..., N), and what it remembers at their end."""
    torques = []
    for state in samples(states):
        added, memory = effect.torques(state, memory, dt)
        torques.append(np.zeros_like(state.load) if added.motor is None else added.motor)
    return np.stack(torques), memory


def _with(total: Array, more: Array | None) -> Array:
    return total if more is None else total + more
