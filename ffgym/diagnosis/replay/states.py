"""States along measured motions as effects see them: friction of bristles, and joints that bend under effects."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.log import Log
from ffgym.diagnosis.replay.recursions import first_order
from ffgym.diagnosis.replay.springs import Brake, Deflection, Springs, between, straight
from ffgym.effects import State, TorqueEffect, Torques
from ffgym.effects.along import iterate_samples
from ffgym.effects.effect import Braking, LinkBrake
from ffgym.effects.together import add, find_rest, relax, sort_effects, step, sum_along
from ffgym.effects.transmission.arm_friction import LinkFriction
from ffgym.robot import RobotDescription
from ffgym.robot.friction import LuGreParameters
from ffgym.simulation.plant import Machine


@dataclass(frozen=True, kw_only=True, eq=False)
class Bristles:
    """Friction of one model along motor speeds, motor side, shape (T, M, N)."""

    torque: Array
    """[N m], viscous part included; opposes the motion."""
    whole: Array
    """The same of all friction, that behind the elasticity included, as if it were at these speeds."""
    sign: Array
    """LuGre-smoothed sign of the motor speed s = sigma_0 z / g(v) [1]."""


def along_speed(friction: LuGreParameters, slip: Array, speed: Array, dt: float, load: float = 0.0) -> Bristles:
    """Friction of bristles along samples `dt` [s] apart, motor side.

    Between two samples the bristle equation is solved exactly for their mean speed; where the speed changes its sign,
    for the mean speed before that and then for the one after it. With the sum of both alone, bristles would still
    pull forwards at the first sample at which the motor is fast again, and their damping would be a peak of torque.

    Args:
        friction: model of all joints.
        slip: speed that moves the bristles [rad/s], shape (T, M, N).
        speed: speed of the motors, which viscous friction sees [rad/s].
        dt: sample time [s].
        load: of the bristles at the first sample, as a share of what tears them off; 0 is relaxed.
    """
    keep, gain = _bristle_factors(friction, slip, dt)
    start = load * friction.stribeck_level(0.0 * slip[0]) / friction.bristle_stiffness
    bristle = first_order(keep, gain, start)
    torque = friction.torque(bristle, slip) + friction.viscous * (speed - slip)
    return Bristles(
        torque=torque,
        whole=torque,
        sign=friction.bristle_stiffness * bristle / friction.stribeck_level(slip),
    )


def friction_on_motors(robot: RobotDescription, slip: Array, speed: Array, dt: float, load: float = 0.0) -> Bristles:
    """Friction of a robot on its motors, along speeds `slip` and `speed` behind the gearbox, as `along_speed`."""
    found = along_speed(robot.friction, robot.drive.motor_angle(slip), robot.drive.motor_angle(speed), dt, load)
    return leave_on_motors(robot, found)


def leave_on_motors(robot: RobotDescription, friction: Bristles) -> Bristles:
    """Leave the part of all friction on motors that is not behind the elasticity of a robot."""
    return replace(friction, torque=(1 - robot.arm_share) * friction.whole)


def along_links(robot: RobotDescription, speed: Array, dt: float) -> Bristles:
    """Friction of a robot along speeds of its links [rad/s], in units of its motors, as if all of it were there."""
    speed = robot.drive.gear_ratio * speed
    return along_speed(robot.friction, speed, speed, dt)


def _bristle_factors(friction: LuGreParameters, slip: Array, dt: float) -> tuple[Array, Array]:
    """Factors (keep, gain) that lead bristles from each sample to the next, shape (T - 1, M, N)."""
    keep, gain = friction.exact_bristle_factors(0.5 * (slip[1:] + slip[:-1]), dt)
    turns = slip[1:] * slip[:-1] < 0.0
    rows = np.flatnonzero(turns.any(axis=(1, 2)))
    if len(rows):
        first, last, turns = slip[:-1][rows], slip[1:][rows], turns[rows]
        before = dt * np.divide(first, first - last, out=np.ones_like(first), where=turns)
        forth, forth_gain = friction.exact_bristle_factors(0.5 * np.where(turns, first, first + last), before)
        back, back_gain = friction.exact_bristle_factors(0.5 * last, dt - before)
        keep[rows], gain[rows] = forth * back, forth_gain * back + back_gain
    return keep, gain


def state_of(log: Log, machine: Machine, bristles: Bristles) -> State:
    """States along the measured motion, before anything is known of springs and loads."""
    none = np.zeros_like(log.q)
    state = State.of(
        machine.physical,
        machine.climate,
        time=log.t[:, None, None],
        joint_angle=log.q,
        joint_speed=log.dq,
        friction_sign=bristles.sign,
        feedback_torque=none if log.feedback is None else log.feedback,
        motor_torque=none,
        deflection=none,
        deflection_rate=none,
    )
    # warming goes on since the start of the session, not of the motion
    state.set_values(running_since=state.running_since + log.started[:, None])
    if log.temperature is not None:
        state.set_values(temperature=log.temperature)
    return state


def arm_effects(machine: Machine) -> list[TorqueEffect]:
    """Effects that act on links, friction behind the elasticity among them."""
    friction = LinkFriction.of(machine.physical)
    beside = () if friction is None else (friction,)
    every = (*machine.torque_effects, *beside)
    return sort_effects(effect for effect in every if effect.side == "link" and not effect.is_null)


def deflect(
    springs: Springs, state: State, effects: list[TorqueEffect], torque: Array, start: Array, dt: float
) -> Deflection:
    """Deflections under `torque` (T, M, N) and what effects add; sample by sample where that depends on them.

    The state is that where joints do not bend yet; about as `start` (M, N) [rad] they bend at the first sample.
    """
    led = sum_along([effect for effect in effects if effect.follows_motor], state, dt)
    load = torque if (push := add(led.spring, led.link)) is None else torque + push
    bending = [effect for effect in effects if not effect.follows_motor]
    if bending:
        return flown(springs, state, bending, load, start, dt)
    bent = springs.bent_by(load[..., None])
    return Deflection(angle=bent.angle[..., 0], rate=bent.rate[..., 0], acceleration=bent.acceleration[..., 0])


class _LinkBrakes(Brake):
    """Friction on links along samples, with its memory and its torque."""

    def __init__(
        self, effects: Sequence[LinkBrake], state: State, first: State, dt: float, parts: Array | None = None
    ) -> None:
        """Begin at rest at the `first` of all samples, of which `state` has the motion of the motors.

        With `parts` (V, 1, N), brakes of V machines side by side, each a part of that of the effects.
        """
        shape = state.motor_angle.shape
        self._effects, self._dt, self._speed = effects, dt, np.broadcast_to(state.joint_speed, shape)
        self._parts = parts
        self._needs_load = any(effect.needs_load for effect in effects)
        self._stiffness, self._damping = state.joint_stiffness, state.joint_damping
        # of each memory, values of one kind lie side by side, as steps ask for them
        self._memories = [np.moveaxis(np.moveaxis(one, -1, 0).copy(), 0, -1) for one in relax(effects, first)]
        self._now = list[Braking]()
        self.joints = np.flatnonzero(np.any([effect.brakes for effect in effects], axis=0))
        near = np.min([effect.reach(dt) for effect in effects], axis=0)
        self._near = np.broadcast_to(near, first.deflection.shape).copy()
        self.wound: Array | None = None
        """Torque by which effects wind the springs at the sample, link side [N m], (M, N)."""
        self.torque = np.zeros((len(self._speed), *first.deflection.shape))
        """Torque at each sample, link side [N m], (T, ..., M, N)."""

    def expect(self, k: int, angle: Array, rate: Array) -> tuple[Array, Array]:
        """Ask all effects for their torques and slopes."""
        load = None
        if self._needs_load:
            load = add(-(self._stiffness * angle + self._damping * rate), self.wound)
        speed, memories = self._speed[k] + rate, self._memories
        now = [effect.brake(speed, load, memories[i], self._dt) for i, effect in enumerate(self._effects)]
        torque, slope = now[0].torque, now[0].slope
        for one in now[1:]:
            torque, slope = torque + one.torque, slope + one.slope
        if self._parts is not None:
            torque, slope = self._parts * torque, self._parts * slope
        self._now, self._torque, self._slope = now, torque, slope
        return torque, slope

    def is_near(self, faster: Array) -> bool:
        """Compare with the rates at which bristles move by a part of their length in a step."""
        return np.count_nonzero(np.abs(faster) <= self._near) == faster.size

    def conclude(self, k: int, faster: Array) -> None:
        """Take memories and the torque along to where the link was faster than expected."""
        self._memories = [one.memory + one.memory_slope * faster[..., None] for one in self._now]
        self.torque[k] = self._torque - self._slope * faster


def flown(
    springs: Springs,
    state: State,
    effects: list[TorqueEffect],
    torque: Array,
    start: Array,
    dt: float,
    parts: Array | None = None,
) -> Deflection:
    """Deflections with effects that depend on them, from the rest in which they balance the load.

    With `parts` (V, 1, N), those of V machines of which each has a part of the friction on links, (T, V, M, N).
    """
    every = springs.substeps
    if every > 1:  # the state at so many steps in each sample, on straight lines
        n = len(state.motor_angle)
        state = state.each(lambda values: straight(values, every) if values.ndim > 1 and len(values) == n else values)
    brakes = [effect for effect in effects if isinstance(effect, LinkBrake)]
    effects = [effect for effect in effects if not isinstance(effect, LinkBrake)]
    each = list(iterate_samples(state) if effects else islice(iterate_samples(state), 1))

    def pull(angle: Array) -> Array:
        """Compute the imbalance of torques at rest; it grows with the deflection."""
        now = each[0].with_values(deflection=angle, deflection_rate=np.zeros_like(angle))
        return springs.restoring(angle) - torque[0] - _behind(step(effects, now, relax(effects, now), dt)[0], angle)

    # begin in equilibrium, with memories that rest there and relaxed bristles
    rest = find_rest(pull, start)
    if parts is not None:
        rest = np.repeat(rest[None], len(parts), axis=0)
    first = each[0].with_values(deflection=rest, deflection_rate=np.zeros_like(rest))
    memories, braking = relax(effects, first), _LinkBrakes(brakes, state, first, dt / every, parts) if brakes else None

    def push(k: int, angle: Array, rate: Array) -> Array:
        each[k].set_values(deflection=angle, deflection_rate=rate)
        added, memories[:] = step(effects, each[k], memories, dt / every)
        if braking is not None:
            braking.wound = added.spring
        return _behind(added, angle)

    # integrate, at several steps a sample where springs are stiff
    given = push if effects else None
    if every == 1:
        bent = springs.integrate(torque, given, rest, braking)
    else:
        bent = springs.finer.integrate(between(torque, every), given, rest, braking).at_every(every)
    return bent if braking is None else replace(bent, braking=braking.torque[::every])


def deflect_by_shares(
    springs: Springs, state: State, robot: RobotDescription, torque: Array, start: Array, shares: Array
) -> list[Deflection]:
    """Deflections of V machines that have `shares` (V, N) of their friction on the links, and nothing else there."""
    dt, whole = springs.dt, np.where(shares.max(axis=0) > 0, 1.0, 0.0)
    friction = LinkFriction(share=whole, friction=robot.friction, gear_ratio=robot.drive.gear_ratio)
    bent = flown(springs, state, [friction], torque, start, dt, shares[:, None])
    assert bent.braking is not None
    each = (np.moveaxis(array, 1, 0) for array in (bent.angle, bent.rate, bent.acceleration, bent.braking))
    return [
        Deflection(angle=angle, rate=rate, acceleration=acceleration, braking=braking)
        for angle, rate, acceleration, braking in zip(*each, strict=True)
    ]


def _behind(added: Torques, angle: Array) -> Array:
    """Torque of effects behind the gearbox, link side [N m], (M, N), where joints bend by `angle` [rad]."""
    total = add(added.spring, added.link)
    return np.zeros_like(angle) if total is None else total
