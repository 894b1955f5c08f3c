"""Sensors of the machine and the laser tracker: from the true state to measured columns."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, final

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_shape, check_whole
from ffgym.core.types import Array
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription
from ffgym.robot.parts import resolver_step

TRUTH = ("friction.effort", "link.position", "link.velocity", "tcp.position", "temperature")
"""Families of the hidden truth: a measured recording has one only if a sensor measures it."""


class Sensor(ABC):
    """Sensor, which turns exact columns of a recording into measured ones."""

    measures: ClassVar[tuple[str, ...]] = ()
    """Families of TRUTH that this sensor makes visible."""

    @abstractmethod
    def apply(self, recording: Recording, rng: np.random.Generator) -> Recording:
        """Return the recording with this sensor's columns measured; noise comes from `rng`."""


@final
@dataclass(frozen=True, kw_only=True)
class Resolver(Sensor):
    """Motor angle in steps of a turn / 2^bits; speed is its backward difference, as on the thesis' platform."""

    bits: int
    """Resolution [bit/turn]."""
    noise: float = 0.0
    """Standard deviation of the angle before it is rounded [rad], motor side."""

    def __post_init__(self) -> None:
        check_whole("resolver bits", self.bits, unit="bit/turn", low=1, high=32)
        check_number("resolver noise", self.noise, unit="rad", low=0.0)

    def apply(self, recording: Recording, rng: np.random.Generator) -> Recording:
        """Round angles and difference them; without noise it draws no numbers from `rng`."""
        step = resolver_step(self.bits)
        columns = {}
        for joint in recording.header.joints:
            seen = _add_noise(recording[f"motor.position.{joint}"], self.noise, rng)
            angle = np.round(seen / step) * step
            columns[f"motor.position.{joint}"] = angle
            columns[f"motor.velocity.{joint}"] = np.diff(angle, prepend=angle[0]) / recording.dt
        header = replace(
            recording.header,
            encoder_bits=self.bits,
            filters=(*recording.header.filters, "motor.velocity is the backward difference of motor.position"),
        )
        return recording.derive({**recording.columns, **columns}, header)


@final
@dataclass(frozen=True, kw_only=True)
class LaserTracker(Sensor):
    """TCP position with white noise, at its own sample time; rows in between are NaN."""

    measures: ClassVar[tuple[str, ...]] = ("tcp.position",)
    noise: float
    """Standard deviation of each coordinate [m]."""
    period: float
    """Sample time [s]; a recording that is sampled more slowly keeps its own."""

    def __post_init__(self) -> None:
        check_number("tracker noise", self.noise, unit="m", low=0.0)
        check_number("tracker period", self.period, unit="s", low=0.0, open_low=True)

    def apply(self, recording: Recording, rng: np.random.Generator) -> Recording:
        """Add noise to positions at the tracker's samples; other rows become NaN."""
        every = max(1, round(self.period / recording.dt))
        if self.period > recording.dt and abs(every * recording.dt - self.period) > 1e-9:
            raise FFGymError(
                f"The tracker period of {self.period} s must be a multiple of the recording's sample time of "
                f"{recording.dt:g} s; choose another record_dt."
            )
        seen = np.arange(len(recording.t)) % every == 0
        columns = {}
        for axis in "xyz":
            noisy = recording[f"tcp.position.{axis}"] + rng.normal(scale=self.noise, size=len(seen))
            columns[f"tcp.position.{axis}"] = np.where(seen, noisy, np.nan)
        columns["tcp.timestamp"] = np.where(seen, recording.t, np.nan)
        return recording.derive({**recording.columns, **columns})


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueSensor(Sensor):
    """Motor torque with white noise, as from measured currents; commanded torque stays exact."""

    noise: Array
    """Standard deviation of each joint, motor side [N m], shape (N,)."""

    def __post_init__(self) -> None:
        noise = check_shape("torque noise", self.noise, (None,))
        if np.any(noise < 0):
            raise FFGymError(f"torque noise = {noise.tolist()} N m must be >= 0 on every joint.")
        object.__setattr__(self, "noise", noise)

    def apply(self, recording: Recording, rng: np.random.Generator) -> Recording:
        """Add noise to the motor torques."""
        noise = check_shape("torque noise", self.noise, (len(recording.header.joints),))
        names = [f"motor.effort.{joint}" for joint in recording.header.joints]
        return recording.with_columns(
            {name: _add_noise(recording[name], float(size), rng) for name, size in zip(names, noise, strict=True)}
        )


@final
@dataclass(frozen=True, kw_only=True)
class Thermometer(Sensor):
    """Temperatures of the joints with white noise, in steps; a machine without a temperature has none to measure."""

    measures: ClassVar[tuple[str, ...]] = ("temperature",)
    noise: float
    """Standard deviation [K]."""
    resolution: float
    """Step [K]."""

    def __post_init__(self) -> None:
        check_number("thermometer noise", self.noise, unit="K", low=0.0)
        check_number("thermometer resolution", self.resolution, unit="K", low=0.0, open_low=True)

    def apply(self, recording: Recording, rng: np.random.Generator) -> Recording:
        """Add noise to the temperatures and round them."""
        if not recording.has("temperature"):
            return recording
        names = [f"temperature.{joint}" for joint in recording.header.joints]
        seen = {name: _add_noise(recording[name], self.noise, rng) for name in names}
        return recording.with_columns(
            {name: np.round(value / self.resolution) * self.resolution for name, value in seen.items()}
        )


def _add_noise(values: Array, noise: float, rng: np.random.Generator) -> Array:
    """Add white noise of standard deviation `noise`; without noise no numbers are drawn."""
    return values + rng.normal(scale=noise, size=len(values)) if noise > 0 else values


def check_sensors(sensors: Sequence[Sensor]) -> None:
    """Check that sensors are a list of sensors."""
    if not isinstance(sensors, Sequence) or not all(isinstance(sensor, Sensor) for sensor in sensors):
        raise FFGymError(f"sensors = {sensors!r} must be a list of sensors, e.g. [Resolver(bits=16)].")


def measure(recording: Recording, sensors: Sequence[Sensor], rng: np.random.Generator) -> Recording:
    """Measure an exact recording: hidden truth is dropped; without sensors it stays exact."""
    for sensor in sensors:
        recording = sensor.apply(recording, rng)
    if not sensors:
        return recording
    seen = {family for sensor in sensors for family in sensor.measures}
    hidden = tuple(f"{family}." for family in TRUTH if family not in seen)
    columns = {name: values for name, values in recording.columns.items() if not name.startswith(hidden)}
    return recording.derive(columns)


def sensors_of(robot: RobotDescription) -> tuple[Sensor, ...]:
    """Return the resolvers of a robot, and the laser tracker if its description has one."""
    sensors = robot.sensors
    resolver = Resolver(bits=sensors.encoder_bits)
    if sensors.tracker_period == 0:
        return (resolver,)
    return (resolver, LaserTracker(noise=sensors.tracker_noise, period=sensors.tracker_period))
