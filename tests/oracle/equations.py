"""Equations of all effects that act on a machine, written anew from docs/effects: what the plant must obey.

Native effects are functions that change numbers, the others `Equation`s, which say how torques are given.
"""

import numpy as np
from scipy.linalg import expm

from scripts.engine.second.machine import Equation, FlexibleMachine
from scripts.engine.second.steps import TorqueDelay


def _change(**shares):
    """Change numbers of a machine by shares: values of the effect by the name of the number."""

    def apply(n, arm, given):
        for number, value in shares.items():
            setattr(n, number, getattr(n, number) * (1 + np.asarray(given[value])))

    return apply


def _coulomb_level(n, arm, given):
    more = given["change"] * n.fc
    n.fc, n.fs = n.fc + more, n.fs + more


def _stribeck_peak(n, arm, given):
    n.fs, n.vs = n.fs + given["level"] * n.fc, n.vs * (1 + given["velocity"])


def _joint_stiffness(n, arm, given):
    n.stiffness, n.damping = n.stiffness * (1 + given["change"]), n.damping * np.sqrt(1 + given["change"])


def _arm_friction(n, arm, given):
    n.share = 1 - (1 - given["share"]) * (1 - n.share)


def _payload(n, arm, given):
    inertia = given["mass"] * given["radius"] ** 2 * np.eye(3)
    arm.add_body(float(given["mass"]), arm.robot.tool.tcp + given["offset"], inertia)


NATIVE = {
    "coulomb_level": _coulomb_level,
    "viscous_level": _change(fv="change"),
    "stribeck_peak": _stribeck_peak,
    "presliding": _change(s0="stiffness", s1="damping"),
    "joint_stiffness": _joint_stiffness,
    "arm_friction": _arm_friction,
    "payload": _payload,
    "rotor_inertia": _change(rotor="change"),
    "servo_gains": _change(kp="position", kv="velocity", ki="integral"),
}
"""Effects that are other numbers of the machine: functions that change them."""

STRUCTURE = {"base_flexibility": "base", "link_flexibility": "bends"}
"""Effects that are joints without motors, and what `PinocchioArm` calls them."""


def _plain(formula):
    """Effect whose torques are a formula of situation, numbers and own values."""

    class Plain(Equation):
        def torques(self, x, memory):
            return formula(self, x, self.n)

    return Plain


def _friction(formula):
    return _plain(lambda e, x, n: {"motor": -formula(e, x, n)})


def _stribeck(x, n, width=1.0, exponent=2.0):
    return np.exp(-(np.abs(x.omega / (width * n.vs)) ** exponent))


def _temperature(e, x, n):
    warmer = x.temperature - e.reference
    viscous = e.viscous * n.fv * (np.exp(-warmer / e.scale) - 1) * x.omega
    return viscous + warmer * (e.coulomb * n.fc + e.breakaway * n.fs * _stribeck(x, n)) * x.sign


def _viscous_drift(e, x, n):
    # the power law, whose tangent is finite below 0.1 rad/s
    faster = np.sqrt((x.omega / 100) ** 2 + 1e-3**2)
    return e.share * n.fv * (np.exp(-x.running / e.duration) - 1) * x.omega * faster ** (e.exponent - 1)


def _wrist_coupling(e, x, n):
    return e.share @ (n.fc * x.sign + n.fv * x.omega)


def _backlash(e, x, n):
    gap = np.clip(x.delta, -e.half_gap, e.half_gap)
    free = np.abs(x.delta) < e.half_gap
    return {"spring": n.stiffness * gap + np.where(free, n.damping * x.ddelta, 0.0)}


def _kinematic_error(e, x, n):
    phase = e.cycles * x.theta + e.phase
    error, slope = e.amplitude * np.sin(phase), e.amplitude * e.cycles * np.cos(phase)
    spring = n.stiffness * error + n.damping * slope * x.omega
    return {"spring": spring, "motor": -(x.spring + spring) * slope}


