"""Steps of a second engine by the rule of MuJoCo, so that what differs are equations, not step sizes.

The step is explicit, but implicit in linear damping of springs and motors; bristles and torque loops are exact for
speed and command of a step, and resolvers are read after it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from ffgym.core.types import Array
from ffgym.robot import RobotDescription
from scripts.engine.second.machine import Equation, FlexibleMachine, State

_SAGGING = 60
"""Rounds in which springs bend under gravity; each is some thousandths of the one before."""


class TorqueDelay(Equation):
    """Dead time, then a lag: rows are the commands of past steps, the latest first, and the torque given last."""

    delay: Array
    lag: Array
    ages_at_once = False
    length = 60

    def start(self, x: SimpleNamespace) -> Array:
        """Commands that hold the machine."""
        return np.tile(x.held, (self.length + 1, 1))

    def torques(self, x: SimpleNamespace, memory: Array) -> dict[str, Array]:
        """Torque that is given beyond the command."""
        if self.n.command_at is None:
            return {"motor": self.after(x, memory, x, self.step)[-1] - x.torque}
        given = np.where(self.lag > 0, memory[-1], self._due_at(x.time))
        return {"motor": given - x.torque}

    def rate(self, x: SimpleNamespace, memory: Array) -> Array:
        """Rate of the lagging torque, for commands that are known at all times."""
        rate = np.zeros_like(memory)
        late = self._due_at(x.time) - memory[-1]
        rate[-1] = np.divide(late, self.lag, out=np.zeros_like(late), where=self.lag > 0)
        return rate

    def _due_at(self, time: float) -> Array:
        return np.array([self.n.command_at(time - delay)[j] for j, delay in enumerate(self.delay)])

    def after(self, x: SimpleNamespace, memory: Array, later: SimpleNamespace, h: float) -> Array:
        """Commands move up by one, those that are due are interpolated."""
        commands = np.vstack([x.torque, memory[:-1]])
        steps = np.arange(len(commands)) * h
        due = np.array([np.interp(d, steps, commands[:, j]) for j, d in enumerate(self.delay)])
        return np.vstack([commands[:-1], due + (memory[-1] - due) * left_after(self.lag, h)])


def left_after(lag: Array, h: float) -> Array:
    """Share of a distance that a lag leaves after a step; 0 without a lag."""
    return np.asarray(np.exp(-np.divide(h, lag, out=np.full(len(lag), np.inf), where=lag > 0)))


class Reader:
    """What servos know of their motors: the truth, with errors of sensors, in steps where resolvers are read."""

    def __init__(self, robot: RobotDescription, h: float, ripples: Sequence[Mapping[str, Any]] = ()) -> None:
        """Make it.

        Args:
            robot: the description.
            h: physics step [s].
            ripples: values of effects resolver_ripple.
        """
        self.every, self.period, self.count = round(robot.drive.resolver_period / h), robot.drive.resolver_period, 0
        self.angle, self.ripples = 2 * np.pi / 2**robot.sensors.encoder_bits, ripples
        self.known = np.zeros(robot.n_joints), np.zeros(robot.n_joints)

    def begin(self, x: SimpleNamespace) -> None:
        """Read at rest."""
        self.known = self._steps(x.theta, x.omega), 0 * x.theta

    def look(self, theta: Array, omega: Array) -> None:
        """Read after a step, if it is time."""
        self.count += 1
        if self.count == self.every:
            now = self._steps(theta, omega)
            self.known, self.count = (now, (now - self.known[0]) / self.period), 0

    def read(self, theta: Array, omega: Array) -> tuple[Array, Array]:
        """Angle and speed that servos know."""
        return self.known if self.every else self._sensed(theta, omega)

    def _steps(self, theta: Array, omega: Array) -> Array:
        return np.asarray(np.round(self._sensed(theta, omega)[0] / self.angle) * self.angle)

    def _sensed(self, theta: Array, omega: Array) -> tuple[Array, Array]:
        for r in self.ripples:
            phase = r["cycles"] * theta + r["phase"]
            omega = omega * (1 + r["amplitude"] * r["cycles"] * np.cos(phase))
            theta = theta + r["amplitude"] * np.sin(phase)
        return theta, omega


@dataclass(frozen=True, kw_only=True, eq=False)
class Step:
    """What the equations say of a step."""

    x: SimpleNamespace
    """Situation before it."""
    later: dict[str, Array]
    """State after it."""
    mass: Array
    """Mass matrix of (p, s)."""
    bias: Array
    """Torques of gravity, speed and springs between links."""
    implicit: Array
    """Matrix that accelerations are multiplied by, mass and damping over the step."""
    force: Array
    """What that product is."""


class Stepper:
    """Memories of a machine that go along with its states, which may come from here or from the plant."""

    def __init__(self, own: FlexibleMachine, reader: Reader, h: float, rest: State, first: State) -> None:
        """Begin a motion.

        Args:
            own: the machine.
            reader: of its motors.
            h: physics step [s].
            rest: state at rest, in which effects have their memories.
            first: state from which the motion begins.
        """
        self.own, self.reader, self.h, self.k = own, reader, h, 0
        self.rigid_load: Array | None = None
        for effect in own.effects:
            effect.step = h
        # at rest servos hold what springs carry; the state before the first is one without speed
        nothing = np.zeros((3, own.n.size))
        still = own.situation(0.0, rest, nothing)
        reader.begin(still)
        before = {**first, "p": first["p"] - h * first["dp"], "s": first["s"] - h * first["ds"]}
        self.x = own.situation(0.0, before | {"dp": 0 * first["dp"], "ds": 0 * first["ds"]}, nothing)
        self.x.held = self.x.torque = self._held(still)
        self.memories = [effect.start(self.x) for effect in own.effects]

    def _held(self, still: SimpleNamespace) -> Array:
        """Torque of motors that keeps a machine at rest, whatever effects do [N m]."""
        own, n = self.own, self.own.n
        _, bias = own.mass(still)
        still.held = np.zeros(n.size)
        for _ in range(40):  # effects that are a share of the torque change it by less than 0.4
            still.torque = still.held
            left = own.forces(still, still.held, [effect.start(still) for effect in own.effects]) - bias
            still.held = still.held - np.linalg.solve(n.gears.T, left[: n.size])
        return np.asarray(still.held)

    def step(self, state: State, wanted: Array) -> Step:
        """Compute a step from a state with set-points (3, N)."""
        own, n, h = self.own, self.own.n, self.h
        read = self.reader.read(n.gears @ state["p"], n.gears @ state["dp"])
        x = own.situation(self.k * h, state, wanted, read=read, rigid_load=self.rigid_load)
        pairs = zip(own.effects, self.memories, strict=True)
        self.memories = [e.after(self.x, memory, x, h) if self.k or e.ages_at_once else memory for e, memory in pairs]
        self.x, self.k = x, self.k + 1
        torque = self._torque_of_loops(x)
        # what accelerates each coordinate, implicit in the damping of motors and springs
        mass, bias = own.mass(x)
        force = own.forces(x, torque, self.memories) - bias
        damping = np.zeros_like(mass)
        alone = np.count_nonzero(n.gears, axis=1) == 1  # of motors that other axes turn too, damping is explicit
        damping[: n.size, : n.size] = n.gears.T @ np.diag(alone * (1 - x.share) * n.fv) @ n.gears
        damping[n.size :, n.size :] = np.diag(own.damping)
        implicit = mass + h * damping
        gained = h * np.linalg.solve(implicit, force)
        dp, ds = x.dp + gained[: n.size], x.ds + gained[n.size :]
        later = {
            "p": x.p + h * dp,
            "dp": dp,
            "s": x.s + h * ds,
            "ds": ds,
            "z": self._bent(x.z, x.omega) * (x.share < 1),
            "za": self._bent(x.za, x.link_omega) * (x.share > 0),
            "integral": self._integrated(x),
            "loop": np.where(self.loops, torque, 0.0),
        }
        return Step(x=x, later=later, mass=mass, bias=bias, implicit=implicit, force=force)

    def observe(self, step: Step, later: State) -> None:
        """Take over what a step has brought."""
        n, h = self.own.n, self.h
        self.reader.look(n.gears @ later["p"], n.gears @ later["dp"])
        # what links behind rigid joints asked for, with viscous friction of the next step
        given = np.append(later["dp"] - step.x.dp, later["ds"] - step.x.ds) / h
        ddq = np.linalg.solve(step.mass, step.implicit @ given)
        asked = ((step.mass - self.own.rotors) @ ddq + step.bias)[: n.size]
        self.rigid_load = asked + n.gears.T @ (n.fv * (step.x.omega - n.gears @ later["dp"]))

    @property
    def loops(self) -> Array:
        """True for motors whose torque lags its command, or is limited in its rate, (N,)."""
        return np.asarray((self.own.n.lag > 0) | np.isfinite(self.own.n.rate))

    def _torque_of_loops(self, x: SimpleNamespace) -> Array:
        """Torque at the end of the step, exact for its command and limited in its mean rate."""
        n, h = self.own.n, self.h
        change = np.clip((x.command - x.loop) * (1 - left_after(n.lag, h)), -n.rate * h, n.rate * h)
        return np.where(self.loops, x.loop + change, x.command)

    def _integrated(self, x: SimpleNamespace) -> Array:
        """Integrals after a step; limited, or with MuJoCo's `pid` stopped, where they ask for the peak torque."""
        n, total = self.own.n, x.integral + self.h * x.lag
        most = np.divide(n.peak, n.ki, out=np.zeros(n.size), where=n.ki > 0)
        stopped = np.where(x.integral * np.sign(x.lag) < most, total, x.integral)
        return np.where(self.loops, np.clip(total, -most, most), stopped)

    def _bent(self, z: Array, speed: Array) -> Array:
        """Bristles after a step at constant speed: exponentially towards where they slide."""
        n, level = self.own.n, self.own.level(speed)
        end = np.sign(speed) * level / n.s0
        return np.asarray(end + (z - end) * np.exp(-n.s0 * np.abs(speed) / level * self.h))


