"""Equilibrium at the start: bent springs and servo integrals by bisection of each joint's torque balance."""

from collections.abc import Callable, Sequence

import mujoco
import numpy as np
from mujoco import batch

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array, IntArray
from ffgym.effects.together import find_rest
from ffgym.robot import RobotDescription, model_field
from ffgym.robot.drive import Drive
from ffgym.simulation.plant.engine_state import Addresses
from ffgym.simulation.plant.forces import Forces

_ROUNDS = 40
"""Rounds for the servo's torque, whose effects are a share of it: 0.3 to this power is below rounding."""


class Settling:
    """Compute torques that effects of resting simulations `rows` add to gravity and springs, with relaxed memories.

    Everything is elementwise and takes a fixed number of steps, so that a row does not depend on its neighbours.
    """

    def __init__(self, forces: Forces, rows: IntArray, drive: Drive) -> None:
        self._forces, self._chosen, self._drive = forces, forces.choose(rows), drive
        self._on_links, self._bent_rows = self._chosen.on_links, forces.bends[rows, None]
        self._state = forces.state(self._chosen)
        self.set_servo(np.zeros_like(self._state.load))

    def set_servo(self, torque: Array) -> None:
        """Let servos hold `torque`, motor side [N m], (B, N)."""
        self._state.set_values(feedback_torque=torque, motor_torque=torque, loop_torque=torque)

    def deflection(self, load: Array) -> Array:
        """Deflections [rad] at which springs and effects carry `load`, link side [N m], (B, N); 0 for rigid joints.

        Solves K delta - spring(delta) - link(delta) = -load for each joint.
        """
        stiffness = self._state.joint_stiffness
        elastic = stiffness > 0
        linear = np.divide(-load, stiffness, out=np.zeros_like(load), where=elastic)
        rest = find_rest(lambda deflection: self._pull(deflection, load), linear)
        return np.where(elastic & self._bent_rows, rest, linear)

    def _pull(self, deflection: Array, load: Array) -> Array:
        """Compute the residual of the torque balance of links, (B, N) [N m]; it grows with the deflection."""
        self._state.set_values(deflection=deflection)
        added = self._forces.resting(self._on_links, self._state)
        pull: Array = self._state.joint_stiffness * deflection + load
        for torque in (added.spring, added.link):
            pull = pull if torque is None else pull - torque
        return pull

    def servo_torque(self, load: Array) -> Array:
        """Compute the torque with which servos hold `load` [N m] behind the gearbox despite effects, (B, N)."""
        self._state = state = self._forces.state(self._chosen)
        link = self._forces.resting(self._chosen, state).link
        held = self._drive.motor_torque(load if link is None else load - link)
        self.set_servo(held)
        for _ in range(_ROUNDS):
            motor = self._forces.resting(self._chosen, state).motor
            before, now = state.motor_torque, held if motor is None else held - motor
            self.set_servo(now)
            if np.array_equal(now, before):  # further rounds change nothing
                break
        return state.motor_torque

    def begin(self) -> None:
        """Let effects remember that all is as it is."""
        self._forces.begin(self._chosen, self._state)


_TOLERANCE = 1e-14
"""Change of deflection [rad] at which the search for equilibrium stops: rounding of angles of order 1 rad."""
_TURN = 1e-9
"""Change of deflection [rad] from which on a joint turns back, not rounding; gaps between teeth are far wider."""
_MAX_ITERATIONS = 200
"""A load takes ten; a joint that hangs within its backlash is halved into place, which takes some hundred."""


def bent_by_load(
    engine: batch.Batch,
    at: Addresses,
    rows: IntArray,
    robots: Sequence[RobotDescription],
    *,
    has_springs: bool,
    effects: Callable[[IntArray], Settling] | None = None,
) -> Array:
    """Bend the joints of resting robots until they carry the load; returns its torque, link side [N m], (B, N).

    Solves K delta = -g(q + delta) by fixed-point iteration in the engine, where each robot has its own masses; each row
    stops on its own, whatever the others do. The load is gravity, and springs between links if there are. Effects in
    springs or on links bend them further. A joint that turns back and forth goes half as far each time: within its
    backlash, where nothing carries it, it comes to rest at the lowest place.

    `rows` (B,) are the simulations, `robots` what they are; `has_springs` is of springs between links, and `effects`
    give for simulations what acts on springs and links beside, None for nothing.
    """
    gravity, passive, qpos = engine.bind("qfrc_bias"), engine.bind("qfrc_passive"), engine.bind("qpos")
    # stiffness of gearbox springs, then of joints that effects add
    joints = np.stack([robot.drive.joint_stiffness for robot in robots])[:, at.is_elastic]
    stiffness = np.concatenate([joints, _stiffness_of_extra_joints(engine, at, rows)], axis=1)
    soft, n_own = np.append(at.deflection_qpos, at.extra_qpos), len(at.deflection_qpos)
    moving = np.arange(len(rows))
    last, most = np.zeros((len(rows), soft.size)), np.full((len(rows), soft.size), np.inf)
    # deflection under the load at the pose that the last round gave
    for _ in range(_MAX_ITERATIONS):
        engine.forward(rows[moving], stage=mujoco.mjtStage.mjSTAGE_VEL.value)
        if not soft.size:
            break
        here = np.ix_(rows[moving], soft)
        load = gravity[here]
        if has_springs:  # what is passive but not the joint's own spring
            load = load - (passive[here] + stiffness[moving] * qpos[here])
        update = -load / stiffness[moving]
        if effects is not None:
            full = np.zeros((len(moving), len(at.is_elastic)))
            full[:, at.is_elastic] = load[:, :n_own]
            update[:, :n_own] = effects(rows[moving]).deflection(full)[:, at.is_elastic]
        # bound of the step, halved where it turns back, as in backlash
        step, before = update - qpos[here], last[moving]
        turns = (step * before < 0) & (np.abs(step) > np.maximum(0.5 * np.abs(before), _TURN))
        most[moving] = np.where(turns, 0.5 * np.minimum(most[moving], np.abs(step)), most[moving])
        slowed = np.abs(step) > most[moving]
        step = np.clip(step, -most[moving], most[moving])
        update = np.where(slowed, qpos[here] + step, update)
        # robots that still move
        change = np.abs(step).max(axis=1)
        qpos[here], last[moving] = update, step
        moving = moving[change >= _TOLERANCE]
        if not moving.size:
            break
    else:
        robot = robots[moving[0]]
        raise FFGymError(
            f"Robot {robot.name!r} finds no equilibrium under gravity: joint_stiffness = "
            f"{robot.drive.joint_stiffness} N m/rad is too soft for its masses."
        )
    motors = np.ix_(rows, at.motor_qpos)
    return gravity[motors] - passive[motors] if has_springs else gravity[motors]


def _stiffness_of_extra_joints(engine: batch.Batch, at: Addresses, rows: IntArray) -> Array:
    """Linear stiffness [N m/rad] of joints that effects have added, shape (B, E)."""
    if not at.extra_joint.size:
        return np.zeros((len(rows), 0))
    own = engine.expanded("jnt_stiffness")
    if own is None:
        own = np.tile(model_field(engine.get_model(0), "jnt_stiffness"), (engine.nsim, 1))
    stiffness: Array = np.reshape(own, (engine.nsim, -1))[rows][:, at.extra_joint]
    return stiffness
