"""Effects behind the gearbox in model feed-forward: deflection of springs that are not linear, and torque on the link.

In the quasi-static balance of a link, with all torques link side and the deflection delta of link behind gearbox,

    K delta + needed - spring(delta) - link(delta) = 0

`needed` moves the arm along the reference. The left side rises with delta, so that its root is found by narrowing an
interval, however steep a hardening spring is. Where teeth have room between them (backlash), the load decides on which
side of the gap the spring is; a motor cannot jump from one to the other, and crosses while the load is about zero.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ffgym.agents.model_memory import Carried
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.effects import State, TorqueEffect
from ffgym.effects.together import relax, sort_effects, step
from ffgym.effects.transmission.backlash import Backlash
from ffgym.simulation.plant import Machine

REACH = 1e-3
"""Deflection [rad] beyond that of the linear spring within which the root is sought; chosen: three arc minutes, more
than gearboxes of any make lose."""
PARTS = 16
"""Parts into which the interval is cut in one evaluation, a power of two; chosen: sixteen states cost hardly more than
one."""
ROUNDS = 9
"""Rounds of cutting, to 3e-14 rad."""
SECANTS = 8
"""Most secants that guess the root; chosen: where friction slips, two or three meet it."""
CROSSING = 4
"""Samples before and after a change of the load's sign in which a motor crosses a gap; chosen: of 1 to 16, 4 leaves the
smallest path error with gaps of 0.01 to 0.2 mrad on circles at 10 to 100 mm/s."""
LOOSE = 1e-9
"""Deflection of the spring [rad] below which the load at rest does not decide where in the gap the teeth are."""

_CELLS = PARTS**ROUNDS
"""Cells of the last round."""
_NEAR = np.arange(-1, 3)
"""Borders about a guess, by number of cells: a root on a border is in either cell, as rounding decides."""
_BITS = PARTS.bit_length() - 1
"""Bits of the number of a cell that one round decides."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SpringEffects:
    """Effects that act on springs and links, of one machine."""

    machine: Machine

    @cached_property
    def effects(self) -> tuple[TorqueEffect, ...]:
        """Effects on springs and links without gaps, in the order in which a plant adds them up."""
        chosen = (e for e in self.machine.torque_effects if e.side == "link" and not isinstance(e, Backlash))
        return tuple(sort_effects(chosen))

    @cached_property
    def _still(self) -> State:
        """State of the machine but for its motion; servo and bristles do not act on springs and links."""
        robot = self.machine.physical
        none = np.zeros(robot.n_joints)
        return State.of(robot, self.machine.climate, time=none, bristle=none, feedback_torque=none, command=none)

    @cached_property
    def _rigid(self) -> BoolArray | None:
        """Mask of rigid joints, (N,); None if there are none."""
        rigid = self.machine.physical.drive.is_rigid
        return rigid if rigid.any() else None

    @cached_property
    def _stiffness(self) -> Array:
        """Stiffness of the springs [N m/rad], (N,); 0 for rigid joints."""
        drive = self.machine.physical.drive
        return np.where(drive.is_rigid, 0.0, drive.joint_stiffness)

    @cached_property
    def half_gap(self) -> Array:
        """Half the room between teeth [rad], link side, shape (N,)."""
        gaps = [effect.half_gap for effect in self.machine.torque_effects if isinstance(effect, Backlash)]
        return sum(gaps, np.zeros(self.machine.robot.n_joints))

    def rest(self, needed: Array, q: Array) -> tuple[Carried, list[Array]]:
        """Find the torque carried where the robot rests at `q` (..., N), and the memories of effects there."""
        none = np.zeros_like(q)
        memories = relax(self.effects, self._state(q, none, none, none, none))
        carried, _ = self._solve_balance(lambda bent: self._state(q, none, bent, none, bent), needed, memories, 1.0)
        return self._beyond_gap(carried, self.machine.physical.drive.joint_stiffness * LOOSE), memories

    def next(
        self, needed: Array, q: Array, dq: Array, start: Array, before: Carried, memories: Sequence[Array], dt: float
    ) -> tuple[Carried, list[Array]]:
        """Find the torque carried at a sample, and the memories of effects after it.

        Args:
            needed: torque that moves the arm [N m], link side, (..., N).
            q: reference [rad], (..., N).
            dq: its speed [rad/s], (..., N).
            start: torque of a linear spring that bends as at the start of the motion [N m], (..., N).
            before: torque carried at the sample before.
            memories: memories of effects, (..., N, M) each.
            dt: time between samples [s].
        """
        drive = self.machine.physical.drive
        started, last = -start / drive.joint_stiffness, -before.bend / drive.joint_stiffness

        def state(bent: Array) -> State:
            return self._state(q, dq, bent, (bent - last) / dt, started)

        carried, later = self._solve_balance(state, needed, memories, dt)
        return self._beyond_gap(carried, CROSSING * np.abs(carried.load - before.load)), later

    def _beyond_gap(self, carried: Carried, full: Array) -> Carried:
        """Add the gap, on the side where the load presses the teeth; across it all from `full` load on."""
        if not self.half_gap.any():
            return carried
        pressed = np.divide(carried.load, full, out=np.sign(carried.load), where=full > 0)
        side = np.minimum(np.maximum(pressed, -1.0), 1.0)
        smooth = side * (1.5 - 0.5 * side * side)  # so that speed does not jump either
        stiffness = self.machine.physical.drive.joint_stiffness
        across = np.where(self.half_gap > 0, stiffness, 0.0) * self.half_gap * smooth
        return replace(carried, bend=carried.bend + across)

    def _solve_balance(
        self, state: Callable[[Array], State], needed: Array, memories: Sequence[Array], dt: float
    ) -> tuple[Carried, list[Array]]:
        """Solve the balance of the links for the deflection, by the equation in the head of this file."""
        if not self.effects:
            return Carried(load=needed, bend=needed, reaction=np.zeros_like(needed)), []
        rigid, stiffness = self._rigid, self._stiffness

        def pull(bent: Array) -> Array:
            added, _ = step(self.effects, state(bent), memories, dt)
            balance: Array = stiffness * bent + needed
            for torque in (added.spring, added.link):
                balance = balance if torque is None else balance - torque
            return balance if rigid is None else np.where(rigid, bent, balance)  # which has its root, too

        bent = find_rising_root(pull, -needed / self.machine.physical.drive.joint_stiffness, REACH)
        bent = bent if rigid is None else np.where(rigid, 0.0, bent)
        added, later = step(self.effects, state(bent), memories, dt)
        load = needed if added.link is None else needed - added.link
        bend = -stiffness * bent
        bend = bend if rigid is None else np.where(rigid, load, bend)
        reaction = np.zeros_like(needed) if added.motor is None else added.motor
        return Carried(load=load, bend=bend, reaction=reaction), later

    def _state(self, q: Array, dq: Array, bent: Array, rate: Array, started: Array) -> State:
        """Build the state with deflection `bent`; motors are displaced by it less the deflection at the start [rad]."""
        return self._still.with_values(
            joint_angle=q + started - bent, joint_speed=dq - rate, deflection=bent, deflection_rate=rate
        )