def second_engine(robot: RobotDescription, h: float, pose: Array) -> tuple[Stepper, dict[str, Array]]:
    """Put a robot without effects, but with the delay of its drives, to rest with its motors at a pose (N,).

    Returns:
        What makes its steps of `h` [s], and the state at rest: springs carry gravity, integrals of servos hold it.
    """
    own = FlexibleMachine(robot)
    if np.any(robot.drive.delay):
        own.effects.append(TorqueDelay(own.n, {"delay": robot.drive.delay, "lag": 0 * robot.drive.delay}))
    n, state = own.n, {"p": pose, "s": np.zeros(len(own.elastic))}
    state |= {name: np.zeros(n.size) for name in ("dp", "z", "za", "integral", "loop")} | {"ds": 0 * state["s"]}
    for _ in range(_SAGGING):
        _, load = own.mass(own.situation(0.0, state, np.zeros((3, n.size))))
        state["s"] = -load[n.size :] / n.stiffness[own.elastic]
    held = np.linalg.solve(n.gears.T, load[: n.size])
    state["integral"] = np.divide(held, n.ki, out=np.zeros(n.size), where=n.ki > 0)
    stepper = Stepper(own, Reader(robot, h), h, state, state)
    state["loop"] = np.where(stepper.loops, np.clip(held, -n.peak, n.peak), 0.0)
    return stepper, state
