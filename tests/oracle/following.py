"""A plant in motion from random states, followed step by step by the equations of a machine."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from ffgym.robot import ModelOptions
from ffgym.simulation.plant import Machine, Plant
from tests.oracle.flexible_machine import FlexibleMachine
from tests.simulation.plant.driving import controls

STEP = 1 / 32000
"""Physics step [s] at which no light link of a robot that ships needs more inertia than it has (docs/physics.md)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """States of one simulation at T + 1 instants, and the set-points of the T steps between."""

    step: float
    controls: np.ndarray
    """Set-points of angles and speeds of motors, and torque, (T, 3, N)."""
    at: SimpleNamespace
    """Arrays by the names that `FlexibleMachine.situation` has for them, (T + 1, ...) each."""
    rest: SimpleNamespace
    """The same at rest, before the motion."""


def random_motions(machine, seed, *, steps=24, h=STEP):
    """Motions of a machine that starts bent, with bent bristles, fast or as slow as motors stick, by random torques."""
    count = 2
    machine = Machine.of(machine)
    plant = Plant(machine, count, options=ModelOptions(physics_dt=h, looks=False))
    robot, at, rng = machine.physical, plant.addresses, np.random.default_rng(seed)
    n = robot.n_joints
    home = np.zeros(n) if robot.work_area is None else robot.work_area.home
    plant.rest(np.tile(home, (count, 1)))
    rest = [states(plant, *(x[i] for x in (plant._qpos, plant._qvel, plant._act))) for i in range(count)]
    soft = np.append(at.deflection_qpos, at.extra_qpos).astype(int)
    low, high = robot.kinematics.range.T  # limits push back
    plant._qpos[:, at.motor_qpos] = np.clip(home + rng.uniform(-0.2, 0.2, (count, n)), low + 0.02, high - 0.02)
    plant._qpos[:, soft] += rng.uniform(-1e-3, 1e-3, (count, len(soft)))
    slow = 2 * robot.friction.stribeck_velocity / robot.drive.gear_ratio
    plant._qvel[:, at.motor_qpos] = rng.uniform(-1, 1, (count, n)) * [np.ones(n), slow]
    plant._qvel[:, soft] = rng.uniform(-0.02, 0.02, (count, len(soft)))
    length = robot.friction.coulomb / robot.friction.bristle_stiffness
    # bristles of both sides
    for places, have in ((at.bristle, at.has_bristle), (at.arm_bristle, at.has_arm_bristle)):
        plant._act[:, places[have]] = (rng.uniform(-0.9, 0.9, (count, n)) * length)[:, have]
    first = [x.copy() for x in (plant._qpos, plant._qvel, plant._act)]
    # set-points so near that most torques are within their limits
    near = plant.state()
    away = 0.3 * robot.drive.peak_torque / robot.servo.position_gain
    position = near.motor_position[:, None] + away * rng.uniform(-1, 1, (count, steps, n))
    speed = near.motor_velocity[:, None] + rng.uniform(-1, 1, (count, steps, n))
    torque = 0.3 * robot.drive.peak_torque * rng.uniform(-1, 1, (count, steps, n))
    rows = controls(plant, position, speed, torque)
    later = plant.advance(rows)
    split = np.stack(plant.split_controls(rows), axis=2)
    return [
        Motion(
            step=h,
            controls=split[i],
            at=states(plant, *(np.vstack([a[i : i + 1], b[i]]) for a, b in zip(first, later, strict=True))),
            rest=rest[i],
        )
        for i in range(count)
    ]


def states(plant, qpos, qvel, act):
    """Coordinates of the equations from the engine's arrays of any leading shape."""
    at, n = plant.addresses, plant.robot.n_joints
    soft = np.append(at.deflection_qpos, at.extra_qpos).astype(int)

    def of_joints(places, have):
        full = np.zeros((*act.shape[:-1], n))
        full[..., have] = act[..., places[have]]
        return full

    return SimpleNamespace(
        p=qpos[..., at.motor_qpos], dp=qvel[..., at.motor_qpos], s=qpos[..., soft], ds=qvel[..., soft],
        z=of_joints(at.bristle, at.has_bristle), za=of_joints(at.arm_bristle, at.has_arm_bristle),
        integral=of_joints(at.integral, at.has_integral), loop=of_joints(at.torque, at.has_torque),
    )  # fmt: skip