def _gravity_term(e, x, n):
    return {"link": -(e.sine * np.sin(x.q) + e.cosine * np.cos(x.q) + e.stiffness * (x.q - e.neutral))}


def _torque_constant(e, x, n):
    share = e.error + e.magnets * (x.temperature - e.reference) - e.saturation * (x.torque / n.peak) ** 2
    return {"motor": x.torque * share}


class DwellStiction(Equation):
    """Contacts age towards 1 at rest, and slip renews them."""

    def start(self, x):
        return np.ones((1, self.n.size))

    def torques(self, x, memory):
        return {"motor": -self.share * self.n.fs * memory[0] * x.sign}

    def rate(self, x, memory):
        slip = np.maximum(x.sign * x.omega, 0)
        return (1 - memory) / self.time - memory * slip / self.slip

    def after(self, x, memory, later, h):
        fall = 1 / self.time + np.maximum(x.sign * x.omega, 0) / self.slip
        end = 1 / (self.time * fall)
        return end + (memory - end) * np.exp(-fall * h)


class _Slip(Equation):
    """Elements that stick until they slip, along a way."""

    def start(self, x):
        return np.zeros((len(self.widths), self.n.size))

    def rate(self, x, memory):
        rate = self.speed(x) / self.widths
        return np.where(memory * rate >= np.abs(rate), 0.0, rate)  # beyond its end an element slips

    def after(self, x, memory, later, h):
        return np.clip(memory + (self.way(later) - self.way(x)) / self.widths, -1, 1)


class TorsionalHysteresis(_Slip):
    """Four elements beside the spring."""

    def __init__(self, n, given) -> None:
        super().__init__(n, given)
        self.widths = np.array([0.25, 0.5, 0.75, 1.0])[:, None] * self.width

    def way(self, x):
        return x.delta

    def speed(self, x):
        return x.ddelta

    def torques(self, x, memory):
        return {"spring": -self.n.stiffness * self.lost_motion * np.clip(memory, -1, 1).mean(axis=0)}


class CablePull(_Slip):
    """Spring and strands between neighbouring links."""

    def __init__(self, n, given) -> None:
        super().__init__(n, given)
        self.widths = self.width[None]

    def way(self, x):
        return x.q

    def speed(self, x):
        return x.dq

    def torques(self, x, memory):
        pull = self.stiffness * (x.q - self.neutral) + self.hysteresis * np.clip(memory[0], -1, 1)
        return {"link": -pull}


class ArmLoadFriction(Equation):
    """Friction on the link by what the gearbox passes on; its sign turns along the way (Dahl 1968)."""

    def start(self, x):
        return np.zeros((1, self.n.size))

    def torques(self, x, memory):
        return {"link": -self.share * np.abs(x.load) * memory[0]}

    def rate(self, x, memory):
        return (x.dq - np.abs(x.dq) * memory) / self.way

    def after(self, x, memory, later, h):
        # the way is that of the mean speed
        way = 0.5 * h * (x.dq + later.dq)
        end = np.where(way < 0, -1.0, 1.0)
        return end + (memory - end) * np.exp(-np.abs(way) / self.way)


class FlexibleLoad(Equation):
    """An inertia on a spring that the link carries: its place in the world and its speed."""

    def start(self, x):
        return np.stack([x.q, x.dq])

    def torques(self, x, memory):
        w, (place, speed) = 2 * np.pi * self.frequency, memory
        return {"link": self.inertia * (w**2 * (place - x.q) + 2 * self.damping * w * (speed - x.dq))}

    def rate(self, x, memory):
        w, (place, speed) = 2 * np.pi * self.frequency, memory
        return np.stack([speed, -(w**2) * (place - x.q) - 2 * self.damping * w * (speed - x.dq)])

    def after(self, x, memory, later, h):
        # relative to a link whose speed changes evenly: a linear system with a constant push
        found = []
        for j, (w, zeta) in enumerate(zip(2 * np.pi * self.frequency, self.damping, strict=True)):
            push = -(later.dq[j] - x.dq[j]) / h
            system = np.array([[0, 1, 0], [-(w**2), -2 * zeta * w, push], [0, 0, 0]])
            place, speed, _ = expm(h * system) @ [memory[0, j] - x.q[j], memory[1, j] - x.dq[j], 1]
            found.append([place + later.q[j], speed + later.dq[j]])
        return np.transpose(found)


