r"""Equations of motion of motors, gearboxes, springs and links, written anew; rigid bodies are Pinocchio's.

With angles of gearbox outputs :math:`p` and soft coordinates :math:`s`, deflections of joints and of the structure, the
links stand at :math:`r = A (p, s)`. Tomei (1991), IEEE TAC 36(10), with the whole mass matrix of the links:

.. math:: (A^T M(r) A + \mathrm{diag}(G^T J G, 0)) (\ddot p, \ddot s) = (G^T (u + u_e - f), -K s - D \dot s + \tau_e)
    - A^T (b(r, \dot r) - \tau_l)

Friction is LuGre's on the motors, and on the links in units of the motors (Canudas de Wit et al. 1995, IEEE TAC 40(3)).
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.climate import Climate
from ffgym.robot import RobotDescription
from scripts.engine.second.arm import PinocchioArm

ROTOR = 1e-9
"""Inertia of the body that the engine wants between motor and spring [kg m^2]."""

State = Mapping[str, Array]
"""Coordinates: angles `p` of gearbox outputs and speeds `dp`, link side; soft coordinates `s` and speeds `ds`; bristles
`z` of motors and `za` of links in units of motors [rad]; `integral` of servos [rad s]; torque of `loop` [N m]."""


class Equation(ABC):
    """Torques that an effect adds, here without a memory; values of the effect are attributes.

    `torques` gives 'motor' on rotors, motor side; 'spring' between gearbox and link, and 'link' on the link from the
    one before it, link side [N m].
    """

    ages_at_once = True
    """False where the first step of the plant still has the memory of rest."""

    step = 0.0
    """Physics step [s] of those who have one."""

    def __init__(self, n: SimpleNamespace, given: Mapping[str, Any]) -> None:
        """Take numbers of the machine and values of the effect."""
        self.n = n
        for name, value in given.items():
            setattr(self, name, np.asarray(value))

    @abstractmethod
    def torques(self, x: SimpleNamespace, memory: Array) -> dict[str, Array]:
        """Torques at a situation."""

    def start(self, x: SimpleNamespace) -> Array:
        """Memory at rest, (M, N)."""
        return np.zeros((0, self.n.size))

    def rate(self, x: SimpleNamespace, memory: Array) -> Array:
        """Rate of the memory."""
        return np.zeros_like(memory)

    def after(self, x: SimpleNamespace, memory: Array, later: SimpleNamespace, h: float) -> Array:
        """Memory a step of `h` [s] later, at the situation `later`."""
        return memory


class FlexibleMachine:
    """One machine, whose numbers `n` may be changed before it moves; states are those of `situation`."""

    def __init__(
        self,
        robot: RobotDescription,
        climate: Climate | None = None,
        structure: Sequence[tuple[str, Array, float]] = (),
    ) -> None:
        """Take over numbers of a description.

        Args:
            robot: the description.
            climate: of the day; None is 20 degC.
            structure: what gives way beside the joints: 'base' or 'bends', compliances about x, y and z or of each
                link [rad/(N m)], and damping over stiffness [s].
        """
        drive, friction, servo = robot.drive, robot.friction, robot.servo
        self.n = n = SimpleNamespace(
            size=robot.n_joints, rigid=np.isinf(drive.joint_stiffness), ratio=drive.gear_ratio,
            gears=np.diag(drive.gear_ratio) + (0 if drive.coupling is None else drive.coupling),
            rotor=drive.rotor_inertia, stiffness=drive.joint_stiffness, damping=drive.joint_damping,
            peak=drive.peak_torque, lag=drive.loop_lag, rate=drive.loop_rate, delay=drive.delay,
            fc=friction.coulomb, fs=friction.static, fv=friction.viscous, vs=friction.stribeck_velocity,
            s0=friction.bristle_stiffness, s1=friction.bristle_damping, share=robot.arm_share,
            kp=servo.position_gain, kv=servo.velocity_gain, ki=servo.integral_gain,
            climate=climate, command_at=None,
        )  # fmt: skip
        self.effects: list[Equation] = []
        self.elastic = np.flatnonzero(~n.rigid)
        self.arm = PinocchioArm(robot, **{part: np.flatnonzero(c).tolist() for part, c, _ in structure})
        given = [(1 / c, t / c) for _, part, t in structure for c in part[part > 0]]
        self._given = np.array(given).reshape(-1, 2).T
        # the links' coordinates of those of motors and springs
        own, soft = len(self.elastic), len(self.elastic) + len(given)
        self.links = np.zeros((self.arm.model.nv, n.size + soft))
        self.links[self.arm.own, np.arange(n.size)] = 1
        self.links[np.array(self.arm.own)[self.elastic], n.size + np.arange(own)] = 1
        self.links[self.arm.structure, n.size + own + np.arange(soft - own)] = 1

    @property
    def damping(self) -> Array:
        """Damping of soft coordinates, (S,)."""
        return np.concatenate([self.n.damping[self.elastic], self._given[1]])

    @property
    def rotors(self) -> Array:
        """Mass matrix of the rotors."""
        n, size = self.n, self.links.shape[1]
        rotors = np.zeros((size, size))
        rotors[: n.size, : n.size] = n.gears.T @ np.diag(n.rotor) @ n.gears
        rotors[self.elastic, self.elastic] += ROTOR
        return rotors

    def spread(self, soft: Array) -> Array:
        """Deflections of all joints (N,); rigid ones have none."""
        full = np.zeros(self.n.size)
        full[self.elastic] = soft[: len(self.elastic)]
        return full

    def situation(
        self,
        time: float,
        state: State,
        wanted: Array,
        *,
        read: tuple[Array, Array] | None = None,
        rigid_load: Array | None = None,
    ) -> SimpleNamespace:
        """Everything that the equations ask for at a state.

        Args:
            time: since the motion began [s].
            state: coordinates.
            wanted: set-points of angles and speeds of motors, and torque, (3, N).
            read: angle and speed of motors as servos know them, (N,) each; None is the true ones.
            rigid_load: torque that links behind rigid joints ask for, link side [N m], (N,).
        """
        n, x = self.n, SimpleNamespace(time=time, **state)
        x.theta, x.omega = n.gears @ x.p, n.gears @ x.dp
        x.delta, x.ddelta = self.spread(x.s), self.spread(x.ds)
        x.q, x.dq = x.p + x.delta, x.dp + x.ddelta
        # a share of friction acts on the link, with bristles of its own
        x.share = np.where(n.rigid, 0.0, n.share)
        x.link_omega = n.ratio * x.dq
        x.level = self.level(x.omega)
        x.sign = n.s0 * x.z / x.level
        x.dz, x.dza = self.bend(x.z, x.omega), self.bend(x.za, x.link_omega)
        x.friction = (1 - x.share) * (n.s0 * x.z + n.s1 * x.dz + n.fv * x.omega)
        x.link_friction = n.ratio * x.share * (n.s0 * x.za + n.s1 * x.dza + n.fv * x.link_omega)
        # servo
        angle, speed = (x.theta, x.omega) if read is None else read
        x.lag = wanted[0] - angle
        asked = n.kp * x.lag + n.kv * (wanted[1] - speed) + n.ki * x.integral + wanted[2]
        x.command = np.clip(asked, -n.peak, n.peak)
        # spring, and what else effects ask for
        x.spring = np.where(n.rigid, 0.0, -np.where(n.rigid, 0.0, n.stiffness) * x.delta - n.damping * x.ddelta)
        x.load = np.where(n.rigid, 0.0 if rigid_load is None else rigid_load, x.spring)
        x.running, x.temperature = time, np.full(n.size, 20.0)
        if n.climate is not None:
            x.running = n.climate.running_since + time
            x.temperature = n.climate.ambient + n.climate.rise * (1 - np.exp(-x.running / n.climate.time_constant))
        return x

    def level(self, v: Array) -> Array:
        """Friction in steady sliding [N m]."""
        n = self.n
        return np.asarray(n.fc + (n.fs - n.fc) * np.exp(-((v / n.vs) ** 2)))

    def bend(self, z: Array, v: Array) -> Array:
        """Rate of LuGre bristles [rad/s]."""
        return np.asarray(v - self.n.s0 * np.abs(v) / self.level(v) * z)

    def forces(self, x: SimpleNamespace, torque: Array, memories: Sequence[Array]) -> Array:
        """Forces on (p, s) at a situation, without Coriolis: motors give `torque`, effects have `memories`."""
        n = self.n
        x.torque = torque
        motor, spring, link = torque - x.friction, x.spring, -x.link_friction
        for effect, memory in zip(self.effects, memories, strict=True):
            added = effect.torques(x, memory)
            motor = motor + added.get("motor", 0.0)
            spring, link = spring + added.get("spring", 0.0), link + added.get("link", 0.0)
        force = np.zeros(self.links.shape[1])
        force[: n.size] = n.gears.T @ motor + link
        own = len(self.elastic)
        force[n.size : n.size + own] = (spring + link)[self.elastic]
        force[n.size + own :] = -self._given[0] * x.s[own:] - self._given[1] * x.ds[own:]
        return force

    def mass(self, x: SimpleNamespace) -> tuple[Array, Array]:
        """Mass matrix of (p, s), and torques of gravity, speed and springs between links."""
        r, dr = self.links @ [*x.p, *x.s], self.links @ [*x.dp, *x.ds]
        bias = self.arm.bias(r, dr) + self.arm.spring_torque(r)
        return self.links.T @ self.arm.mass_matrix(r) @ self.links + self.rotors, self.links.T @ bias

    def accelerations(self, x: SimpleNamespace, torque: Array, memories: Sequence[Array]) -> Array:
        """Accelerations of (p, s)."""
        mass, bias = self.mass(x)
        return np.asarray(np.linalg.solve(mass, self.forces(x, torque, memories) - bias))
