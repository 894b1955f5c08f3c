r"""Elastic feed-forward: the motors lead the arm by the deflection of the gearboxes, so that it stays on the path.

Idea: a servo holds the motor on the reference, but the arm hangs on a spring behind it. The torque tau_s that the links
need along the reference bends that spring; with joint stiffness K and damping d (all link side) the motor must lead by

.. math:: K \Delta + d \dot\Delta = \tau_s(q, \dot q, \ddot q)

and with gear ratio n, rotor inertia J_m and friction tau_f the added torque moves the motor along q + Delta. It is less
by the torque of the existing controller: rigid feed-forward u_ff, and a servo that sees an error of -n Delta,

.. math:: u_{lff} = \frac{\tau_s}{n} + J_m n (\ddot q + \ddot\Delta) + \tau_f(n (\dot q + \dot\Delta)) - u_{ff}
                    + n (K_p \Delta + K_v \dot\Delta + K_i \int \Delta \, dt)

A motion begins in equilibrium, where springs and servo integral carry gravity: tau_s, Delta and the integral count from
there, so that the change of gravity along the motion is compensated and the sag at its start is kept. The servo's
integral ends where it alone would give the peak torque, and so does the integral here: far from the pose of the start
it gets there within seconds.

Friction that acts on the arm (`friction.arm_share`) is part of tau_s, and what is left of it part of tau_f:
`ffgym.agents.arm_friction`.

Source: inverse dynamics of robots with flexible joints (De Luca and Book, Springer Handbook of Robotics, 2008, section
13.1.2). Departures: only the torque is changed, the set-points stay those of the rigid robot; the springs are damped;
torques run straight between samples, so that friction is averaged around them.

Run it:

    ffgym demo --agents none lugre_dynamic elastic

Logged: nothing, the law learns nothing; `ElasticLaw.motor_torque` is the torque that the drives must give.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import final

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ffgym.agents.arm_friction import ArmStep, Asked, ReferenceArmFriction
from ffgym.agents.declaration import AgentEntry, declare
from ffgym.agents.elastic_memory import ArmPast, ElasticPast
from ffgym.agents.flexible_joints import (
    Lead,
    friction_along,
    given_torque,
    lead_between,
    limit_integral,
    links_torque,
    motion_at,
    step_friction,
    sum_limited,
)
from ffgym.control import CausalLaw, DynamicLuGreExact, LawStyle, Window
from ffgym.core.errors import FFGymError, check_whole
from ffgym.core.types import Array
from ffgym.paths import Reference
from ffgym.robot import RigidArm, RobotDescription, robot_of


def elastic_feedforward(parameters: RobotDescription | str | Path, *, compensate_friction: bool = True) -> "ElasticLaw":
    """Make elastic feed-forward with the parameters of a robot: a description, a name, or a file.

    Args:
        parameters: the robot.
        compensate_friction: False leaves friction to the servo, to show the effect of elasticity alone.

    Raises:
        FFGymError: if the file cannot be read or is wrong, or the robot's springs are damped too strongly.
    """
    arm = RigidArm(robot_of(parameters, "parameters"))
    return elastic_law(arm) if compensate_friction else ElasticLaw(model=arm, friction=None)


def elastic_law(model: RigidArm, controller: RigidArm | None = None, name: str = "elastic") -> "ElasticLaw":
    """Make elastic feed-forward with the dynamic LuGre friction of a model; arguments as in `ElasticLaw`."""
    return ElasticLaw(model=model, controller=controller, friction=DynamicLuGreExact(model.robot.friction), name=name)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ElasticLaw(CausalLaw):
    """Flexible-joint inverse dynamics along the reference, added to the controller that is there.

    Joints of infinite stiffness have no lead: friction and the change of gravity remain for them.
    """

    model: RigidArm
    """Model of the robot in the law: links, springs, rotors."""
    controller: RigidArm | None = None
    """Model behind the existing controller, its servo and rigid feed-forward; defaults to `model`."""
    friction: DynamicLuGreExact | None
    """Friction of the joints, on motors and arm; None leaves it to the servo."""
    preview: int = 4
    """Samples P to see ahead; the lead at a sample comes from P - 2 samples on either side of it."""
    name: str = "elastic"

    def __post_init__(self) -> None:
        check_whole("preview of elastic feed-forward", self.preview, unit="samples", low=3, high=5)
        if not isinstance(self.model, RigidArm):
            raise FFGymError(
                f"model must be a RigidArm, e.g. RigidArm(load_robot('one_axis')), got {type(self.model).__name__}."
            )
        if not isinstance(self.friction, DynamicLuGreExact | None):
            raise FFGymError(f"friction must be a DynamicLuGreExact or None, got {type(self.friction).__name__}.")
        robot, known = self.model.robot, self.known.robot
        if self.friction is not None and self.friction.n_joints != robot.n_joints:
            raise FFGymError(
                f"Friction for {self.friction.n_joints} joints does not fit robot {robot.name!r} with {robot.n_joints}."
            )
        if not np.array_equal(known.drive.matrix, robot.drive.matrix):
            raise FFGymError(
                f"The controller is for gear ratios {known.drive.matrix.tolist()}, robot {robot.name!r} has "
                f"{robot.drive.matrix.tolist()}; both must describe one robot."
            )
        if np.any(self._relaxation > known.servo.control_dt):
            raise FFGymError(
                f"joint_damping / joint_stiffness = {self._relaxation} s of robot {robot.name!r} must be at most the "
                f"control step of {known.servo.control_dt} s: samples do not show how slower springs follow."
            )

    @property
    def n_joints(self) -> int:
        """Number of motors N."""
        return self.model.robot.n_joints

    @property
    def known(self) -> RigidArm:
        """Model behind the existing controller."""
        return self.controller or self.model

    @property
    def _relaxation(self) -> Array:
        """Time constant of the springs d / K [s], shape (N,); 0 for rigid joints."""
        return self.model.robot.drive.joint_damping / self.model.robot.drive.joint_stiffness

    @cached_property
    def arm_friction(self) -> ReferenceArmFriction | None:
        """Friction behind the elasticity; None where there is none, or friction is left to the servo."""
        share = self._arm_share
        if self.friction is None or not np.any(share):
            return None
        return ReferenceArmFriction(law=self.friction, drive=self.model.robot.drive, share=share)

    @property
    def _arm_share(self) -> Array:
        """Share of friction behind the elasticity [1], shape (N,); a rigid joint has it all on one side."""
        share = None if self.friction is None else self.friction.friction.arm_share
        return np.zeros(self.n_joints) if share is None else np.where(self.model.robot.drive.is_rigid, 0.0, share)

    # Along a whole reference

    def torque(self, reference: Reference) -> Array:
        """Compute the torques of `step` for all samples at once."""
        needed, lead, integral = self._along(reference)
        motion = (reference.q, reference.motor_dq, reference.motor_ddq)
        torque = needed - given_torque(self.known, *motion, lead, integral)
        torque[0] = 0.0
        return torque

    def own_errors(self, reference: Reference) -> tuple[Array, Array]:
        """Compute the errors of `own_error` for all samples at once."""
        lead, drive = self._along(reference)[1], self.model.robot.drive
        return -drive.motor_angle(lead.angle), -drive.motor_angle(lead.speed)

    def motor_torque(self, reference: Reference) -> Array:
        """Compute all torque that the motors must give, gravity included [N m], shape (T, N).

        Beyond `drive.peak_torque` the drive clips it, and no feed-forward can help.
        """
        return self._along(reference)[0] + self.model.robot.drive.motor_torque(
            self.model.holding_torque(reference.q[:1])
        )

    def _along(self, reference: Reference) -> tuple[Array, Lead, Array]:
        """Torque that the motors need beyond gravity at the start [N m], lead, integral of the lead [rad s], (T, N)."""
        self.check_joints(reference)
        # torque of the links beyond the load at the start
        dt, reach = reference.robot.servo.control_dt, self.preview - 2
        links = self.links(reference.q, reference.motor_dq, reference.motor_ddq)
        load = self.model.holding_torque(reference.q[:1])
        links -= load
        # lead of the motors and its integral, as the servo sees it
        rows = np.pad(links, ((reach, reach + 1), (0, 0)), mode="edge")  # one sample more, which friction looks at
        ahead = self.lead(np.moveaxis(sliding_window_view(rows, 2 * reach + 1, axis=0), -1, -2), dt)
        speed = self.motor_speed(np.pad(reference.motor_dq, ((0, 1), (0, 0)), mode="edge"), ahead)
        lead = Lead(angle=ahead.angle[:-1], speed=ahead.speed[:-1], acceleration=ahead.acceleration[:-1])
        increments = 0.5 * dt * (lead.angle[:-1] + lead.angle[1:])
        # what friction behind the elasticity asks for beside it
        added = None
        if self.arm_friction is not None:
            arm = self.arm_friction.along(np.pad(reference.motor_dq, ((0, 1), (0, 0)), mode="edge"), dt)
            asked, added = arm.around(dt), self._compute_added_speed(arm)
            links, lead = links + asked.torque, lead + asked.lead
            increments += dt * arm.mean_lead[:-1]
        # friction of the motors, and all lead as the servo integrates it
        friction = np.zeros_like(links)
        if self.friction is not None:
            friction = (1 - self._arm_share) * friction_along(self.friction, speed, dt, added)
        integral = sum_limited(np.zeros_like(load[0]), increments, self.known, load[0])
        return self._moving_torque(links, reference.motor_ddq, lead, friction), lead, integral

    # Sample by sample

    def initial_memory(self, window: Window) -> Array:
        """Return the memory (`ElasticPast`) at rest before the motion."""
        reach, dt = self.preview - 2, window.dt
        gravity = self.links(window.q[..., 0, :], *np.zeros((2, *window.q[..., 0, :].shape)))
        # torque of the links around samples 0 and 1
        seen = slice(0, reach + 2)
        links = self.links(window.q[..., seen, :], window.motor_dq[..., seen, :], window.motor_ddq[..., seen, :])
        links = links - gravity[..., None, :]
        links = np.concatenate([np.repeat(links[..., :1, :], reach, axis=-2), links], axis=-2)  # it rested before
        first, second = self.lead(links[..., :-1, :], dt), self.lead(links[..., 1:, :], dt)
        # friction of the first step, from relaxed bristles on
        ends = ((window.motor_dq[..., 0, :], first), (window.motor_dq[..., 1, :], second))
        past = ElasticPast.at_rest(gravity, links[..., :-2, :], first, arm=self.arm_friction is not None)
        return self._advance(past, links[..., 1:, :], ends, dt)[-1].pack()

    def step(self, memory: Array, window: Window) -> tuple[Array, Array]:
        """Return the torque at sample 1 (`here`) and the memory one sample on; `after` is sample 2."""
        dt, past = window.dt, ElasticPast.unpack(memory, self.n_joints, arm=self.arm_friction is not None)
        # lead at the next sample, from the newest torque of the links
        here, after, newest = (motion_at(window, k) for k in (1, 2, self.preview))
        links = np.concatenate([past.links, (self.links(*newest) - past.gravity)[..., None, :]], axis=-2)
        next_lead = self.lead(links, dt)
        # friction within the step, and the torque that moves arm and motors at sample 1
        friction, asked, later = self._advance(past, links, ((here[1], past.lead), (after[1], next_lead)), dt)
        carried, lead = links[..., self.preview - 3, :], past.lead
        if asked is not None:
            carried, lead = carried + asked.torque, lead + asked.lead
        needed = self._moving_torque(carried, here[2], lead, past.friction + friction)
        later = replace(later, integral=limit_integral(later.integral, self.known, past.gravity))
        return needed - given_torque(self.known, *here, lead, past.integral), later.pack()

    def _advance(
        self, past: ElasticPast, links: Array, ends: Sequence[tuple[Array, Lead]], dt: float
    ) -> tuple[Array, Asked | None, ElasticPast]:
        """Advance by a step.

        Args:
            past: memory at its start.
            links: torque of the links at the samples around its end, and one before [N m], (..., 2 w + 1, N).
            ends: motor speed of the reference [rad/s], and lead for the links, at start and end.
            dt: its length [s].

        Returns:
            Friction of the motors in the step as its part of the start [N m], all that friction on the arm asks for at
            the start, and the memory at the end, with an integral that is not limited yet.
        """
        (dq, lead), (next_dq, next_lead) = ends
        integral = past.integral + 0.5 * dt * (lead.angle + next_lead.angle)
        asked, arm, added = None, None, None
        if self.arm_friction is not None and past.arm is not None:
            step = self.arm_friction.within(past.arm.state, dq, next_dq, dt)
            (start, end), added = step.parts(dt), self._compute_added_speed(step)
            asked, arm = past.arm.asked + start, ArmPast(state=step.after, asked=end)
            integral = integral + dt * step.mean_lead
        speeds = self.motor_speed(dq, lead), self.motor_speed(next_dq, next_lead)
        friction, next_friction, bristle = self._friction(past.bristle, *speeds, dt, added)
        later = ElasticPast(
            gravity=past.gravity,
            links=links[..., 1:, :],
            lead=next_lead,
            integral=integral,
            bristle=bristle,
            friction=next_friction,
            arm=arm,
        )
        return friction, asked, later

    def own_error(self, memory: Array, window: Window) -> tuple[Array, Array]:
        """Return the motor error and its rate that the law causes: motors lead their reference."""
        past = ElasticPast.unpack(memory, self.n_joints, arm=self.arm_friction is not None)
        lead, drive = past.lead, self.model.robot.drive
        if self.arm_friction is not None and past.arm is not None:
            speed, next_speed = (motion_at(window, k)[1] for k in (1, 2))
            step = self.arm_friction.within(past.arm.state, speed, next_speed, window.dt)
            lead = lead + (past.arm.asked + step.parts(window.dt)[0]).lead
        return -drive.motor_angle(lead.angle), -drive.motor_angle(lead.speed)

    def instant_error(self, memory: Array) -> tuple[Array, Array]:
        """Return the motor error and its rate at the instant itself, where friction on the arm may jump."""
        past = ElasticPast.unpack(memory, self.n_joints, arm=self.arm_friction is not None)
        angle, speed, drive = past.lead.angle, past.lead.speed, self.model.robot.drive
        if past.arm is not None:
            angle, speed = angle + past.arm.state.lead, speed + past.arm.state.lead_speed
        return -drive.motor_angle(angle), -drive.motor_angle(speed)

    # Parts of the equation in the head of this file, shape (..., N)

    def links(self, q: Array, motor_dq: Array, motor_ddq: Array) -> Array:
        """Compute the torque of the links with the load they carry at rest, link side [N m]."""
        return links_torque(self.model, q, motor_dq, motor_ddq, load=True)

    def lead(self, links: Array, dt: float) -> Lead:
        """Compute the lead at the middle one of samples of the links' torque [N m], (..., 2 w + 1, N)."""
        return lead_between(links / self.model.robot.drive.joint_stiffness, self._relaxation, dt)

    def motor_speed(self, motor_dq: Array, lead: Lead) -> Array:
        """Compute the motor speed [rad/s] that keeps the arm on the reference."""
        return motor_dq + self.model.robot.drive.motor_angle(lead.speed)

    def _friction(
        self, z: Array, dq: Array, next_dq: Array, dt: float, added: Array | None
    ) -> tuple[Array, Array, Array]:
        """Compute friction of the motors within a step as `step_friction` does; zero without a friction model."""
        if self.friction is None:
            return np.zeros_like(z), np.zeros_like(z), z
        start, end, z = step_friction(self.friction, z, dq, next_dq, dt, added)
        return (1 - self._arm_share) * start, (1 - self._arm_share) * end, z

    def _compute_added_speed(self, arm: ArmStep) -> Array:
        """Compute the speed of the motors that friction on the arm asks for within steps [rad/s], (S, ..., N)."""
        return self.model.robot.drive.motor_angle(arm.lead_speed)

    def _moving_torque(self, links: Array, motor_ddq: Array, lead: Lead, friction: Array) -> Array:
        """Compute the torque that moves arm and motors [N m], beyond gravity at the start."""
        drive = self.model.robot.drive
        rotor = drive.rotor_inertia * (motor_ddq + drive.motor_angle(lead.acceleration))
        return drive.motor_torque(links) + rotor + friction


declare(
    AgentEntry(
        name="elastic",
        title="elastic feed-forward",
        about="Inverse dynamics with flexible joints and dynamic LuGre friction, nominal parameters.",
        track="causal, nominal parameters",
        order=12,
        page="elastic.md",
        style=LawStyle(label="elastic feed-forward", colour="#A50F15", marker="p"),
        make=lambda setting: elastic_law(setting.arm, setting.controller),
    )
)