EQUATIONS = {
    "asymmetry": _friction(lambda e, x, n: e.coulomb * n.fc * np.abs(x.sign) + e.viscous * n.fv * np.abs(x.omega)),
    "load_friction": _friction(lambda e, x, n: e.share * np.abs(np.linalg.solve(n.gears.T, x.load)) * x.sign),
    "temperature_friction": _friction(_temperature),
    "nonlinear_viscous": _friction(lambda e, x, n: e.share * n.fv * x.omega * np.abs(x.omega) / e.speed),
    "position_friction": _friction(lambda e, x, n: e.share * n.fc * np.sin(e.cycles * x.p + e.phase) * x.sign),
    "dwell_stiction": DwellStiction,
    "stribeck_exponent": _friction(
        lambda e, x, n: (n.fs - n.fc) * (_stribeck(x, n, exponent=e.exponent) - _stribeck(x, n)) * x.sign
    ),
    "viscous_drift": _friction(_viscous_drift),
    "coulomb_drift": _friction(lambda e, x, n: e.share * n.fc * (1 - np.exp(-x.running / e.duration)) * x.sign),
    "falling_friction": _friction(lambda e, x, n: e.share * n.fc * _stribeck(x, n, e.width, e.exponent) * x.sign),
    "hardening": _plain(lambda e, x, n: {"spring": -n.stiffness * e.growth * x.delta**3}),
    "torsional_hysteresis": TorsionalHysteresis,
    "backlash": _plain(_backlash),
    "kinematic_error": _plain(_kinematic_error),
    "wrist_coupling": _friction(_wrist_coupling),
    "flexible_load": FlexibleLoad,
    "arm_load_friction": ArmLoadFriction,
    "cogging": _plain(lambda e, x, n: {"motor": e.amplitude * np.sin(e.cycles * x.theta + e.phase)}),
    "torque_ripple": _plain(lambda e, x, n: {"motor": e.share * x.torque * np.sin(e.cycles * x.theta + e.phase)}),
    "torque_constant": _plain(_torque_constant),
    "torque_delay": TorqueDelay,
    "torque_offset": _plain(lambda e, x, n: {"motor": e.offset}),
    "gravity_term": _plain(_gravity_term),
    "cable_pull": CablePull,
}
"""Effects that add torques, by name."""


def own_machine(machine):
    """The equations of a machine with its effects, but for those of its sensors.

    Raises:
        KeyError: for an effect that has no equation here.
    """
    robot, given = machine.robot, {e.name: e.values() for e in machine.effects if e.name != "resolver_ripple"}
    if np.any(robot.drive.delay):  # one after the other
        late = given.get("torque_delay", {"delay": 0.0, "lag": 0.0 * robot.drive.delay})
        given["torque_delay"] = {"delay": late["delay"] + robot.drive.delay, "lag": late["lag"]}
    structure = [
        (part, np.array(given[name]["compliance"]), float(given[name]["relaxation"]))
        for name, part in STRUCTURE.items()
        if name in given
    ]
    own = FlexibleMachine(robot, machine.climate, structure)
    for name, values in given.items():
        if name in NATIVE:
            NATIVE[name](own.n, own.arm, values)
    others = [name for name in given if name not in (*NATIVE, *STRUCTURE)]
    own.effects = [EQUATIONS[name](own.n, given[name]) for name in others]
    return own
