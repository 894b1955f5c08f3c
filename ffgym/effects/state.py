"""The state that effects are asked at: numbers of the machine, its motion, and what follows from both.

Every variable stands here once. A plant takes them from the engine, a replay from measured motions, a feed-forward law
from its reference: each gives what it has, and all else follows by the formulas below, when it is first asked for. So a
new variable that follows from others, or is a number of the description or of the climate, is one entry of `State`.
"""

from collections.abc import Callable, Set
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, Self

import numpy as np

from ffgym.core.errors import check_choice
from ffgym.core.types import Array, BoolArray
from ffgym.effects.climate import Climate, warm_up
from ffgym.robot import RobotDescription
from ffgym.robot.drive import Drive
from ffgym.robot.friction import stribeck_level


class _Given:
    """Variable that a source of states gives, or reads by a method `read_<name>` when it is first asked for."""

    def __init__(self, *default: Any) -> None:
        self.default = default

    def __set_name__(self, owner: type, name: str) -> None:
        self.name, self.method = name, f"read_{name}"

    def __get__(self, state: Any, owner: type | None = None) -> Any:
        if state is None:
            return self
        read = getattr(state, self.method, None)
        if read is not None:
            value = state.__dict__[self.name] = read()
            return value
        if not self.default:
            raise AttributeError(self.name)
        return self.default[0]


class _Number(_Given):
    """Number of a machine; `where` says in which part of it, as 'drive.peak_torque'."""

    def __init__(self, where: str, *, if_rigid: float | None = None) -> None:
        super().__init__()
        self.part, self.attribute = where.split(".")
        self.if_rigid = if_rigid

    def read(self, robot: RobotDescription, climate: Climate) -> Array:
        """Read it, shape (N,) if each joint has its own, else (1,)."""
        value = np.asarray(getattr(climate if self.part == "climate" else getattr(robot, self.part), self.attribute))
        if self.if_rigid is not None:
            value = np.where(robot.drive.is_rigid, self.if_rigid, value)
        return np.broadcast_to(value, (robot.n_joints,)) if value.ndim else value.reshape(1)


def given(*default: Any) -> Any:
    """Declare a variable that a source of states gives, or has the default."""
    return _Given(*default)


def number(where: str, *, if_rigid: float | None = None) -> Any:
    """Declare a number of the machine: where it stands, and what it is for a rigid joint, if that is something else."""
    return _Number(where, if_rigid=if_rigid)


