"""Logs of an exam: the machine of a question makes its motions, and sensors measure them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from ffgym.core.types import Array
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, RobotDescription
from ffgym.simulation import Resolver, Sensor, SimulatedRig, TorqueSensor
from ffgym.simulation.plant import Machine
from ffgym.simulation.protocols import Protocol, plan_session, record, usual_sensors
from scripts.exam.case import Case, protocol_of

RESOLVER_NOISE = 2e-5
"""Standard deviation of the resolver's angle, motor side [rad]; chosen: about its step of 16 bit over sqrt 12."""

TORQUE_NOISE = 0.03
"""Of measured torques, as a share of the Coulomb torque, white at every row; chosen."""

RECORD_DT = 0.002
"""Sample period of the logs [s]; chosen: what research interfaces of robots give, 1 to 4 ms."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class CurrentOffset(Sensor):
    """Torque by current sensors that show something of no current."""

    offset: Array
    """As torque, motor side [N m], shape (N,)."""

    def apply(self, recording: Recording, rng: np.random.Generator) -> Recording:
        """See base class."""
        names = [f"motor.effort.{joint}" for joint in recording.header.joints]
        return recording.with_columns(
            {name: recording[name] + more for name, more in zip(names, self.offset, strict=True)}
        )


def sensors_of_exam(robot: RobotDescription, current_offset: Array | None = None) -> tuple[Sensor, ...]:
    """Resolvers with noise, the tracker of the description, thermometers, and measured currents."""
    resolver = Resolver(bits=robot.sensors.encoder_bits, noise=RESOLVER_NOISE)
    others = [sensor for sensor in usual_sensors(robot) if not isinstance(sensor, Resolver)]
    offset = () if current_offset is None else (CurrentOffset(offset=current_offset),)
    return (resolver, *others, *offset, TorqueSensor(noise=TORQUE_NOISE * robot.friction.coulomb))


def recorded(
    arm: RigidArm,
    machine: Machine,
    protocols: Sequence[Protocol],
    *,
    seed: int,
    current_offset: Array | None = None,
    start: float = 0.0,
    lacks: Sequence[str] = (),
    n_threads: int = 1,
) -> list[Recording]:
    """Recordings of protocols on a machine.

    Args:
        arm: what the controller knows of it.
        machine: what it is.
        protocols: what it does.
        seed: of the sensors' noise.
        current_offset: of its current sensors, as torque, motor side [N m], shape (N,); None is none.
        start: when the first motion begins, since the machine was switched on [s].
        lacks: families of columns that are left out.
        n_threads: of the simulation.
    """
    rig = SimulatedRig(arm=arm, machine=machine, sensors=sensors_of_exam(arm.robot, current_offset), name="exam")
    motions = plan_session(arm, protocols, start=start)
    recordings = record(motions, rig, seed=seed, record_dt=RECORD_DT, n_threads=n_threads)
    return [_without(recording, lacks) for recording in recordings]


def log_of_case(case: Case, machine: Machine | None = None, *, n_threads: int = 1) -> list[Recording]:
    """The log of a question, or of another machine in its place with the same noise."""
    protocol = protocol_of(case.arm.robot, poor=case.is_poor)
    seed = int(case.generator().integers(2**32))
    return recorded(
        case.arm,
        machine or case.complete,
        [protocol],
        seed=seed,
        current_offset=case.current_offset,
        lacks=case.lacks,
        n_threads=n_threads,
    )


def _without(recording: Recording, families: Sequence[str]) -> Recording:
    left_out = tuple(f"{family}." for family in families)
    if not left_out:
        return recording
    columns = {name: values for name, values in recording.columns.items() if not name.startswith(left_out)}
    return Recording(columns=columns, header=recording.header)
