"""Simulated test bench of an exam: a robot, its motions, and how well they are measured."""

from dataclasses import dataclass, replace

import numpy as np

from ffgym.core.types import Array
from ffgym.recordings import Recording
from ffgym.robot import RigidArm
from ffgym.simulation import LaserTracker, Resolver, Sensor, SimulatedRig, TorqueSensor
from ffgym.simulation.plant import Machine
from ffgym.simulation.protocols import Protocol, plan_session, record, usual_sensors
from ffgym.simulation.protocols.mixtures import Circles, DiagnosisMotions

RESOLVER_NOISE = 2e-5
"""Standard deviation of the resolver's angle, motor side [rad]; chosen: about its step of 16 bit over sqrt 12."""

TORQUE_NOISE = 0.03
"""Standard deviation of measured torques, as a share of the Coulomb torque, white at every row; chosen."""

RECORD_DT = 0.002
"""Sample period of the logs [s]; chosen: what research interfaces of robots give, 1 to 4 ms."""

PAUSE = 130.0
"""Time between motions of the protocol, in which the machine works and warms up [s]; chosen: 14 K in a session."""

POOR_SPEEDS = (0.010, 0.020, 0.040)
"""Speeds of the small circles that make a poor log [m/s]; those of the thesis' tables, and one between."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CurrentOffset(Sensor):
    """Torque by current sensors that show something of no current."""

    offset: Array
    """Offset as torque, motor side [N m], shape (N,)."""

    def apply(self, recording: Recording, rng: np.random.Generator) -> Recording:
        """Round the resolver's angle and add noise to it."""
        names = [f"motor.effort.{joint}" for joint in recording.header.joints]
        return recording.with_columns(
            {name: recording[name] + more for name, more in zip(names, self.offset, strict=True)}
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Bench:
    """A robot as it is described, the motions of its log, and its sensors; noise as standard deviations."""

    arm: RigidArm
    protocols: tuple[Protocol, ...]
    resolver_noise: float = RESOLVER_NOISE
    """Motor side [rad]."""
    torque_noise: Array | None = None
    """Motor side [N m], shape (N,); None is `TORQUE_NOISE` of the Coulomb torque."""
    tracker_noise: float | None = None
    """Noise of each coordinate [m]; None is that of the description."""
    record_dt: float = RECORD_DT
    """Sample period [s]."""
    lacks: tuple[str, ...] = ()
    """Families of columns that the log does not have."""

    def record(
        self, machine: Machine, *, seed: int, current_offset: Array | None = None, start: float = 0.0
    ) -> list[Recording]:
        """Record the protocols on a machine.

        Args:
            machine: in place of the described robot.
            seed: of the sensors' noise.
            current_offset: of its current sensors, as torque, motor side [N m], shape (N,); None is none.
            start: when the first motion begins, since the machine was switched on [s].
        """
        rig = SimulatedRig(arm=self.arm, machine=machine, sensors=self._sensors(current_offset), name="exam")
        motions = plan_session(self.arm, self.protocols, start=start)
        left_out, found = tuple(f"{family}." for family in self.lacks), []
        for one in record(motions, rig, seed=seed, record_dt=self.record_dt, n_threads=1):
            columns = {name: values for name, values in one.columns.items() if not name.startswith(left_out)}
            found.append(Recording(columns=columns, header=one.header))
        return found

    def _sensors(self, current_offset: Array | None) -> tuple[Sensor, ...]:
        """Resolvers with noise, the tracker of the description, thermometers, and measured currents."""
        robot = self.arm.robot
        resolver = Resolver(bits=robot.sensors.encoder_bits, noise=self.resolver_noise)
        others = [sensor for sensor in usual_sensors(robot) if not isinstance(sensor, Resolver)]
        if (noise := self.tracker_noise) is not None:
            others = [replace(one, noise=noise) if isinstance(one, LaserTracker) else one for one in others]
        offset = () if current_offset is None else (CurrentOffset(offset=current_offset),)
        torque = TORQUE_NOISE * robot.friction.coulomb if self.torque_noise is None else self.torque_noise
        return (resolver, *others, *offset, TorqueSensor(noise=torque))


def usual_protocol(arm: RigidArm, *, poor: bool = False) -> Protocol:
    """The first protocol of any diagnosis, or small circles alone, which show little."""
    area = arm.robot.work_area
    if not poor or area is None:
        return DiagnosisMotions(pause=PAUSE)
    return Circles(positions=(next(iter(area.positions)),), speeds=POOR_SPEEDS, pause=PAUSE)
