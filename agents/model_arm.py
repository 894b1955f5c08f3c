"""Friction behind the elasticity in model feed-forward: beside effects, at states where a law puts the arm.

Effects on springs see it in the load of the gearbox, sample by sample. Its lead is that of the linear spring, resolved
within control steps (`ffgym.agents.arm_friction`).
"""

from dataclasses import dataclass, replace

from ffgym.agents.arm_friction import ArmStep, ReferenceArmFriction
from ffgym.agents.elastic_memory import ArmPast
from ffgym.agents.flexible_joints import Lead
from ffgym.agents.model_memory import Carried, Past
from ffgym.core.types import Array
from ffgym.effects import State


@dataclass(frozen=True, kw_only=True, eq=False)
class ModelArm:
    """Friction on the arm within one control step of a law."""

    friction: ReferenceArmFriction
    past: ArmPast
    """Memory at the start of the step."""
    step: ArmStep
    dt: float
    """Length of the step [s]."""
    load: Array
    """Friction at the start of the step, which is in the load that effects see, link side [N m], (..., N)."""

    @classmethod
    def along(
        cls, friction: ReferenceArmFriction | None, past: Past, motor_dq: Array, next_motor_dq: Array, dt: float
    ) -> "ModelArm | None":
        """Solve a step between motor speeds of the reference [rad/s]; None for a machine without such friction."""
        if friction is None or past.arm is None:
            return None
        step = friction.within(past.arm.state, motor_dq, next_motor_dq, dt)
        load = friction.at(past.arm.state.bristle, motor_dq)
        return cls(friction=friction, past=past.arm, step=step, dt=dt, load=load)

    def leads(self, lead: Lead, next_lead: Lead) -> tuple[Lead, Lead]:
        """Add the angles by which the friction makes motors lead at both ends of the step; speeds: `within`."""
        angles = ((lead, self.past.state.lead), (next_lead, self.step.after.lead))
        here, after = (replace(each, angle=each.angle + more) for each, more in angles)
        return here, after

    @property
    def motor_speed(self) -> Array:
        """Speed of the motors within the step that the friction asks for [rad/s], (S, ..., N)."""
        return self.friction.drive.motor_angle(self.step.lead_speed)

    def within(self, states: State) -> State:
        """Add the speed of the lead to states in the middle of S sub-steps."""
        speed = self.step.lead_speed
        return states.with_values(
            joint_speed=states.joint_speed + speed, deflection_rate=states.deflection_rate - speed
        )

    def command(self, command: Array) -> Array:
        """Add to a command that has the friction at the sample what its average around the sample asks for [N m]."""
        drive, asked = self.friction.drive, self.past.asked + self.step.parts(self.dt)[0]
        turned = drive.rotor_inertia * drive.motor_angle(asked.lead.acceleration)
        return command + drive.motor_torque(asked.torque - self.load) + turned

    def seen(self, lead: Lead) -> Lead:
        """Add the lead that the friction asks for, averaged around the start of the step."""
        return lead + (self.past.asked + self.step.parts(self.dt)[0]).lead

    def later(self, past: Past) -> Past:
        """Add the friction at the end of the step, and the integral of its lead, to a memory."""
        arm = ArmPast(state=self.step.after, asked=self.step.parts(self.dt)[1])
        return replace(past, arm=arm, integral=past.integral + self.dt * self.step.mean_lead)


@dataclass(frozen=True, kw_only=True, eq=False)
class AheadOnArm:
    """Friction on the arm at the newest sample that a law sees, for effects that see the load of the gearbox."""

    load: Array
    """Friction at the sample, link side [N m], (..., N)."""
    before: Array
    """Friction at the sample before [N m]."""
    bristle: Array
    """Deflection of the bristles at the sample [rad], motor units."""

    @classmethod
    def next(
        cls, friction: ReferenceArmFriction, bristle: Array, motor_dq: Array, next_motor_dq: Array, dt: float
    ) -> "AheadOnArm":
        """Advance from the bristles at a sample to the next one; speeds of the motors along the reference [rad/s]."""
        later = friction.slide(bristle, motor_dq, next_motor_dq, dt)
        before, load = friction.at(bristle, motor_dq), friction.at(later, next_motor_dq)
        return cls(load=load, before=before, bristle=later)

    def bent(self, before: Carried) -> Carried:
        """Add the friction to what was carried at the sample before: the spring bent by both."""
        return replace(before, bend=before.bend + self.before)

    def unbent(self, carried: Carried) -> Carried:
        """Take the friction from the bend of the spring, as its lead is computed beside it."""
        return replace(carried, bend=carried.bend - self.load)
