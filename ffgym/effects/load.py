"""What the arm carries: masses, springs, cables, and rotors that are heavier to turn (G1 to G4)."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.effects.effect import NativeEffect, TorqueEffect
from ffgym.effects.parameters import parameter
from ffgym.effects.state import State, Torques
from ffgym.robot import RobotDescription
from ffgym.robot.description import with_payload
from ffgym.robot.friction import advance_slip, advance_slip_along


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Payload(NativeEffect):
    """A body at the tool, beside the tool itself."""

    name = "payload"
    code = "G1"
    title = "payload"
    equation = r"\tau \mathrel{+}= J^T m\, (\ddot r_c - g) + J_\omega^T m \rho^2 \dot\omega"
    side = "tool"
    signature = "torque: on several joints at once, in the ratio of the columns of the Jacobian, at rest too"
    way_in = "native: mass, centre of mass and inertia of the tool"
    confusable_with = ("F6", "G2", "T1", "T6")
    separating_motions = ("holds", "slow_triangles", "excitation")
    needs_tool = True
    patterns = (("function", "load"),)

    mass: Array = parameter(
        "m", unit="kg", low=0.0, high=60.0, minimum=0.0, per="machine", source="robots for 10 to 250 kg; here 60 kg"
    )
    offset: Array = parameter(
        "centre of mass from the TCP, in the axes of tool0",
        role="span",
        unit="m",
        null=None,
        low=-0.2,
        high=0.2,
        default=0.0,
        per="vector",
        source="chosen: dimensions of a gripper and what it holds",
    )
    radius: Array = parameter(
        "rho, radius of gyration about the centre of mass",
        role="span",
        unit="m",
        null=None,
        low=0.0,
        high=0.3,
        minimum=0.0,
        default=0.0,
        per="machine",
        source="chosen: a body of half a metre",
    )

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """See base class."""
        return with_payload(robot, float(self.mass), self.offset, float(self.radius))


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RotorInertia(NativeEffect):
    """More inertia of motor, brake and gear input."""

    name = "rotor_inertia"
    code = "G2"
    title = "rotor inertia"
    equation = r"J_m \to (1 + a)\, J_m"
    side = "motor"
    signature = "torque: proportional to the motor's own acceleration, on one joint only"
    way_in = "native: armature of the motor joint"
    confusable_with = ("G1", "M5", "T8")
    separating_motions = ("excitation",)
    patterns = (("function", "motor acceleration"),)

    change: Array = parameter(
        "a, more rotor inertia as a share of it",
        unit="1",
        low=-0.2,
        high=0.2,
        minimum=-0.9,
        source="chosen: brakes and gear inputs that data sheets leave out",
        of=("drive", "rotor_inertia"),
    )

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """See base class."""
        drive = robot.drive
        return replace(robot, drive=replace(drive, rotor_inertia=drive.rotor_inertia * (1 + self.change)))


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class GravityTerm(TorqueEffect):
    """A function of one joint's own angle: hoses, a centre of mass off its place, a counterbalance."""

    name = "gravity_term"
    code = "G3"
    title = "gravity term and counterbalance"
    equation = r"\tau_{link} \mathrel{-}= c_1 \sin q + c_2 \cos q + k_s\, (q - q_0)"
    side = "link"
    signature = "torque: even in the speed, a function of one joint's angle, no inertia with it"
    way_in = "torque at every physics step on the link"
    confusable_with = ("F5", "G4", "M4")
    separating_motions = ("holds", "slow_triangles")
    patterns = (("function", "motor angle"),)

    sine: Array = parameter(
        "c_1, link side", unit="N m", low=-100.0, high=100.0, source="chosen: 10 kg at 1 m, as a description may miss"
    )
    cosine: Array = parameter("c_2, link side", unit="N m", low=-100.0, high=100.0, source="as c_1")
    stiffness: Array = parameter(
        "k_s, link side",
        unit="N m/rad",
        low=0.0,
        high=100.0,
        minimum=0.0,
        source="chosen: a weak counterbalance; a strong one is a spring of the description",
    )
    neutral: Array = parameter(
        "q_0, where the spring is relaxed",
        role="span",
        unit="rad",
        null=None,
        low=-1.0,
        high=1.0,
        default=0.0,
        source="chosen: about the upright arm",
    )

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class."""
        q = state.link_angle
        return Torques(
            link=-(self.sine * np.sin(q) + self.cosine * np.cos(q) + self.stiffness * (q - self.neutral))
        ), memory


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class CablePull(TorqueEffect):
    """Cables and hoses: a spring about the angle at which they were laid, and strands that slip on each other."""

    name = "cable_pull"
    code = "G4"
    title = "cables and dress pack"
    equation = r"\tau_{link} \mathrel{-}= k_c\, (q - q_0) + h\, s, \quad s \to \mathrm{clip}(s + \Delta q / w, \pm 1)"
    side = "link"
    signature = "torque: a function of the joint angle, weakly of its direction; another after re-dressing"
    way_in = "torque at every physics step on the link, with memory"
    confusable_with = ("G3",)
    separating_motions = ("slow_triangles", "holds")
    patterns = (("function", "motor angle"),)

    stiffness: Array = parameter(
        "k_c, link side",
        unit="N m/rad",
        low=0.0,
        high=30.0,
        minimum=0.0,
        source="chosen: some N m over the travel of a wrist",
    )
    hysteresis: Array = parameter(
        "h, link side", unit="N m", low=0.0, high=10.0, minimum=0.0, source="chosen: some N m of rubbing strands"
    )
    width: Array = parameter(
        "w, travel after a reversal at which all strands slip, link side",
        tries=(0.03, 0.2),
        unit="rad",
        null=None,
        low=0.02,
        high=0.5,
        minimum=1e-4,
        default=0.1,
        source="chosen: some degrees",
    )
    neutral: Array = parameter(
        "q_0, angle at which they were laid",
        unit="rad",
        null=None,
        low=-1.5,
        high=1.5,
        default=0.0,
        role="span",
        source="any",
    )

    def initial_memory(self, state: State) -> Array:
        """See base class; strands are relaxed."""
        return np.zeros((*state.joint_angle.shape, 1))

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """See base class; the last physics step moved the link by its present speed."""
        speed = state.link_speed
        slip = advance_slip(memory, speed, speed, dt, self.width[..., None])
        return self._pull(state, slip), slip

    def torques_over(self, states: State, dt: float) -> Torques:
        """See base class."""
        speed = np.broadcast_to(states.link_speed, states.motor_angle.shape)
        return self._pull(states, advance_slip_along(speed, dt, self.width[..., None]))

    def _pull(self, state: State, slip: Array) -> Torques:
        return Torques(link=-(self.stiffness * (state.link_angle - self.neutral) + self.hysteresis * slip[..., 0]))
