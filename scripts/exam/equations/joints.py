"""Joints, motors, sensors and loads of links in other equations than those of the library."""

from dataclasses import replace

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import NativeEffect, ResolverEffect, ResolverError, State, Torques
from ffgym.robot import RobotDescription
from scripts.exam.equations.frame import (
    Torque,
    Variant,
    any_phase,
    cycles_per_turn,
    lagging,
    shape,
    size,
    slope_of_waves,
    two_waves,
)


class Spring(Variant, Torque):
    """A torque of the spring of a joint."""

    acts_on = "spring"
    needs_elasticity = True


class MotorTorque(Variant, Torque):
    """A torque of the motor."""


class LinkTorque(Variant, Torque):
    """A torque of the link."""

    acts_on = "link"


class StifferAlone(
    Variant,
    NativeEffect,
    of="joint_stiffness",
    equation=r"k \to (1 + e)\, k, \quad d \to (1 - e / 2)\, d",
    side="link",
    way_in="native: stiffness and damping of MuJoCo's deflection joint",
    needs_elasticity=True,
):
    """Joint stiffness without its damping: another stiffness whose damping does not follow."""

    change: Array = size("e", "1", -0.3, 0.3, "as joint_stiffness", minimum=-0.9, maximum=1.5)

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """See base class."""
        drive = robot.drive
        other = replace(
            drive,
            joint_stiffness=drive.joint_stiffness * (1 + self.change),
            joint_damping=drive.joint_damping * (1 - self.change / 2),
        )
        return replace(robot, drive=other)


class SteppedSpring(
    Spring, of="hardening", equation=r"\tau_l \mathrel{-}= k\, g\, (\delta - \mathrm{clip}(\delta, \pm w))", side="link"
):
    """Stiffness in two steps: a spring that gets stiffer in one step, as where more teeth begin to bear."""

    growth: Array = size("g, more stiffness as a share of it", "1", 0.0, 1.5, "chosen: as hardening", minimum=0.0)
    width: Array = shape(
        "w, deflection at which it sets in, link side",
        "rad",
        1e-4,
        4e-4,
        "chosen: a tenth to a third of the deflection at rated torque",
        minimum=0.0,
    )

    def _torque(self, s: State) -> Array:
        bent = s.deflection
        beyond = bent - np.minimum(np.maximum(bent, -self.width), self.width)
        return -s.joint_stiffness * self.growth * beyond


class QuinticSpring(
    Spring, of="hardening", equation=r"\tau_l = -k\, \delta\, (1 + h\, (\delta / \mathrm{mrad})^4)", side="link"
):
    """Stiffness that grows with the fourth power: of the deflection of a spring."""

    growth: Array = size("h, at a milliradian", "1", 0.0, 0.5, "chosen: as hardening there", minimum=0.0)

    def _torque(self, s: State) -> Array:
        square = (s.deflection * 1e3) * (s.deflection * 1e3)
        return -s.joint_stiffness * self.growth * s.deflection * (square * square)


class DahlHysteresis(
    Spring,
    of="torsional_hysteresis",
    equation=r"\tau_l = -k\, (\delta + h z), \quad z' = (1 - z\, \mathrm{sgn}\, \dot\delta)\, \dot\delta / w",
    side="link",
):
    """Torsional hysteresis by Dahl: lost motion whose loop is round."""

    lost_motion: Array = size("h, link side", "rad", 0.0, 1.5e-4, "as torsional_hysteresis", minimum=0.0)
    width: Array = shape(
        "w, deflection over which it turns round, link side",
        "rad",
        5e-5,
        2e-4,
        "chosen: as torsional_hysteresis",
        minimum=1e-7,
    )

    def initial_memory(self, state: State) -> Array:
        """Relaxed at rest, shape (..., N, 1)."""
        return np.zeros((*state.deflection.shape, 1))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        z = memory[..., 0]
        spring = -state.joint_stiffness * self.lost_motion * z
        return Torques(spring=spring), lagging(z, state.deflection_rate * dt, self.width)[..., None]


