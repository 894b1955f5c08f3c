"""Nuisance parameters: numbers of the nominal model that may be off, and the prior of how far.

They are fitted beside every hypothesis, so that a link that is a per cent heavier is not taken for an effect.

A row has one time stamp, but its columns are read one after the other; a servo computes for a part of its cycle, knows
speeds as differences of angles, and may filter them; friction lags behind the speed. No description says any of that.
An engine that takes steps does all of it, by half a step or a whole one.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar, final

import numpy as np

from ffgym.core.errors import check_number
from ffgym.core.measures import rms
from ffgym.core.types import Array
from ffgym.diagnosis.identification.rigid_body.base import base_parameters
from ffgym.diagnosis.identification.rigid_body.terms import BODIES, ROTOR_INERTIA, rigid_motion
from ffgym.diagnosis.perturbation import Parts
from ffgym.diagnosis.replay import Replay, predict_feedback
from ffgym.diagnosis.residual import Channel
from ffgym.diagnosis.sensitivity import Sensitivity, compute_machine_sensitivities, compute_sensitivities
from ffgym.diagnosis.settings import settings
from ffgym.effects import ClockEffect, Effect, NativeEffect
from ffgym.effects.drive.delay import TorqueDelay
from ffgym.effects.drive.offset import TorqueOffset
from ffgym.effects.drive.torque_constant import TorqueConstant
from ffgym.effects.effect import Side
from ffgym.effects.friction.coulomb import CoulombLevel
from ffgym.effects.friction.presliding import PreslidingStiffness
from ffgym.effects.friction.stribeck import StribeckPeak
from ffgym.effects.friction.viscous import ViscousLevel
from ffgym.effects.load.rotor_inertia import RotorInertia
from ffgym.effects.measurement.tool_frame import ToolFrame
from ffgym.effects.measurement.torque_clock import TorqueClock
from ffgym.effects.parameters import parameter
from ffgym.effects.transmission.stiffness import JointStiffness
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription

_TERMS = (BODIES, ROTOR_INERTIA)


@dataclass(frozen=True, kw_only=True, eq=False)
class Lateness(ClockEffect):
    r"""A signal x of an earlier instant than the row that it stands in, :math:`x(t - d)`; a doubt, not to be named."""

    name: ClassVar[str] = "lateness"
    side: ClassVar[Side] = "controller"
    families: ClassVar[tuple[str, ...]] = ("feedback.effort",)

    latency: Array = parameter("d", unit="s", low=-1e-3, high=1e-3, per="machine", source="only a doubt")


@final
class RowOffset(Lateness):
    r"""Torque written for another instant of a row than position, :math:`u_{log}(t) = u(t - d)`."""

    name: ClassVar[str] = "row_offset"
    families: ClassVar[tuple[str, ...]] = ("motor.effort",)


def is_row_offset(kind: type[Effect], n_joints: int) -> bool:
    """Tell whether an effect makes the torque of all joints late by one time, as `RowOffset` does.

    A log shows the sum of both alone: with an effect of that kind in the model, the doubt would trade time with it.
    """
    return kind is TorqueClock or (kind is TorqueDelay and n_joints == 1)


_MASS_STEP = 0.03
"""Relative step of masses; their effect is linear."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _OfLinks(NativeEffect):
    """Numbers of links other than described; a nuisance parameter."""

    side: ClassVar[Side] = "link"

    change: Array = parameter("a", unit="1", low=-0.1, high=0.1, minimum=-0.9, source="only a doubt")

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """Scale the numbers of the description."""
        factor = 1 + self.change
        mass = robot.bodies.mass * (factor if isinstance(self, LinkMass) else 1.0)
        return replace(robot, bodies=replace(robot.bodies, mass=mass, inertia=robot.bodies.inertia * factor[:, None]))


@final
class LinkMass(_OfLinks):
    r"""Masses and inertias of links other than described, :math:`m_i \to (1 + a) m_i, I_i \to (1 + a) I_i`."""

    name: ClassVar[str] = "link_mass"


@final
class LinkInertia(_OfLinks):
    r"""Inertias of links about their centres of mass other than described, :math:`I_i \to (1 + a) I_i`."""

    name: ClassVar[str] = "link_inertia"


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class JointDamping(NativeEffect):
    r"""Damping of the joints other than described, :math:`d \to (1 + a) d`: seen near resonances; a doubt."""

    name: ClassVar[str] = "joint_damping"
    side: ClassVar[Side] = "link"
    needs_elasticity: ClassVar[bool] = True

    change: Array = parameter("a", unit="1", low=-0.5, high=0.5, minimum=-0.9, source="only a doubt")

    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """Scale the numbers of the description."""
        damping = robot.drive.joint_damping * (1 + self.change)
        return replace(robot, drive=replace(robot.drive, joint_damping=damping))


