r"""Equations of motion of motors, gearboxes, springs and links, written anew; rigid bodies are Pinocchio's.

With angles of gearbox outputs :math:`p` and soft coordinates :math:`s`, deflections of joints and of the structure, the
links stand at :math:`r = A (p, s)`. Tomei (1991), IEEE TAC 36(10), with the whole mass matrix of the links:

.. math:: (A^T M(r) A + \mathrm{diag}(G^T J G, 0)) (\ddot p, \ddot s) = (G^T (u + u_e - f), -K s - D \dot s + \tau_e)
    - A^T (b(r, \dot r) - \tau_l)

Friction is LuGre's on the motors, and on the links in units of the motors (Canudas de Wit et al. 1995, IEEE TAC 40(3)).
"""

from types import SimpleNamespace

import numpy as np

from tests.oracle.equations import EQUATIONS, NATIVE, STRUCTURE
from tests.oracle.pinocchio_arm import PinocchioArm

ROTOR = 1e-9
"""Inertia of the body that the engine wants between motor and spring [kg m^2]."""


class FlexibleMachine:
    """One machine: a description, effects by name with their values, and a climate; states are those of `situation`."""

    def __init__(self, robot, effects=None, climate=None, command_at=None) -> None:
        """Take over numbers of a description and change them by native effects.

        Args:
            robot: the description.
            effects: values of effects by their names.
            climate: of the day; None is 20 degC.
            command_at: torque that drives are asked for at a time [N m], for delays; None without.
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
            climate=climate, command_at=command_at,
        )  # fmt: skip
        values = effects or {}
        structure = {}
        if (tilts := values.get("base_flexibility")) is not None:
            structure["base"] = np.flatnonzero(tilts["compliance"]).tolist()
        if (bends := values.get("link_flexibility")) is not None:
            structure["bends"] = np.flatnonzero(bends["compliance"]).tolist()
        self.arm = PinocchioArm(robot, **structure)
        for name, given in values.items():
            if name in NATIVE:
                NATIVE[name](n, self.arm, given)
        others = [name for name in values if name not in (*NATIVE, *STRUCTURE)]
        self.effects = [EQUATIONS[name](n, values[name]) for name in others]  # KeyError: an effect without equation
        # soft coordinates: deflections of elastic joints, then those of the structure
        self.elastic = np.flatnonzero(~n.rigid)
        more = [np.array(given["compliance"]) for given in (tilts, bends) if given is not None]
        compliance = np.concatenate([c[c > 0] for c in more]) if more else np.zeros(0)
        relaxation = [given["relaxation"] for given in (tilts, bends) if given is not None]
        self.k = np.concatenate([n.stiffness[self.elastic], 1 / compliance])
        self.d = np.concatenate([n.damping[self.elastic], (relaxation[0] if more else 0.0) / compliance])
        own, soft = len(self.elastic), len(self.k)
        self.links = np.zeros((self.arm.model.nv, n.size + soft))
        self.links[self.arm.own, np.arange(n.size)] = 1
        self.links[np.array(self.arm.own)[self.elastic], n.size + np.arange(own)] = 1
        self.links[self.arm.structure, n.size + own + np.arange(soft - own)] = 1
        rotors = n.gears.T @ np.diag(n.rotor) @ n.gears
        rotors[self.elastic, self.elastic] += ROTOR
        self.rotors = np.zeros(2 * (n.size + soft,))
        self.rotors[: n.size, : n.size] = rotors

    def spread(self, soft):
        """Deflections of all joints (N,); rigid ones have none."""
        full = np.zeros(self.n.size)
        full[self.elastic] = soft[: len(self.elastic)]
        return full

    def situation(self, time, p, dp, s, ds, z, za, integral, loop, wanted, *, read=None, rigid_load=None):
        """Everything that the equations ask for at a state.

        Args:
            time: since the motion began [s].
            p: angles of gearbox outputs, link side [rad], (N,); `dp` their speeds.
            s: soft coordinates (S,), `ds` their speeds.
            z: bristles of motors, `za` those of links in units of motors [rad], (N,).
            integral: of the servo's position errors [rad s], (N,).
            loop: torque that torque loops give [N m], (N,).
            wanted: set-points of angles and speeds of motors, and torque, (3, N).
            read: angle and speed of motors as servos know them, (2, N); None is the true ones.
            rigid_load: torque that links behind rigid joints ask for, link side [N m], (N,).
        """
        n = self.n
        x = SimpleNamespace(time=time, p=p, dp=dp, s=s, ds=ds, z=z, za=za, integral=integral, loop=loop)
        x.theta, x.omega = n.gears @ p, n.gears @ dp
        x.delta, x.ddelta = self.spread(s), self.spread(ds)
        x.q, x.dq = p + x.delta, dp + x.ddelta
        x.level = n.fc + (n.fs - n.fc) * np.exp(-((x.omega / n.vs) ** 2))
        x.sign = n.s0 * z / x.level
        # a share of friction acts on the link, with bristles of its own
        x.share = np.where(n.rigid, 0.0, n.share)
        x.link_omega = n.ratio * x.dq
        x.dz, x.dza = self.bend(z, x.omega), self.bend(za, x.link_omega)
        x.friction = (1 - x.share) * (n.s0 * z + n.s1 * x.dz + n.fv * x.omega)
        x.link_friction = n.ratio * x.share * (n.s0 * za + n.s1 * x.dza + n.fv * x.link_omega)
        angle, speed = (x.theta, x.omega) if read is None else read
        x.lag = wanted[0] - angle
        asked = n.kp * x.lag + n.kv * (wanted[1] - speed) + n.ki * integral + wanted[2]
        x.command = np.clip(asked, -n.peak, n.peak)
        x.spring = np.where(n.rigid, 0.0, -np.where(n.rigid, 0.0, n.stiffness) * x.delta - n.damping * x.ddelta)
        x.load = np.where(n.rigid, 0.0 if rigid_load is None else rigid_load, x.spring)
        x.running, x.temperature = time, np.full(n.size, 20.0)
        if n.climate is not None:
            x.running = n.climate.running_since + time
            x.temperature = n.climate.ambient + n.climate.rise * (1 - np.exp(-x.running / n.climate.time_constant))
        return x

    def bend(self, z, v):
        """Rate of LuGre bristles [rad/s]."""
        n = self.n
        level = n.fc + (n.fs - n.fc) * np.exp(-((v / n.vs) ** 2))
        return v - n.s0 * np.abs(v) / level * z

    def forces(self, x, torque, memories):
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
        force[n.size + own :] = -self.k[own:] * x.s[own:] - self.d[own:] * x.ds[own:]
        return force

    def mass(self, x):
        """Mass matrix of (p, s), and torques of gravity, speed and springs between links."""
        r, dr = self.links @ [*x.p, *x.s], self.links @ [*x.dp, *x.ds]
        bias = self.arm.bias(r, dr) + self.arm.spring_torque(r)
        return self.links.T @ self.arm.mass_matrix(r) @ self.links + self.rotors, self.links.T @ bias

    def accelerations(self, x, torque, memories):
        """Accelerations of (p, s)."""
        mass, bias = self.mass(x)
        return np.linalg.solve(mass, self.forces(x, torque, memories) - bias)
