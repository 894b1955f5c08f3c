"""Machines: a robot with physical effects and a climate, and what machines of one batch must share."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, Self

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.effects import ClockEffect, Effect, ModelEffect, NativeEffect, ResolverEffect, TorqueEffect, TrackerEffect
from ffgym.effects.climate import Climate as Climate
from ffgym.effects.drive.delay import with_delay_of_drives
from ffgym.recordings import Recording
from ffgym.robot import ModelOptions, RobotDescription, build_spec, physics_fingerprint
from ffgym.robot.model.friction import bear_arm_friction


@dataclass(frozen=True, kw_only=True, eq=False)
class Machine:
    """Machine that a plant simulates. Without effects it is its robot.

    Raises:
        FFGymError: if the robot cannot have an effect.
    """

    robot: RobotDescription
    """Robot with the numbers of this machine; the controller was made for a robot of the same joints, gears, servo and
    sample times."""
    effects: tuple[Effect, ...] = ()
    climate: Climate | None = None
    """Climate, None if unknown; effects then see a constant 20 degC."""

    def __post_init__(self) -> None:
        if not isinstance(self.robot, RobotDescription):
            raise FFGymError(f"The robot of a machine must be a description, see ffgym.robot, got {self.robot!r}.")
        if not isinstance(self.climate, Climate | None):
            raise FFGymError(f"The climate of a machine must be a Climate, or None, got {self.climate!r}.")
        if not isinstance(self.effects, Sequence):
            raise FFGymError(f"effects must be a sequence of effects, see ffgym.effects, got {self.effects!r}.")
        object.__setattr__(self, "effects", tuple(self.effects))
        for effect in self.effects:
            if not isinstance(effect, Effect):
                raise FFGymError(f"effects must be effects, see ffgym.effects, got {effect!r}.")
            effect.check_fits(self.robot)
        if self.climate is not None and self.climate.rise.size not in (1, self.robot.n_joints):
            raise FFGymError(
                f"climate.rise has {self.climate.rise.size} joints, {self.robot.name!r} has {self.robot.n_joints}."
            )

    @classmethod
    def of(cls, robot: "RobotDescription | Machine") -> "Machine":
        """A description as a machine; a machine as it is."""
        return robot if isinstance(robot, Machine) else cls(robot=robot)

    @cached_property
    def physical(self) -> RobotDescription:
        """The robot with all effects that other numbers of the description bring about."""
        robot = self.robot
        for effect in self.effects:
            if isinstance(effect, NativeEffect):
                robot = effect.in_description(robot)
        return robot

    @property
    def truth(self) -> RobotDescription | None:
        """Physical robot, which the oracle may use; None if it is hidden."""
        return self.physical

    def spec(self, options: ModelOptions) -> mujoco.MjSpec:
        """MuJoCo model of all that the engine itself simulates.

        Raises:
            FFGymError: if options leave out what an effect acts on.
        """
        self._check_whole(options)
        spec = build_spec(self.physical, options)
        added = [effect for effect in self.effects if isinstance(effect, ModelEffect)]
        for effect in added:
            effect.in_model(spec, self.physical)
        if added:  # which may have made links lighter
            bear_arm_friction(spec, self.physical)
        return spec

    def _check_whole(self, options: ModelOptions) -> None:
        for effect in self.effects:
            for needed, there, part in (
                (effect.needs_elasticity, options.flexible, "elasticity of joints"),
                (effect.needs_friction, options.friction, "friction of motors"),
            ):
                if needed and not there and not effect.is_null:
                    raise FFGymError(
                        f"Effect {effect.name} acts in the {part}, which is left out here; leave out neither, or both."
                    )

    @property
    def added_torques(self) -> tuple[TorqueEffect, ...]:
        """Effects that add torques to those of its robot."""
        return tuple(effect for effect in self.effects if isinstance(effect, TorqueEffect))

    @cached_property
    def torque_effects(self) -> tuple[TorqueEffect, ...]:
        """Effects that add torques at every physics step, with the delay of the drives."""
        return with_delay_of_drives(self.added_torques, self.physical)

    @cached_property
    def torque_effects_without_engine(self) -> tuple[TorqueEffect, ...]:
        """The same with the lag of torque loops, for torques along a motion that MuJoCo does not simulate."""
        return with_delay_of_drives(self.added_torques, self.physical, with_lag=True)

    @property
    def resolver_effects(self) -> tuple[ResolverEffect, ...]:
        """Errors of the motors' position sensors."""
        return tuple(effect for effect in self.effects if isinstance(effect, ResolverEffect))

    def seen(self, recording: Recording) -> Recording:
        """An exact recording as perfect sensors in their places, and on their clocks, would see it."""
        for effect in self.effects:
            if isinstance(effect, TrackerEffect | ClockEffect):
                recording = effect.measure(recording, self.physical)
        return recording

    def at(self, running_since: float) -> Self:
        """The machine when it has run for so long [s]; one without climate is always the same."""
        return self if self.climate is None else replace(self, climate=self.climate.at(running_since))

    def later(self, seconds: float) -> Self:
        """The machine when it has run for so much longer [s]."""
        return self if self.climate is None else self.at(self.climate.running_since + seconds)

    def read_by_resolver(self, motor_angle: Array, motor_speed: Array) -> tuple[Array, Array]:
        """Angle [rad] and speed [rad/s] as the resolver reads the true ones, motor side, (..., N) each."""
        for effect in self.resolver_effects:
            error = effect.error(motor_angle, motor_speed)
            motor_angle, motor_speed = motor_angle + error.angle, motor_speed + error.speed
        return motor_angle, motor_speed

    @property
    def _climate_key(self) -> tuple[float, ...]:
        return () if self.climate is None else self.climate.key

    def is_as(self, other: "Machine") -> bool:
        """Tell if both have the same parts, so that the model needs no compilation."""
        return self.robot is other.robot and self.effects == other.effects and self._climate_key == other._climate_key

    def with_robot(self, robot: RobotDescription) -> Self:
        """The machine with other numbers."""
        return replace(self, robot=robot)

    def physics(self, options: ModelOptions) -> str:
        """Fingerprint of the physics that a plant with these options has."""
        return self.fingerprint(physics_fingerprint(self.spec(options).compile()))

    def fingerprint(self, model: str) -> str:
        """Fingerprint of the physics: `model`, that of the engine's model, if there is nothing beside it."""
        engine = NativeEffect | ModelEffect | TorqueEffect
        beside = [*(effect for effect in self.effects if not isinstance(effect, engine)), *self.torque_effects]
        period = self.physical.drive.resolver_period
        if not beside and period == 0:
            return model
        digest = hashlib.sha256(model.encode())
        if period > 0:
            digest.update(f"resolver {period!r} {self.physical.sensors.encoder_bits}".encode())
        for effect in sorted(beside, key=lambda effect: effect.name):
            digest.update(type(effect).__qualname__.encode())
            for name, value in effect.values().items():
                digest.update(name.encode() + value.tobytes())
        digest.update(repr(self._climate_key).encode())
        return digest.hexdigest()[: len(model)]


def check_same_controller(own: RobotDescription, other: RobotDescription) -> None:
    """Check that a plant fits the controller of a robot."""
    pairs: dict[str, tuple[Any, Any]] = {
        "joints": (own.joints, other.joints),
        "drive.gear_ratio": (own.drive.gear_ratio, other.drive.gear_ratio),
        "drive.coupling": (own.drive.matrix, other.drive.matrix),
        "kinematics.types": (own.kinematics.types, other.kinematics.types),
        "bodies of springs": ([spring.bodies for spring in own.springs], [spring.bodies for spring in other.springs]),
        "having a tool": (own.tool is not None, other.tool is not None),
        "simulation.physics_dt": (own.physics_dt, other.physics_dt),
    }
    pairs |= {f"servo.{f.name}": (getattr(own.servo, f.name), getattr(other.servo, f.name)) for f in fields(own.servo)}
    for name, (mine, theirs) in pairs.items():
        if not np.array_equal(mine, theirs):
            raise FFGymError(
                f"Robots {own.name!r} and {other.name!r} differ in {name}, {mine} and {theirs}; a plant must have what "
                f"its controller was made for. Give the controller the robot that the plant was made from."
            )
