"""Physical effects that a robot may have and its nominal model may lack: one family, four ways in.

A member is a frozen dataclass whose fields are parameters, declared by `parameter`. It enters a simulated robot

- through the description (`NativeEffect`), where MuJoCo has the effect itself: friction, stiffness, masses;
- through the MuJoCo model (`ModelEffect`), where that takes more joints than the description has;
- through torques at every physics step (`TorqueEffect`), on the whole batch at once;
- through what is measured (`ResolverEffect`, in the servo's loop, `TrackerEffect` and `ClockEffect`, after the fact).

One formula serves a physics step of many robots and a whole recording: states carry any leading shape.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields, replace
from typing import Any, ClassVar, Literal, Self

import mujoco
import numpy as np
import scipy

from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.types import Array, BoolArray
from ffgym.effects.parameters import Parameter, declaration_in
from ffgym.effects.state import ResolverError, State, Torques, no_memory
from ffgym.recordings import FAMILIES, Recording
from ffgym.robot import RobotDescription

Side = Literal["motor", "link", "tool", "controller"]


class Effect(ABC):
    """Physical effect of a robot. Parameters are arrays once built, and cannot be changed.

    Raises:
        FFGymError: if a parameter has a wrong shape, is not finite, or is below or above what makes sense.
    """

    name: ClassVar[str]
    """Name in files and on command lines."""
    code: ClassVar[str] = ""
    """Short name of the documentation, e.g. 'F6'; empty for one that only a workcell knows."""
    title: ClassVar[str]
    equation: ClassVar[str]
    """Equation, with the term that the effect adds to it."""
    side: ClassVar[Side]
    """Place where it acts."""
    signature: ClassVar[str]
    """Signature in measurements."""
    way_in: ClassVar[str]
    """Way into the simulation, for the documentation."""
    confusable_with: ClassVar[tuple[str, ...]] = ()
    """Codes of effects that look alike in most motions."""
    separating_motions: ClassVar[tuple[str, ...]] = ()
    """Protocols (`ffgym record`) whose recordings separate it from those."""
    needs_elasticity: ClassVar[bool] = False
    """True if it acts through the elasticity of the joint, so that a rigid joint cannot have it."""
    alike_in_torque: ClassVar[tuple[str, ...]] = ()
    """Codes of effects that it cannot be told from for sure where nothing measures the arm, tool or links."""
    varies_with: ClassVar[tuple[Literal["temperature", "running"], ...]] = ()
    """Fields of the state without whose change it looks like a simpler effect."""
    at_low_speed: ClassVar[bool] = False
    """True if it acts at low speed and after reversals alone, a range that not every description covers."""
    needs_friction: ClassVar[bool] = False
    """True if it acts on the friction of the motor."""
    needs_tool: ClassVar[bool] = False
    """True if it acts at the tool, so that a robot without one cannot have it."""
    patterns: ClassVar[tuple[tuple[str, str], ...]] = ()
    """Patterns of a residual that its equation has the form of, the nearest first: kind and variable, as a diagnosis
    names them."""
    generalises: ClassVar[tuple[str, ...]] = ()
    """Simpler effects that it contains (nearly) for some values of its parameters: it is no rival of theirs unless it
    explains more, and belongs to the same family."""

    def __post_init__(self) -> None:
        known_ones = self.parameters().values()
        given = {p.name: p.numbers(self.name, getattr(self, p.name)) for p in known_ones}
        # the number of joints, from what is given per joint; one number alone is one joint
        lengths = {len(given[p.name]) for p in known_ones if p.per in ("joint", "pair") and given[p.name].ndim > 0}
        if len(lengths) > 1:
            raise FFGymError(
                f"Parameters of effect {self.name} are for {sorted(lengths)} joints, must be for one number."
            )
        for known in known_ones:
            array = known.validate(self.name, given[known.name], max(lengths, default=1))
            array.setflags(write=False)
            object.__setattr__(self, known.name, array)

    @classmethod
    def parameters(cls) -> Mapping[str, Parameter]:
        """Parameters by name, in the order of the class."""
        found = {f.name: declaration_in(f.metadata) for f in fields(cls)}  # type: ignore[arg-type]  # members are dataclasses
        return {name: replace(known, name=name) for name, known in found.items() if known is not None}

    @classmethod
    def on(cls, robot: RobotDescription, joint: str | None = None, **values: Any) -> Self:
        """Build the effect on one joint of a robot, or with the same numbers on all; other joints keep null values.

        Raises:
            FFGymError: if the robot has no such joint, or a value is unknown or not valid.
        """
        full, known = {}, cls.parameters()
        chosen = np.ones(robot.n_joints, dtype=np.bool_)
        if joint is not None:
            check_choice("joint", joint, robot.joints)
            chosen = np.array([name == joint for name in robot.joints])
        for name, value in values.items():
            check_choice(f"parameter of {cls.name}", name, list(known))
            given = known[name].validate(cls.name, value, robot.n_joints)
            per_joint = known[name].per == "joint"
            full[name] = np.where(chosen, given, known[name].neutral) if per_joint else given
        if missing := [f.name for f in fields(cls) if f.default is MISSING and f.name not in full]:  # type: ignore[arg-type]
            raise FFGymError(f"Effect {cls.name} lacks {missing}; without effect they would be at their null value.")
        return cls(**full)

    @property
    def n_joints(self) -> int | None:
        """Number of joints N that it has parameters for; None if it has none per joint."""
        sizes = {getattr(self, p.name).shape[0] for p in self.parameters().values() if p.per in ("joint", "pair")}
        return sizes.pop() if sizes else None

    @property
    def is_null(self) -> bool:
        """True if it vanishes: every parameter is at its null value, if it has one."""
        with_null = [p for p in self.parameters().values() if p.null is not None]
        return all(bool(np.all(getattr(self, p.name) == p.null)) for p in with_null)

    def values(self) -> dict[str, Array]:
        """Parameters by name."""
        return {name: getattr(self, name) for name in self.parameters()}

    def check_fits(self, robot: RobotDescription) -> None:
        """Check that a robot can have the effect.

        Raises:
            FFGymError: if the number of joints differs, or the effect needs a tool that the robot lacks, or elasticity
                where a joint is rigid.
        """
        if self.needs_tool and robot.tool is None:
            raise FFGymError(f"Robot {robot.name!r} has no tool, so it cannot have effect {self.name}.")
        if self.n_joints not in (None, robot.n_joints):
            raise FFGymError(f"Effect {self.name} is for {self.n_joints} joints, {robot.name!r} has {robot.n_joints}.")
        if self.needs_elasticity:
            acts = np.zeros(self.n_joints or 0, dtype=np.bool_)  # where a parameter differs from its null value
            for known in self.parameters().values():
                if known.null is not None and known.per == "joint":
                    acts |= getattr(self, known.name) != known.null
            rigid = [j for j, r, a in zip(robot.joints, robot.drive.is_rigid, acts, strict=True) if r and a]
            if rigid:
                raise FFGymError(
                    f"Effect {self.name} acts in the elasticity of the joint, but {rigid} of {robot.name!r} are rigid. "
                    f"Give them a joint_stiffness, or leave the effect at its null value there."
                )


class NativeEffect(Effect):
    """Effect that is a change of numbers in the description."""

    @abstractmethod
    def in_description(self, robot: RobotDescription) -> RobotDescription:
        """Return the robot with the effect."""


class ModelEffect(Effect):
    """Effect that needs more in the MuJoCo model than a description makes."""

    @abstractmethod
    def in_model(self, spec: mujoco.MjSpec, robot: RobotDescription) -> None:
        """Add the effect to the model."""


class TorqueEffect(Effect):
    """Effect that adds torques, computed at every physics step."""

    follows_motor: ClassVar[bool] = False
    """True if its torque behind the gearbox depends on the motor alone, not on the deflection of the joint."""

    def check_step(self, dt: float) -> None:
        """Check that the effect can be computed at physics steps of `dt` [s].

        Raises:
            FFGymError: if it cannot.
        """

    def initial_memory(self, state: State) -> Array:
        """Return the memory of a machine at rest, shape (..., N, M); without memory M = 0."""
        return no_memory(state)

    @abstractmethod
    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """Return torques at `state`, and the memory `dt` [s] later, shape (..., N, M).

        Members use elementwise arithmetic alone, so that a result does not depend on the number of robots in a batch.
        """

    def lead_slope(self, state: State) -> Array | None:
        r"""Return the slope :math:`\partial e / \partial \theta` of a lead e of the output over the motor, (..., N).

        Link side over motor side [1]; None for an effect without such a lead.
        """
        return None

    def torques_over(self, states: State, dt: float) -> Torques | None:
        """Return the torques at T samples `dt` [s] apart at once, (T, ..., N), if the effect has a fast formula for it.

        None if it must go from sample to sample.
        """
        return None


@dataclass(slots=True, kw_only=True, eq=False)
class Braking:
    """Torque of friction on links at a state, and its slopes, for steps that are implicit in the speed; (..., N)."""

    torque: Array
    """Torque on the link, link side [N m]."""
    slope: Array
    """Torque by which it brakes more per speed of the link [N m s/rad], >= 0."""
    memory: Array
    """Memory at the state, (..., N, M)."""
    memory_slope: Array
    """Change of that per speed of the link, (..., N, M)."""


class LinkBrake(TorqueEffect):
    """Friction on links, behind the elasticity: where links are light, too stiff for steps that are explicit in it."""

    side = "link"
    needs_load: ClassVar[bool] = False
    """True if it depends on the torque that the gearbox passes on."""

    share: Array
    """Size of the effect [1], shape (N,); 0 on joints without it."""

    @property
    def brakes(self) -> BoolArray:
        """Joints that have it, shape (N,)."""
        return self.share > 0

    @abstractmethod
    def reach(self, dt: float) -> Array:
        """Return the change of the links' speed for which slopes hold in a step of `dt` [s], [rad/s], (N,)."""

    @abstractmethod
    def brake(self, speed: Array, load: Array | None, memory: Array, dt: float) -> Braking:
        """Return the torque on links at their present speed.

        Args:
            speed: of the links, link side [rad/s], (..., N).
            load: torque that gearboxes pass on, link side [N m], (..., N); None where it is not needed.
            memory: `dt` before, (..., N, M).
            dt: time since then [s].
        """

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """Return the torque on the link; the last step brought it to its present speed."""
        braking = self.brake(state.link_speed, state.load if self.needs_load else None, memory, dt)
        return Torques(link=braking.torque), braking.memory