def follow(machine, motions):
    """Largest difference of each part of the steps of motions from the equations of a machine, as a share; by name.

    The engine's step is explicit, but implicit in linear damping of springs and motors; bristles and torque loops are
    exact for speed and command of a step. Forces on each coordinate are shares of all that accelerates it.
    """
    found = []
    for motion in motions:
        follower = Follower(machine, motion)
        steps = [follower.step(k) for k in range(len(motion.controls))]
        found += steps[1:]  # the load before the first step is not told
    return {name: max(step[name] for step in found) for name in found[0]}


class Follower:
    """Equations of a machine that go along with a motion: state of each step from the plant, memories of their own."""

    def __init__(self, machine, motion) -> None:
        drive = machine.robot.drive
        effects = {effect.name: effect.values() for effect in machine.effects if effect.name != "resolver_ripple"}
        if np.any(drive.delay):  # one after the other
            late = effects.get("torque_delay", {"delay": 0.0, "lag": 0.0 * drive.delay})
            effects["torque_delay"] = {"delay": late["delay"] + drive.delay, "lag": late["lag"]}
        self.own, self.motion = FlexibleMachine(machine.robot, effects, machine.climate), motion
        for effect in self.own.effects:
            effect.step = motion.step
        n = self.own.n
        self.reader, self.rigid_load = Reader(machine, motion.step), None
        self.loops = (n.lag > 0) | np.isfinite(n.rate)
        # at rest servos hold what springs carry; the state before the first is one without speed
        nothing, h = np.zeros((3, n.size)), motion.step
        still = self.own.situation(0.0, *vars(motion.rest).values(), nothing)
        self.reader.begin(still)
        first = {name: values[0] for name, values in vars(motion.at).items()}
        first |= {"p": first["p"] - h * first["dp"], "s": first["s"] - h * first["ds"]}
        first |= {"dp": 0 * first["dp"], "ds": 0 * first["ds"]}
        self.x = self.own.situation(0.0, *first.values(), nothing)
        self.x.held = self.x.torque = self._held(still)
        self.memories = [effect.start(self.x) for effect in self.own.effects]

    def _held(self, still):
        """Torque of motors that keeps a machine at rest, whatever effects do [N m]."""
        own, n = self.own, self.own.n
        _, bias = own.mass(still)
        still.held = np.zeros(n.size)
        for _ in range(40):  # effects that are a share of the torque change it by less than 0.4
            still.torque = still.held
            left = own.forces(still, still.held, [effect.start(still) for effect in own.effects]) - bias
            still.held = still.held - np.linalg.solve(n.gears.T, left[: n.size])
        return still.held

    def step(self, k):
        """Differences in the step k, as shares by name."""
        own, n, h, at = self.own, self.own.n, self.motion.step, self.motion.at
        now, later = ({name: values[i] for name, values in vars(at).items()} for i in (k, k + 1))
        read = self.reader.read(n.gears @ now["p"], n.gears @ now["dp"])
        x = own.situation(k * h, *now.values(), self.motion.controls[k], read=read, rigid_load=self.rigid_load)
        pairs = zip(own.effects, self.memories, strict=True)
        self.memories = [e.after(self.x, memory, x, h) if k or e.ages_at_once else memory for e, memory in pairs]
        self.x = x
        torque = self._torque_of_loops(x)
        # what accelerates each coordinate, implicit in the damping of motors and springs
        mass, bias = own.mass(x)
        force = own.forces(x, torque, self.memories) - bias
        damping = np.zeros_like(mass)
        alone = np.count_nonzero(n.gears, axis=1) == 1  # of motors that other axes turn too, damping is explicit
        damping[: n.size, : n.size] = n.gears.T @ np.diag(alone * (1 - x.share) * n.fv) @ n.gears
        damping[n.size :, n.size :] = np.diag(own.d)
        given = np.append(later["dp"] - now["dp"], later["ds"] - now["ds"]) / h
        self.reader.look(n.gears @ later["p"], n.gears @ later["dp"])
        # what links behind rigid joints asked for, with viscous friction of the next step
        ddq = np.linalg.solve(mass, (mass + h * damping) @ given)
        asked = ((mass - own.rotors) @ ddq + bias)[: n.size]
        self.rigid_load = asked + n.gears.T @ (n.fv * (x.omega - n.gears @ later["dp"]))
        # state of servos and bristles
        most = np.divide(n.peak, n.ki, out=np.zeros(n.size), where=n.ki > 0)
        wound = np.clip(x.integral + h * x.lag, -most, most)
        holds = (n.ki > 0) & (np.abs(x.integral) <= most)  # more than the motor gives, if it cannot hold the load
        on_link = x.share > 0
        return {
            "force": share((mass + h * damping) @ given - force, np.abs(mass) @ np.abs(given)),
            "torque of loops": share((later["loop"] - torque)[self.loops], n.peak[self.loops]),
            "integral": share((later["integral"] - wound)[holds], most[holds]),
            "bristles": share((later["z"] - self._bent(x.z, x.omega)) * (x.share < 1), n.fc / n.s0),
            "bristles of links": share((later["za"] - self._bent(x.za, x.link_omega)) * on_link, n.fc / n.s0),
        }

    def _torque_of_loops(self, x):
        """Torque at the end of the step, exact for its command and limited in its mean rate."""
        n, h = self.own.n, self.motion.step
        left = np.exp(-np.divide(h, n.lag, out=np.full(n.size, np.inf), where=n.lag > 0))
        change = np.clip((x.command - x.loop) * (1 - left), -n.rate * h, n.rate * h)
        return np.where(self.loops, x.loop + change, x.command)

    def _bent(self, z, speed):
        """Bristles after a step at constant speed: exponentially towards where they slide."""
        n = self.own.n
        level = n.fc + (n.fs - n.fc) * np.exp(-((speed / n.vs) ** 2))
        end = np.sign(speed) * level / n.s0
        return end + (z - end) * np.exp(-n.s0 * np.abs(speed) / level * self.motion.step)


