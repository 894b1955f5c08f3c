"""Robots whose effects act at rest: springs that are bent until they carry the load, servos that hold it."""

import numpy as np

from ffgym.core.types import Array, IntArray
from ffgym.effects import State
from ffgym.robot.drive import Drive
from ffgym.simulation.plant.forces import Forces

_FIRST_BRACKET = 1e-4
"""Deflection [rad] beyond that of linear springs in which to look first; chosen: a third of an arc minute."""
_DOUBLINGS = 20
"""Of that bracket, to 100 rad."""
_HALVINGS = 60
"""Of the bracket, to less than rounding."""
_ROUNDS = 40
"""Of the servo's torque, whose effects are a share of it: 0.3 to this power is below rounding."""


class Settling:
    """What effects of resting simulations `rows` add to gravity and springs, with memories that are relaxed there.

    Everything is elementwise and takes a fixed number of steps, so that a row does not depend on its neighbours.
    """

    def __init__(self, forces: Forces, rows: IntArray, drive: Drive) -> None:
        self._forces, self._chosen, self._drive = forces, forces.choose(rows), drive
        self._bent_rows = forces.bends[rows, None]
        self._state = forces.state(self._chosen)
        self.set_servo(np.zeros_like(self._state.load))

    def set_servo(self, torque: Array) -> None:
        """Let servos hold `torque`, motor side [N m], (B, N)."""
        self._state.feedback_torque = self._state.motor_torque = torque

    def _bent(self, deflection: Array) -> State:
        """State with another deflection [rad], link side."""
        state = self._state
        state.deflection = deflection
        state.load = -state.joint_stiffness * deflection
        state.load_at_motor = self._drive.motor_torque(state.load)
        return state

    def deflection(self, load: Array) -> Array:
        """Deflections [rad] at which springs and effects carry `load`, link side [N m], (B, N); 0 for rigid joints.

        Solves K delta - spring(delta) - link(delta) = -load for each joint by bisection: backlash and hardening are
        steeper than a fixed-point iteration bears.
        """
        stiffness = self._state.joint_stiffness
        elastic = stiffness > 0
        linear = np.divide(-load, stiffness, out=np.zeros_like(load), where=elastic)
        half = np.abs(linear) + _FIRST_BRACKET
        low, high = linear - half, linear + half
        for _ in range(_DOUBLINGS):
            low = np.where(self._pull(low, load) > 0, low - half, low)
            high = np.where(self._pull(high, load) < 0, high + half, high)
            half = 2 * half
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            pull = self._pull(middle, load)
            low, high = np.where(pull < 0, middle, low), np.where(pull > 0, middle, high)
            low, high = np.where(pull == 0, middle, low), np.where(pull == 0, middle, high)
        bent = elastic & self._bent_rows
        return np.where(bent, 0.5 * (low + high), linear)

    def _pull(self, deflection: Array, load: Array) -> Array:
        """What is left of the torque balance of links, (B, N) [N m]; grows with the deflection."""
        added = self._forces.resting(self._chosen, self._bent(deflection))
        pull: Array = self._state.joint_stiffness * deflection + load
        for torque in (added.spring, added.link):
            pull = pull if torque is None else pull - torque
        return pull

    def servo_torque(self, load: Array) -> Array:
        """Torque with which servos hold `load` behind the gearbox [N m] despite the effects, motor side, (B, N)."""
        self._state = state = self._forces.state(self._chosen)
        link = self._forces.resting(self._chosen, state).link
        held = self._drive.motor_torque(load if link is None else load - link)
        self.set_servo(held)
        for _ in range(_ROUNDS):
            motor = self._forces.resting(self._chosen, state).motor
            self.set_servo(held if motor is None else held - motor)
        return state.motor_torque

    def begin(self) -> None:
        """Let effects remember that all is as it is."""
        self._forces.begin(self._chosen, self._state)