class RoundGap(
    Spring,
    of="backlash",
    equation=r"\tau_l = -k\, (\delta - b \tanh(\delta / b)) - d\, \dot\delta \tanh^2(\delta / b)",
    side="link",
):
    r"""Backlash with round edges: a gap whose edges are round, as teeth bend before they bear.

    The spring is wound by :math:`\delta - b \tanh(\delta / b)`, and damped as far as it is wound.
    """

    half_gap: Array = size("b, link side", "rad", 0.0, 3e-4, "as backlash", minimum=0.0)

    def _torque(self, s: State) -> Array:
        bent, gap = s.deflection, self.half_gap
        x = np.tanh(np.divide(bent, gap, out=np.full_like(bent, np.inf), where=gap > 0))
        return s.joint_stiffness * gap * x + s.joint_damping * s.deflection_rate * (1 - x * x)


class TwoWaveGearError(
    Spring, of="kinematic_error", equation=r"q = \theta / n + A\, w(k \theta + \varphi)", side="link"
):
    r"""Kinematic error of two waves: what acts back on the motor makes that no energy is made.

    .. math:: \tau_{spring} = k e + d \dot e, \quad \tau_m = -(\tau_l + \tau_{spring})\, \partial e / \partial\theta,
        \quad e = A\, w(k \theta + \varphi)
    """

    amplitude: Array = size("A, link side", "rad", 0.0, 3e-4, "as kinematic_error", minimum=0.0)
    cycles: Array = cycles_per_turn(1.0, 2.0, "as kinematic_error")
    phase: Array = any_phase()

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        angle = self.cycles * state.motor_angle + self.phase
        error, slope = self.amplitude * two_waves(angle), self.amplitude * self.cycles * slope_of_waves(angle)
        spring = state.joint_stiffness * error + state.joint_damping * slope * state.motor_speed
        return Torques(spring=spring, motor=-(state.load + spring) * slope), memory


class DraggingShaft(
    MotorTorque,
    of="wrist_coupling",
    equation=r"\tau_{f,i} \mathrel{+}= \sum_{j \ne i} c_{ij} f_{c,j} \tanh(v_j / v_0)",
    needs_friction=True,
):
    """Dry coupling losses of the wrist: a shaft in another drags it along by friction without bristles."""

    share: Array = size(
        "c_ij, row: motor that is braked, column: motor that turns", "1", -0.3, 0.3, "as wrist_coupling", per="pair"
    )
    speed: Array = shape("v_0 of the motor that is braked", "rad/s", 0.1, 0.5, minimum=1e-3)

    def _torque(self, s: State) -> Array:
        total = np.zeros_like(s.motor_speed)
        for j in range(total.shape[-1]):  # one by one, so that a row's bits depend on nothing else
            loss = s.coulomb[..., j : j + 1] * np.tanh(s.motor_speed[..., j : j + 1] / self.speed)
            total = total - self.share[..., :, j] * loss
        return total


class TwoWaveCogging(MotorTorque, of="cogging", equation=r"\tau \mathrel{+}= A\, w(k \theta + \varphi)"):
    """Cogging of two waves: cogging of teeth that are not quite alike."""

    amplitude: Array = size("A, motor side", "N m", 0.0, 0.3, "as cogging", minimum=0.0)
    cycles: Array = cycles_per_turn(1.0, 36.0, "as cogging")
    phase: Array = any_phase()

    def _torque(self, s: State) -> Array:
        return self.amplitude * two_waves(self.cycles * s.motor_angle + self.phase)


class TwoWaveRipple(MotorTorque, of="torque_ripple", equation=r"\tau \mathrel{+}= r\, u\, w(k \theta + \varphi)"):
    """Torque ripple of two waves: ripple of currents that are off and of windings that differ."""

    share: Array = size("r", "1", 0.0, 0.05, "as torque_ripple", minimum=0.0, maximum=0.7)
    cycles: Array = cycles_per_turn(1.0, 18.0, "as torque_ripple")
    phase: Array = any_phase()

    def _torque(self, s: State) -> Array:
        wave = two_waves(self.cycles * s.motor_angle + self.phase)
        return self.share * s.motor_torque * wave