class State:
    """Motion of all joints; every array ends in (..., N) or (..., 1), with B robots or T samples before it.

    A formula uses variables above it alone, so that those below a variable are all that can follow from it.

    Raises:
        FFGymError: if a variable is given that a state does not have.
    """

    drive: Drive
    """Relation of both sides of the gearbox."""
    _given: Set[str]
    """Variables that do not follow from others."""

    joint_stiffness: Array = number("drive.joint_stiffness", if_rigid=0.0)
    """Stiffness of the joint's elasticity, link side [N m/rad]; 0 for a rigid joint."""
    joint_damping: Array = number("drive.joint_damping", if_rigid=0.0)
    """Damping of the joint's elasticity, link side [N m s/rad]; 0 for a rigid joint."""
    is_rigid: BoolArray = number("drive.is_rigid")
    """True for joints without elasticity."""
    peak_torque: Array = number("drive.peak_torque")
    """Largest torque that the drive gives, motor side [N m]."""
    coulomb: Array = number("friction.coulomb")
    """Coulomb friction f_c of the description, motor side [N m], as are the next four."""
    static: Array = number("friction.static")
    """Breakaway torque f_s [N m]."""
    viscous: Array = number("friction.viscous")
    """Viscous coefficient f_v [N m s/rad]."""
    stribeck_velocity: Array = number("friction.stribeck_velocity")
    """Stribeck velocity v_s [rad/s]."""
    bristle_stiffness: Array = number("friction.bristle_stiffness")
    """Stiffness of the bristles sigma_0 [N m/rad]."""
    ambient: Array = number("climate.ambient")
    """Temperature of the room [degC]."""
    rise: Array = number("climate.rise")
    """Rise of each joint's temperature in the end [K]."""
    time_constant: Array = number("climate.time_constant")
    """Time constant of that rise [s]."""
    running_since: Array = number("climate.running_since")
    """Time for which the machine, or its session, had run when the motion began [s]; 0 where it is not known."""

    time: Array = given()
    """Time since the motion began [s]."""

    @cached_property
    def running(self) -> Array:
        """Time since the machine was switched on, or its session began [s]."""
        return self.running_since + self.time

    @cached_property
    def temperature(self) -> Array:
        """Temperature of gearbox and motor [degC]."""
        return warm_up(self.ambient, self.rise, self.time_constant, self.running)

    joint_angle: Array = given()
    """Angle of the gearbox output, link side [rad]: where the joint would be without elasticity."""
    joint_speed: Array = given()
    """Speed of the gearbox output, link side [rad/s]."""

    @cached_property
    def motor_angle(self) -> Array:
        """Angle of the motor [rad], motor side."""
        return self.drive.motor_angle(self.joint_angle)

    @cached_property
    def motor_speed(self) -> Array:
        """Speed of the motor [rad/s], motor side."""
        return self.drive.motor_angle(self.joint_speed)

    bristle: Array = given()
    """Deflection z of the LuGre bristles, motor side [rad]."""

    @cached_property
    def friction_level(self) -> Array:
        """Friction g(v) in steady sliding at the motor speed, without viscous part, motor side [N m]."""
        return stribeck_level(self.motor_speed, self.coulomb, self.static, self.stribeck_velocity)

    @cached_property
    def friction_sign(self) -> Array:
        """LuGre-smoothed sign of the motor speed s = sigma_0 z / g(v) [1], between -1 and 1."""
        return self.bristle_stiffness * self.bristle / self.friction_level

    feedback_torque: Array = given()
    """Torque that the servo adds by its position, speed and integral errors, motor side [N m]."""
    command: Array = given()
    """Torque that the servo asks for, feed-forward included, motor side [N m]."""

    @cached_property
    def motor_torque(self) -> Array:
        """Torque that the servo commands, feed-forward included and limited, motor side [N m]."""
        return np.minimum(np.maximum(self.command, -self.peak_torque), self.peak_torque)

    @cached_property
    def loop_torque(self) -> Array:
        """Torque that the torque loop gives, motor side [N m]; as commanded, where the source knows no loop."""
        return self.motor_torque

    deflection: Array = given()
    """Angle of the link behind the gearbox output, link side [rad]; 0 for a rigid joint."""
    deflection_rate: Array = given()
    """Speed of the link behind the gearbox output, link side [rad/s]."""

    @cached_property
    def link_angle(self) -> Array:
        """Angle of the link [rad], link side."""
        return self.joint_angle + self.deflection

    @cached_property
    def link_speed(self) -> Array:
        """Speed of the link [rad/s], link side."""
        return self.joint_speed + self.deflection_rate

    rigid_load: Array | None = given(None)
    """Torque that links behind rigid joints ask for, link side [N m]; None where it is not known."""
    wound: Array | None = given(None)
    """Torque by which effects wind the springs, link side [N m]; None is nothing."""

    @cached_property
    def load(self) -> Array:
        """Torque that the gearbox passes on to the link, link side [N m]; of a rigid joint what its links ask for."""
        load: Array = -(self.joint_stiffness * self.deflection + self.joint_damping * self.deflection_rate)
        if self.rigid_load is not None:
            load = np.where(self.is_rigid, self.rigid_load, load)
        return load if self.wound is None else load + self.wound

    @cached_property
    def load_at_motor(self) -> Array:
        """The same torque as the motor bears it, motor side [N m]."""
        return self.drive.motor_torque(self.load)

    def __init__(self, **values: Any) -> None:
        for name in values.keys() - {"drive"}:
            check_choice("variable of a state", name, self.names())
        self.__dict__.update(values, _given=values.keys())

    def __getattr__(self, name: str) -> Any:
        """Say why there is no such variable; called by Python where one is not found."""
        if name in self.names():
            raise AttributeError(f"This state was made without {name}, and without variables that it follows from.")
        raise AttributeError(f"A state has no {name}. Available: {', '.join(self.names())}.")

    @classmethod
    @cache
    def names(cls) -> tuple[str, ...]:
        """Variables in their order."""
        kinds = (_Given, cached_property)
        every = {name: value for kind in reversed(cls.__mro__) for name, value in vars(kind).items()}
        return tuple(name for name, value in every.items() if isinstance(value, kinds))

    @classmethod
    def numbers(cls, robot: RobotDescription, climate: Climate | None = None) -> dict[str, Array]:
        """Numbers of a machine, shape (N,) or (1,) each; `climate` is None if it is unknown."""
        known, declared = climate or Climate(), ((name, getattr(cls, name)) for name in cls.names())
        return {name: kind.read(robot, known) for name, kind in declared if isinstance(kind, _Number)}

    @classmethod
    def of(cls, robot: RobotDescription, climate: Climate | None = None, **values: Any) -> Self:
        """State of a robot in a climate, with the variables that a source gives."""
        return cls(drive=robot.drive, **cls.numbers(robot, climate) | values)

    def set_values(self, **values: Any) -> None:
        """Give other values; what follows from them is computed anew, but for what was given itself."""
        names, own = self.names(), self.__dict__
        first = min(names.index(name) for name in values)
        own["_given"] = own["_given"] | values.keys()
        for name in names[first:]:
            if name not in own["_given"]:
                own.pop(name, None)
        own.update(values)

    def with_values(self, **values: Any) -> Self:
        """Copy this state with other values, see `set_values`."""
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__)
        other.set_values(**values)
        return other

    def each(self, change: Callable[[Array], Array]) -> "State":
        """State of `change` of every variable that is known so far."""
        names, other = set(self.names()), object.__new__(State)
        for name, value in self.__dict__.items():
            other.__dict__[name] = change(value) if name in names and value is not None else value
        return other


@dataclass(slots=True, kw_only=True, eq=False)
class Torques:
    """Torques that effects add, each (..., N) or None for nothing."""

    motor: Array | None = None
    """Torque on the rotor, motor side [N m]; positive accelerates the motor, so that friction is minus a friction
    law."""
    spring: Array | None = None
    """Between gearbox output and link, link side [N m]; positive accelerates the link and pushes the gearbox back."""
    link: Array | None = None
    """Torque on the link from the link before it, link side [N m]; the gearbox does not carry it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ResolverError:
    """Reading of the resolver beyond the true motor angle, motor side, (..., N) each."""

    angle: Array
    """[rad]."""
    speed: Array
    """[rad/s]."""


def no_memory(state: State) -> Array:
    """Memory of an effect that remembers nothing, shape (..., N, 0)."""
    return np.zeros((*state.motor_angle.shape, 0))