def share(difference, whole):
    return np.abs(difference / whole).max(initial=0.0)


class Reader:
    """What servos know of their motors: the truth, with the error of its sensor, in steps where resolvers are read."""

    def __init__(self, machine, h) -> None:
        drive = machine.physical.drive
        self.every, self.period, self.count = round(drive.resolver_period / h), drive.resolver_period, 0
        self.angle = 2 * np.pi / 2**machine.physical.sensors.encoder_bits
        self.ripples = [effect.values() for effect in machine.effects if effect.name == "resolver_ripple"]

    def begin(self, x):
        """Read at rest."""
        sensed, _ = self._sensed(x.theta, x.omega)
        self.known = np.round(sensed / self.angle) * self.angle, 0 * sensed

    def look(self, theta, omega):
        """Read after a step, if it is time."""
        self.count += 1
        if self.count == self.every:
            sensed, _ = self._sensed(theta, omega)
            now = np.round(sensed / self.angle) * self.angle
            self.known, self.count = (now, (now - self.known[0]) / self.period), 0

    def read(self, theta, omega):
        """Angle and speed that servos know."""
        return self.known if self.every else self._sensed(theta, omega)

    def _sensed(self, theta, omega):
        for r in self.ripples:
            phase = r["cycles"] * theta + r["phase"]
            omega = omega * (1 + r["amplitude"] * r["cycles"] * np.cos(phase))
            theta = theta + r["amplitude"] * np.sin(phase)
        return theta, omega