Refit = Callable[[Sequence[Recording]], RobotDescription]
"""Function from recordings, whose torque is without that of causes, to the robot that they are of."""


@dataclass(frozen=True, kw_only=True)
class ParameterPrior:
    """Prior of the numbers of the nominal model, as standard deviations."""

    share: float = field(default_factory=lambda: settings().prior.share)
    """Standard deviation of masses, rotors, stiffness, damping and friction, relative."""
    levels: float | None = None
    """Standard deviation of Coulomb and viscous friction, relative, where they are known less well; None is `share`."""
    torque_constant: float = 0.0
    """Error of torque per current, relative, where the torque of a log is a current times a number that was not
    measured; 0 where torque is known."""
    offset: float = field(default_factory=lambda: settings().prior.offset * settings().prior.share)
    """Standard deviation of torque offsets, as a share of the Coulomb torque."""
    tool: float = field(default_factory=lambda: settings().prior.tool_offset)
    """Standard deviation of the tool's place, each axis [m]."""
    base: float = 0.0
    """Error of each base parameter of the rigid arm, as a share of the torque that motors take: for masses and inertias
    that were fitted to torque, which knows these combinations alone. 0: of masses and rotors one by one, by `share`."""

    refit: Refit | None = field(default=None, repr=False, compare=False)
    """Fits the numbers anew that were fitted to the logs: to what is left of their torque without that of causes."""

    def __post_init__(self) -> None:
        check_number("calibration share", self.share, low=0.0, high=1.0, open_low=True)
        if self.levels is not None:
            check_number("calibration levels", self.levels, low=0.0, open_low=True)
        check_number("calibration torque_constant", self.torque_constant, low=0.0, high=1.0)
        check_number("calibration offset", self.offset, low=0.0, open_low=True)
        check_number("calibration tool", self.tool, unit="m", low=0.0, open_low=True)
        check_number("calibration base", self.base, low=0.0, high=1.0)

    @classmethod
    def of_share(cls, share: float) -> "ParameterPrior":
        """Calibration with relative errors of standard deviation `share`."""
        return cls(share=share, offset=settings().prior.offset * share)

    @property
    def of_levels(self) -> float:
        """Standard deviation of Coulomb and viscous friction, relative."""
        return self.share if self.levels is None else self.levels

    @property
    def open_numbers(self) -> frozenset[type[Effect]]:
        """Effects that are numbers of the model as little known as the effects are large: none of them is a cause."""
        found: set[type[Effect]] = set()
        if self.of_levels >= settings().prior.open_friction:
            found |= {CoulombLevel, ViscousLevel}
        if self.torque_constant > 0:
            found.add(TorqueConstant)
        if self.base > 0:
            found.add(RotorInertia)
        return frozenset(found)


@dataclass(frozen=True, kw_only=True, eq=False)
class NuisanceParameter:
    """A column of what calibration leaves open."""

    column: Sensitivity
    sigma: float
    """Standard deviation of its parameter, in the parameter's unit."""
    at: float = 0.0
    """Place of the nominal machine already, in standard deviations from what is described."""

    @property
    def per_sigma(self) -> Parts:
        """The column per standard deviation."""
        return {key: rows * self.sigma for key, rows in self.column.parts.items()}

    @property
    def limits(self) -> tuple[float, float]:
        """Lowest and highest value, in standard deviations: as far as errors go, and as a machine can be so."""
        limits = settings().prior
        known = self.column.effect.parameters()[self.column.parameter]
        low, high = ((end - known.neutral) / self.sigma for end in (known.minimum, known.maximum))
        return max(-limits.bound - self.at, low), min(limits.bound - self.at, high)