class BentTorqueConstant(
    MotorTorque, of="torque_constant", equation=r"\tau \mathrel{+}= e\, u / (1 + |u| / (b\, u_{peak}))"
):
    """Torque constant that bends with the current: its error gets smaller, as iron saturates smoothly."""

    error: Array = size("e", "1", -0.1, 0.1, "as torque_constant", minimum=-0.9)
    bend: Array = shape("b, of the peak torque", "1", 0.5, 2.0, minimum=1e-3)

    def _torque(self, s: State) -> Array:
        u = s.motor_torque
        return self.error * u / (1 + np.abs(u) / (self.bend * s.peak_torque))


class TwoLags(MotorTorque, of="torque_delay", equation=r"T_1 \dot x = u - x, \quad T_1 \dot \tau = x - \tau"):
    """Two lags of the torque loop: a filter before the current loop; exact for commands that are held."""

    lag: Array = size("T_1, of each", "s", 0.0, 0.0005, "as torque_delay", minimum=0.0)

    def initial_memory(self, state: State) -> Array:
        """Both give the command at rest, shape (..., N, 2)."""
        return np.repeat(state.motor_torque[..., None], 2, axis=-1)

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        u = state.motor_torque
        keep = np.exp(-np.divide(dt, self.lag, out=np.full_like(self.lag, np.inf), where=self.lag > 0))
        first = u + (memory[..., 0] - u) * keep
        second = first + (memory[..., 1] - first) * keep
        return Torques(motor=second - u), np.stack([first, second], axis=-1)


class TwoWaveResolver(
    Variant,
    ResolverEffect,
    of="resolver_ripple",
    equation=r"\theta_{meas} = \theta + A\, w(\theta + \varphi)",
    way_in="reading of the servo",
):
    """Resolver error of two waves: a resolver whose rotor is off centre and whose windings differ."""

    amplitude: Array = size("A, motor side", "rad", 0.0, 3e-3, "as resolver_ripple", minimum=0.0)
    cycles: Array = cycles_per_turn(1.0, 1.0, "one, and two beside")
    phase: Array = any_phase()

    def error(self, motor_angle: Array, motor_speed: Array) -> ResolverError:
        """See base class."""
        angle = self.cycles * motor_angle + self.phase
        slope = self.amplitude * self.cycles * slope_of_waves(angle)
        return ResolverError(angle=self.amplitude * two_waves(angle), speed=slope * motor_speed)


class CounterweightLinkage(
    LinkTorque,
    of="gravity_term",
    equation=r"\tau_{link} \mathrel{-}= c \left( \sin(q + \alpha) + \tfrac{3}{10} \sin(2 q + \alpha) \right)",
    side="link",
):
    """Gravity term with a second harmonic: a balancer on a linkage, whose arm changes with the angle."""

    level: Array = size("c, link side", "N m", 0.0, 100.0, "as gravity_term", minimum=0.0)
    angle: Array = shape("alpha", "rad", 0.0, 2 * np.pi, "any")

    def _torque(self, s: State) -> Array:
        q = s.link_angle
        return -self.level * (np.sin(q + self.angle) + 0.3 * np.sin(2 * q + self.angle))


class SmoothCable(
    LinkTorque,
    of="cable_pull",
    equation=(
        r"\tau_{link} \mathrel{-}= h\, (z + r\, (q - q_0)), \quad z' = (1 - z\, \mathrm{sgn}\, \dot q)\, \dot q / w"
    ),
    side="link",
):
    """Cables by Dahl: strands slip on each other little by little, and pull back to where they were laid."""

    hysteresis: Array = size("h, link side", "N m", 0.0, 10.0, "as cable_pull", minimum=0.0)
    spring: Array = shape("r", "1/rad", 0.3, 3.0, minimum=0.0)
    width: Array = shape("w, link side", "rad", 0.01, 0.1, "chosen: as cable_pull", minimum=1e-4)
    neutral: Array = shape("q_0, where it was laid", "rad", -1.0, 1.0, "any")

    def initial_memory(self, state: State) -> Array:
        """Relaxed at rest, shape (..., N, 1)."""
        return np.zeros((*state.joint_angle.shape, 1))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        z = memory[..., 0]
        pull = self.hysteresis * (z + self.spring * (state.link_angle - self.neutral))
        return Torques(link=-pull), lagging(z, state.link_speed * dt, self.width)[..., None]
