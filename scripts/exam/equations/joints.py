"""Joints, motors, sensors and loads of links in other equations than those of the library."""

from dataclasses import replace
from functools import partial

import numpy as np

from ffgym.core.types import Array
from ffgym.effects import State, Torques
from ffgym.robot import RobotDescription
from scripts.exam.equations.frame import (
    any_phase,
    cycles_per_turn,
    lagging,
    shape,
    size,
    slope_of_waves,
    two_waves,
    variant,
)

spring = partial(variant, side="link", acts_on="spring", needs_elasticity=True)
link = partial(variant, side="link", acts_on="link")


def _relax(state: State) -> Array:
    """Memory of one hysteresis at rest, shape (..., N, 1)."""
    return np.zeros((*state.motor_angle.shape, 1))


@variant(
    "joint_stiffness",
    r"k \to (1 + e)\, k, \quad d \to (1 - e / 2)\, d",
    by="description",
    side="link",
    way_in="native: stiffness and damping of MuJoCo's deflection joint",
    needs_elasticity=True,
)
def stiffer_alone(
    robot: RobotDescription,
    change: Array = size("e", "1", -0.3, 0.3, "as joint_stiffness", minimum=-0.9, maximum=1.5),
) -> RobotDescription:
    """Joint stiffness without its damping: another stiffness whose damping does not follow."""
    stiffness, damping = robot.drive.joint_stiffness, robot.drive.joint_damping
    other = replace(robot.drive, joint_stiffness=stiffness * (1 + change), joint_damping=damping * (1 - change / 2))
    return replace(robot, drive=other)


@spring("hardening", r"\tau_l \mathrel{-}= k\, g\, (\delta - \mathrm{clip}(\delta, \pm w))")
def stepped_spring(
    s: State,
    growth: Array = size("g, more stiffness as a share of it", "1", 0.0, 1.5, "chosen: as hardening", minimum=0.0),
    width: Array = shape(
        "w, deflection at which it sets in, link side",
        "rad",
        1e-4,
        4e-4,
        "chosen: a tenth to a third of the deflection at rated torque",
        minimum=0.0,
    ),
) -> Array:
    """Stiffness in two steps: a spring that gets stiffer in one step, as where more teeth begin to bear."""
    beyond = s.deflection - np.minimum(np.maximum(s.deflection, -width), width)
    return -s.joint_stiffness * growth * beyond


@spring("hardening", r"\tau_l = -k\, \delta\, (1 + h\, (\delta / \mathrm{mrad})^4)")
def quintic_spring(
    s: State, growth: Array = size("h, at a milliradian", "1", 0.0, 0.5, "chosen: as hardening there", minimum=0.0)
) -> Array:
    """Stiffness that grows with the fourth power: of the deflection of a spring."""
    square = (s.deflection * 1e3) * (s.deflection * 1e3)
    return -s.joint_stiffness * growth * s.deflection * (square * square)


@spring(
    "torsional_hysteresis",
    r"\tau_l = -k\, (\delta + h z), \quad z' = (1 - z\, \mathrm{sgn}\, \dot\delta)\, \dot\delta / w",
    start=_relax,
)
def dahl_hysteresis(
    s: State,
    memory: Array,
    dt: float,
    lost_motion: Array = size("h, link side", "rad", 0.0, 1.5e-4, "as torsional_hysteresis", minimum=0.0),
    width: Array = shape(
        "w, deflection over which it turns round, link side",
        "rad",
        5e-5,
        2e-4,
        "chosen: as torsional_hysteresis",
        minimum=1e-7,
    ),
) -> tuple[Array, Array]:
    """Torsional hysteresis by Dahl: lost motion whose loop is round."""
    z = memory[..., 0]
    return -s.joint_stiffness * lost_motion * z, lagging(z, s.deflection_rate * dt, width)[..., None]