def list_nuisance_parameters(run: Replay, prior: ParameterPrior) -> list[NuisanceParameter]:
    """List all nuisance parameters with their sensitivities along a nominal replay."""
    robot, share = run.robot, prior.share
    coulomb = dict(zip(robot.joints, robot.friction.coulomb.tolist(), strict=True))
    static = dict(zip(robot.joints, robot.friction.static.tolist(), strict=True))

    def each(sigma: float, *kinds: type[Effect]) -> list[NuisanceParameter]:
        return [NuisanceParameter(column=column, sigma=sigma) for column in compute_sensitivities(run, kinds, {})]

    elastic = () if robot.drive.is_rigid.all() else (JointStiffness, JointDamping)
    # friction levels, bristles, springs and torque constants
    found = each(prior.of_levels, CoulombLevel, ViscousLevel) + each(share, PreslidingStiffness, *elastic)
    if prior.torque_constant > 0:
        constants = each(prior.torque_constant, TorqueConstant)
        found += [nuisance for nuisance in constants if nuisance.column.parameter == "error"]
    # breakaway torque is a share of itself off, and a peak is what it has beyond another Coulomb torque
    for column in compute_sensitivities(run, [StribeckPeak], {}):
        of_level = float(np.hypot(static[column.joint] / coulomb[column.joint], 1.0))
        found.append(NuisanceParameter(column=column, sigma=share * (of_level if column.parameter == "level" else 1.0)))
    # masses and rotors: by base parameters where they were fitted to torque, else one by one
    if prior.base > 0:
        found += _list_base_parameters(run, prior.base)
    else:
        found += each(share, RotorInertia)
        for kind in (LinkMass, LinkInertia):
            of_link = [kind(change=_MASS_STEP * link) for link in np.eye(robot.n_joints)]
            columns = compute_machine_sensitivities(
                run, list(zip(robot.joints, of_link, strict=True)), "change", _MASS_STEP
            )
            found += [NuisanceParameter(column=column, sigma=share) for column in columns]
    # offsets, latencies and the place of the tool
    for column in compute_sensitivities(run, [TorqueOffset], {}):
        found.append(NuisanceParameter(column=column, sigma=prior.offset * coulomb[column.joint]))
    found += _list_latencies(run)
    if run.log.tool is not None:
        found += each(prior.tool, ToolFrame)
    return found


def _list_latencies(run: Replay) -> list[NuisanceParameter]:
    """List latencies of signals, with changes of the predictions per second.

    Late are the torque of a row, beside its position; friction, by the speed of an earlier instant, most at reversals;
    the feedback torque of the servo, and the speeds that the servo knows.

    Reference:
        Hess, Soom (1990), ASME Journal of Tribology 112(1), 147-152: friction at oscillating sliding velocities.
    """
    limits = settings().prior
    log, drive, servo = run.log, run.robot.drive, run.robot.servo
    # time derivative of each signal that may be late, and by how much it may be
    signals: list[tuple[type[Lateness], Channel, Array, float]] = [
        (RowOffset, "torque", -np.gradient(run.torque, log.dt, axis=0), limits.late_rows * log.dt),
        (Lateness, "torque", -np.gradient(run.bristles.torque, log.dt, axis=0), limits.friction_lag),
    ]
    # the servo's own delays: of its output, and of the speed that it measures
    if log.shows_servo:
        computed = -np.gradient(predict_feedback(run.read, run.robot), log.dt, axis=0)
        known = servo.velocity_gain * drive.motor_angle(run.read.ddq)
        signals += [(Lateness, "servo", rate, limits.late_cycles * servo.control_dt) for rate in (computed, known)]
    found = []
    for effect, channel, rate, sigma in signals:
        rows = log.sampling(rate)
        parts: Parts = {(channel, j): rows[..., j] for j in range(run.robot.n_joints)}
        found.append(
            NuisanceParameter(column=Sensitivity(effect=effect, parameter="latency", parts=parts), sigma=sigma)
        )
    return found


def _list_base_parameters(run: Replay, sigma: float) -> list[NuisanceParameter]:
    """List base parameters of bodies and rotors, with the motor torque that each adds along a replay.

    Together they span all torques that other masses, centres of mass, inertias and rotors would give a rigid arm. Each
    is as large as the torque of the motor on which it is largest, so that one number says how far all are left open.
    """
    robot, log = run.robot, run.log
    motion = rigid_motion(robot, *(x.reshape(-1, robot.n_joints) for x in (log.q, log.dq, log.ddq)))
    own, taken = base_parameters(robot, _TERMS).own, rms(run.torque, (0, 1))
    found: list[NuisanceParameter] = []
    columns = np.concatenate([part for term in _TERMS for part in term.columns(robot, motion)], axis=1)
    for k in own:
        torque = columns[:, k].reshape(log.q.shape)
        size = float(np.max(rms(torque, (0, 1))[taken > 0] / taken[taken > 0], initial=0.0))
        if size > 0:
            rows = log.sampling(torque / size)
            parts: Parts = {("torque", j): rows[..., j] for j in range(robot.n_joints)}
            column = Sensitivity(effect=LinkMass, parameter="change", choice=len(found), parts=parts)
            found.append(NuisanceParameter(column=column, sigma=sigma))
    return found