def find_rising_root(rising: Callable[[Array], Array], middle: Array, reach: float) -> Array:
    """Find the root of a rising function of each entry, within `reach` of `middle` (..., N).

    It is the middle of the cell in which `cut_to_root` ends. Secants guess that cell; where the function does not
    change its sign there, the interval is cut. Each entry is sought by itself, so that none depends on the others.
    """
    low = middle - reach
    guess = (_guess_root(rising, middle, reach) - low) / (2 * reach) * _CELLS
    cell = np.minimum(np.maximum(guess, -_NEAR[0]), _CELLS - _NEAR[-1]).astype(np.int64)
    borders = _borders(low, reach, cell + _NEAR.reshape(-1, *[1] * cell.ndim))
    below = rising(borders) < 0
    if not below[0].all() or below[-1].any():
        return cut_to_root(rising, middle, reach)
    border = np.take_along_axis(borders, np.sum(below, axis=0, keepdims=True) - 1, axis=0)[0]
    return border + reach / _CELLS


def cut_to_root(rising: Callable[[Array], Array], middle: Array, reach: float) -> Array:
    """Find the root by cutting the interval into parts in a fixed number of rounds; arguments as of the above."""
    low, width = middle - reach, 2 * reach
    cuts = (np.arange(1, PARTS) / PARTS).reshape(-1, *[1] * middle.ndim)
    for _ in range(ROUNDS):
        below = np.sum(rising(low + width * cuts) < 0, axis=0)
        low, width = low + width * (below / PARTS), width / PARTS
    return low + 0.5 * width


def _guess_root(rising: Callable[[Array], Array], middle: Array, reach: float) -> Array:
    """Guess the root by secants, to a tenth of a cell where they converge."""
    last, now = middle + 1e-3 * reach, middle
    at_last, at_now = rising(np.stack([last, now]))
    for _ in range(SECANTS):
        slope = at_now - at_last
        move = np.divide(at_now * (now - last), slope, out=np.zeros_like(now), where=slope != 0)
        last, at_last = now, at_now
        now = np.minimum(np.maximum(now - move, middle - reach), middle + reach)
        if np.all(np.abs(now - last) < 0.2 * reach / _CELLS):
            break
        at_now = rising(now)
    return now


def _borders(low: Array, reach: float, cells: IntArray) -> Array:
    """Compute lower borders of cells (K, ..., N), added up as `cut_to_root` does."""
    rounds = np.arange(ROUNDS).reshape(-1, *[1] * cells.ndim)
    parts = (cells >> _BITS * (ROUNDS - 1 - rounds)) & (PARTS - 1)
    lengths = 2 * reach / PARTS ** (rounds + 1)
    return np.add.accumulate(np.concatenate([np.broadcast_to(low, (1, *cells.shape)), lengths * parts]))[-1]