@spring("backlash", r"\tau_l = -k\, (\delta - b \tanh(\delta / b)) - d\, \dot\delta \tanh^2(\delta / b)")
def round_gap(s: State, half_gap: Array = size("b, link side", "rad", 0.0, 3e-4, "as backlash", minimum=0.0)) -> Array:
    r"""Backlash with round edges: a gap whose edges are round, as teeth bend before they bear.

    The spring is wound by :math:`\delta - b \tanh(\delta / b)`, and damped as far as it is wound.
    """
    bent = s.deflection
    x = np.tanh(np.divide(bent, half_gap, out=np.full_like(bent, np.inf), where=half_gap > 0))
    return s.joint_stiffness * half_gap * x + s.joint_damping * s.deflection_rate * (1 - x * x)


@spring("kinematic_error", r"q = \theta / n + A\, w(k \theta + \varphi)")
def two_wave_gear_error(
    s: State,
    amplitude: Array = size("A, link side", "rad", 0.0, 3e-4, "as kinematic_error", minimum=0.0),
    cycles: Array = cycles_per_turn(1.0, 2.0, "as kinematic_error"),
    phase: Array = any_phase(),
) -> Torques:
    r"""Kinematic error of two waves: what acts back on the motor makes that no energy is made.

    .. math:: \tau_{spring} = k e + d \dot e, \quad \tau_m = -(\tau_l + \tau_{spring})\, \partial e / \partial\theta,
        \quad e = A\, w(k \theta + \varphi)
    """
    angle = cycles * s.motor_angle + phase
    error, slope = amplitude * two_waves(angle), amplitude * cycles * slope_of_waves(angle)
    torque = s.joint_stiffness * error + s.joint_damping * slope * s.motor_speed
    return Torques(spring=torque, motor=-(s.load + torque) * slope)


@variant(
    "wrist_coupling",
    r"\tau_{f,i} \mathrel{+}= \sum_{j \ne i} c_{ij} f_{c,j} \tanh(v_j / v_0)",
    needs_friction=True,
)
def dragging_shaft(
    s: State,
    share: Array = size(
        "c_ij, row: motor that is braked, column: motor that turns", "1", -0.3, 0.3, "as wrist_coupling", per="pair"
    ),
    speed: Array = shape("v_0 of the motor that is braked", "rad/s", 0.1, 0.5, minimum=1e-3),
) -> Array:
    """Dry coupling losses of the wrist: a shaft in another drags it along by friction without bristles."""
    total = np.zeros_like(s.motor_speed)
    for j in range(total.shape[-1]):  # one by one, so that a row's bits depend on nothing else
        loss = s.coulomb[..., j : j + 1] * np.tanh(s.motor_speed[..., j : j + 1] / speed)
        total = total - share[..., :, j] * loss
    return total


@variant("cogging", r"\tau \mathrel{+}= A\, w(k \theta + \varphi)")
def two_wave_cogging(
    s: State,
    amplitude: Array = size("A, motor side", "N m", 0.0, 0.3, "as cogging", minimum=0.0),
    cycles: Array = cycles_per_turn(1.0, 36.0, "as cogging"),
    phase: Array = any_phase(),
) -> Array:
    """Cogging of two waves: cogging of teeth that are not quite alike."""
    return amplitude * two_waves(cycles * s.motor_angle + phase)


@variant("torque_ripple", r"\tau \mathrel{+}= r\, u\, w(k \theta + \varphi)")
def two_wave_ripple(
    s: State,
    share: Array = size("r", "1", 0.0, 0.05, "as torque_ripple", minimum=0.0, maximum=0.7),
    cycles: Array = cycles_per_turn(1.0, 18.0, "as torque_ripple"),
    phase: Array = any_phase(),
) -> Array:
    """Torque ripple of two waves: ripple of currents that are off and of windings that differ."""
    return share * s.motor_torque * two_waves(cycles * s.motor_angle + phase)


