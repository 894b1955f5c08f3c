"""What the machine and the laser tracker see of the true state."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from ffgym.errors import check_number
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription


class Sensor(ABC):
    """Turns exact columns of a recording into measured ones."""

    @abstractmethod
    def apply(self, recording: Recording, rng: np.random.Generator) -> Recording:
        """A recording in which this sensor's columns are measured; noise comes from `rng`."""


@final
@dataclass(frozen=True, kw_only=True)
class Resolver(Sensor):
    """Motor angle in steps of a turn / 2^bits; speed is its backward difference, as on the thesis' platform."""

    bits: int
    """Resolution [bit/turn]."""

    def __post_init__(self) -> None:
        check_number("resolver bits", self.bits, unit="bit/turn", low=1, high=32)

    def apply(self, recording: Recording, rng: np.random.Generator) -> Recording:
        """See base class; there is no random part."""
        step = 2 * np.pi / 2**self.bits
        columns = {}
        for joint in recording.header.joints:
            angle = np.round(recording[f"motor.position.{joint}"] / step) * step
            columns[f"motor.position.{joint}"] = angle
            columns[f"motor.velocity.{joint}"] = np.diff(angle, prepend=angle[0]) / recording.dt
        header = replace(
            recording.header,
            encoder_bits=self.bits,
            filters=(*recording.header.filters, "motor.velocity is the backward difference of motor.position"),
        )
        return Recording(columns=dict(recording.columns) | columns, header=header)


@final
@dataclass(frozen=True, kw_only=True)
class LaserTracker(Sensor):
    """TCP position with white noise, at its own sample time; rows in between are NaN."""

    noise: float
    """Standard deviation of each coordinate [m]."""
    period: float
    """Sample time [s]; a recording that is sampled more slowly keeps its own."""

    def __post_init__(self) -> None:
        check_number("tracker noise", self.noise, unit="m", low=0.0)
        check_number("tracker period", self.period, unit="s", low=0.0, open_low=True)

    def apply(self, recording: Recording, rng: np.random.Generator) -> Recording:
        """See base class."""
        every = max(1, round(self.period / recording.dt))
        seen = np.arange(len(recording.t)) % every == 0
        columns = {}
        for axis in "xyz":
            noisy = recording[f"tcp.position.{axis}"] + rng.normal(scale=self.noise, size=len(seen))
            columns[f"tcp.position.{axis}"] = np.where(seen, noisy, np.nan)
        columns["tcp.timestamp"] = np.where(seen, recording.t, np.nan)
        return Recording(columns=dict(recording.columns) | columns, header=recording.header)


def sensors_of(robot: RobotDescription) -> tuple[Sensor, ...]:
    """The resolvers of a robot, and the laser tracker if its description has one."""
    sensors = robot.sensors
    resolver = Resolver(bits=sensors.encoder_bits)
    if sensors.tracker_period == 0:
        return (resolver,)
    return (resolver, LaserTracker(noise=sensors.tracker_noise, period=sensors.tracker_period))