class FrictionEffect(TorqueEffect):
    """Effect that adds to the friction of the motor, without memory."""

    side = "motor"
    way_in = "torque at every physics step"
    needs_friction = True

    @abstractmethod
    def friction(self, state: State) -> Array:
        """Return friction beyond that of the description, motor side [N m], (..., N); positive brakes forwards."""

    def torques(self, state: State, memory: Array, dt: float) -> tuple[Torques, Array]:
        """Return minus the friction; nothing is remembered."""
        return Torques(motor=-self.friction(state)), memory


class ResolverEffect(Effect):
    """An error of the motor's position sensor, which the servo acts on."""

    @abstractmethod
    def error(self, motor_angle: Array, motor_speed: Array) -> ResolverError:
        """Return the error of the measured motor angle [rad] and speed [rad/s], motor side, (..., N)."""


class TrackerEffect(Effect):
    """Error of the measured tool position."""

    @abstractmethod
    def measure(self, recording: Recording, robot: RobotDescription) -> Recording:
        """Return the recording as the tracker sees it; `tcp.*` columns change, no others."""


class ClockEffect(Effect):
    """Delay of a sensor: samples are written into rows of a later time."""

    families: ClassVar[tuple[str, ...]]
    """Families of columns that are delayed."""

    latency: Array

    def delay(self, values: Array, dt: float) -> Array:
        """Delay `values` (T, ...), sampled every `dt` [s]; before the first sample they were constant."""
        t = np.arange(len(values)) * dt
        late: Array = scipy.interpolate.CubicSpline(t, values)(np.clip(t - self.latency, 0.0, t[-1]))
        return late

    def undo_delay(self, values: Array, dt: float) -> Array:
        """Return values (T, ...) at the instants at which they were sampled, `dt` [s] apart; the last is held."""
        t = np.arange(len(values)) * dt
        sampled: Array = scipy.interpolate.CubicSpline(t, values)(np.clip(t + self.latency, 0.0, t[-1]))
        return sampled

    def measure(self, recording: Recording, robot: RobotDescription) -> Recording:
        """Return the recording as it is logged, with delayed columns; absent columns stay absent."""
        columns = {
            column: self.delay(recording[column], recording.dt)
            for family in self.families
            for column in FAMILIES[family].columns(recording.header.joints)
            if column in recording.columns
        }
        return recording.with_columns(columns)