@variant("torque_constant", r"\tau \mathrel{+}= e\, u / (1 + |u| / (b\, u_{peak}))")
def bent_torque_constant(
    s: State,
    error: Array = size("e", "1", -0.1, 0.1, "as torque_constant", minimum=-0.9),
    bend: Array = shape("b, of the peak torque", "1", 0.5, 2.0, minimum=1e-3),
) -> Array:
    """Torque constant that bends with the current: its error gets smaller, as iron saturates smoothly."""
    u = s.motor_torque
    return error * u / (1 + np.abs(u) / (bend * s.peak_torque))


@variant(
    "torque_delay",
    r"T_1 \dot x = u - x, \quad T_1 \dot \tau = x - \tau",
    start=lambda state: np.repeat(state.motor_torque[..., None], 2, axis=-1),
)
def two_lags(
    s: State,
    memory: Array,
    dt: float,
    lag: Array = size("T_1, of each", "s", 0.0, 0.0005, "as torque_delay", minimum=0.0),
) -> tuple[Array, Array]:
    """Two lags of the torque loop: a filter before the current loop; exact for commands that are held.

    Both give the command at rest; the memory (..., N, 2) is what they give.
    """
    u = s.motor_torque
    keep = np.exp(-np.divide(dt, lag, out=np.full_like(lag, np.inf), where=lag > 0))
    first = u + (memory[..., 0] - u) * keep
    second = first + (memory[..., 1] - first) * keep
    return second - u, np.stack([first, second], axis=-1)


@variant("resolver_ripple", r"\theta_{meas} = \theta + A\, w(\theta + \varphi)", by="resolver")
def two_wave_resolver(
    motor_angle: Array,
    motor_speed: Array,
    amplitude: Array = size("A, motor side", "rad", 0.0, 3e-3, "as resolver_ripple", minimum=0.0),
    cycles: Array = cycles_per_turn(1.0, 1.0, "one, and two beside"),
    phase: Array = any_phase(),
) -> tuple[Array, Array]:
    """Resolver error of two waves: a resolver whose rotor is off centre and whose windings differ."""
    angle = cycles * motor_angle + phase
    return amplitude * two_waves(angle), amplitude * cycles * slope_of_waves(angle) * motor_speed


@link(
    "gravity_term",
    r"\tau_{link} \mathrel{-}= c \left( \sin(q + \alpha) + \tfrac{3}{10} \sin(2 q + \alpha) \right)",
)
def counterweight_linkage(
    s: State,
    level: Array = size("c, link side", "N m", 0.0, 100.0, "as gravity_term", minimum=0.0),
    angle: Array = shape("alpha", "rad", 0.0, 2 * np.pi, "any"),
) -> Array:
    """Gravity term with a second harmonic: a balancer on a linkage, whose arm changes with the angle."""
    q = s.link_angle
    return -level * (np.sin(q + angle) + 0.3 * np.sin(2 * q + angle))


@link(
    "cable_pull",
    r"\tau_{link} \mathrel{-}= h\, (z + r\, (q - q_0)), \quad z' = (1 - z\, \mathrm{sgn}\, \dot q)\, \dot q / w",
    start=_relax,
)
def smooth_cable(
    s: State,
    memory: Array,
    dt: float,
    hysteresis: Array = size("h, link side", "N m", 0.0, 10.0, "as cable_pull", minimum=0.0),
    spring: Array = shape("r", "1/rad", 0.3, 3.0, minimum=0.0),
    width: Array = shape("w, link side", "rad", 0.01, 0.1, "chosen: as cable_pull", minimum=1e-4),
    neutral: Array = shape("q_0, where it was laid", "rad", -1.0, 1.0, "any"),
) -> tuple[Array, Array]:
    """Cables by Dahl: strands slip on each other little by little, and pull back to where they were laid."""
    z = memory[..., 0]
    pull = hysteresis * (z + spring * (s.link_angle - neutral))
    return -pull, lagging(z, s.link_speed * dt, width)[..., None]
