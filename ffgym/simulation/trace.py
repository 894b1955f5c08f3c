"""Raw states of one simulation, and the recording made of them."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import mujoco
import numpy as np

from ffgym.control import Setpoints, rigid_feedforward, servo_torque
from ffgym.control.corrections import difference_speeds
from ffgym.control.setpoints import torque_at_rows
from ffgym.core.types import Array
from ffgym.core.version import __version__
from ffgym.paths import Reference
from ffgym.recordings import Header, Recording, clip_phases
from ffgym.robot import RigidArm
from ffgym.simulation.plant import Plant, PlantState


@dataclass(frozen=True, kw_only=True, eq=False)
class Trace:
    """MuJoCo's states at the recorded instants, T rows, filled in from the front."""

    dt: float
    """Time between rows [s]."""
    qpos: Array
    qvel: Array
    act: Array
    reading: Array | None = None
    """Motor angles [rad], then speeds [rad/s], as servos read them from resolvers, motor side, (T, 2 N); None if no
    servo of the batch does."""

    @classmethod
    def empty(cls, plant: Plant, length: int, dt: float) -> "Trace":
        """Allocate `length` rows."""
        model = plant.model
        return cls(
            dt=dt,
            qpos=np.empty((length, model.nq)),
            qvel=np.empty((length, model.nv)),
            act=np.empty((length, model.na)),
            reading=None if plant.reading() is None else np.empty((length, 2 * plant.robot.n_joints)),
        )

    def write(self, row: int, states: Iterable[Array | None]) -> None:
        """Store qpos, qvel, act and reading, None if there is none, from `row` on."""
        for kept, values in zip((self.qpos, self.qvel, self.act, self.reading), states, strict=True):
            if kept is not None and values is not None:
                kept[row : row + len(values)] = values


@dataclass(frozen=True, kw_only=True, eq=False)
class Added:
    """Torque and correction that a law adds at the S samples of a reference, motor side."""

    torque: Array
    """Torque [N m], shape (S, N)."""
    correction: Array | None = None
    """Correction of set-points [rad], shape (S, N); None for a law that acts through torques."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ReferenceRows:
    """Signals that all runs of one reference share, at the recorded instants."""

    reference: Reference
    u_ff: Array
    """Rigid feed-forward torque at the samples of the reference, motor side [N m], shape (S, N)."""
    position: Array
    """Set-point, motor side [rad], shape (T, N)."""
    velocity: Array
    """Set-point, motor side [rad/s], shape (T, N)."""
    feedforward: Array
    """Rigid feed-forward torque, motor side [N m], shape (T, N)."""
    tcp: Array | None
    """TCP of a rigid arm at the set-point [m], shape (T, 3); None for a robot without tool."""
    rows_per_step: int
    """Recorded rows in a control step."""
    cut_short: bool = False
    """True if the run ended before its reference."""

    @classmethod
    def of(cls, arm: RigidArm, reference: Reference, rows_per_step: int) -> "ReferenceRows":
        """Evaluate the reference once."""
        u_ff = rigid_feedforward(arm, reference)
        setpoints = Setpoints(
            position=reference.motor_q[None],
            velocity=reference.motor_dq[None],
            torque=u_ff[None],
            dt=reference.robot.servo.control_dt,
        )
        position, velocity, feedforward = (part[0] for part in setpoints.at_rows(rows_per_step))
        tcp = None if reference.robot.tool is None else arm.tcp_position(reference.robot.drive.joint_angle(position))
        return cls(
            reference=reference,
            u_ff=u_ff,
            position=position,
            velocity=velocity,
            feedforward=feedforward,
            tcp=tcp,
            rows_per_step=rows_per_step,
        )

    def first(self, count: int) -> "ReferenceRows":
        """Return the first `count` rows, for a run that ended early."""
        if count == len(self.position):
            return self
        tcp = None if self.tcp is None else self.tcp[:count]
        position, velocity, feedforward = self.position[:count], self.velocity[:count], self.feedforward[:count]
        return replace(self, position=position, velocity=velocity, feedforward=feedforward, tcp=tcp, cut_short=True)


def to_recording(
    trace: Trace,
    rows: ReferenceRows,
    *,
    law: str,
    added: Added,
    arm: RigidArm,
    plant: Plant,
    index: int = 0,
    seed: int | None = None,
    meta: Mapping[str, Any] = MappingProxyType({}),
) -> Recording:
    """Make the recording of one run: all signals of the drive, and the true link, friction and TCP states.

    Args:
        trace: states of the run, as far as it came.
        rows: its reference, as many rows.
        law: what added the torque.
        added: torque, or correction of set-points, that it added.
        arm: rigid dynamics that the controller knows.
        plant: the batch it ran in.
        index: which simulation of the batch.
        seed: of the sensor noise, for the header.
        meta: more for the header.
    """
    state = plant.unpack(trace.qpos, trace.qvel, trace.act)
    columns: dict[str, Array] = {"timestamp": np.arange(len(trace.qpos), dtype=np.float64) * trace.dt}
    for family, values in _signals(state, trace.reading, rows, added, plant, index).items():
        columns |= {f"{family}.{joint}": values[:, j] for j, joint in enumerate(plant.robot.joints)}
    if (climate := plant.machines[index].climate) is not None:
        warm = climate.temperature(columns["timestamp"], plant.robot.n_joints)
        columns |= {f"temperature.{joint}": warm[:, j] for j, joint in enumerate(plant.robot.joints)}
    if rows.tcp is not None:
        moved = plant.tcp_position(index, trace.qpos)
        position = arm.tcp_position(state.link_position) if moved is None else moved
        tcp = {"tcp.position": position, "tcp_reference.position": rows.tcp}
        columns |= {f"{family}.{axis}": xyz[:, k] for family, xyz in tcp.items() for k, axis in enumerate("xyz")}
    header = _header(rows.reference, {"feedforward_law": law, **meta}, plant, index, seed)
    if rows.cut_short:
        header = replace(header, phases=clip_phases(header.phases, 0.0, len(trace.qpos) * trace.dt))
    return Recording(columns=columns, header=header)


def _signals(
    state: PlantState, reading: Array | None, rows: ReferenceRows, added: Added, plant: Plant, index: int
) -> dict[str, Array]:
    """Compute per-joint signals, motor side, (T, N) each; parts of the servo as MuJoCo's `pid` adds them up."""
    machine = plant.machines[index]
    robot = machine.physical
    # servo torque from the motor angle as the resolver reads it
    position, velocity = machine.read_by_resolver(state.motor_position, state.motor_velocity)
    if reading is not None and robot.drive.resolver_period > 0:
        position, velocity = np.split(reading, 2, axis=1)
    compensation = torque_at_rows(added.torque, rows.rows_per_step)
    # set-points that the servo followed
    followed, speed, correction = rows.position, rows.velocity, {}
    if added.correction is not None:
        moved, change = _correction_at_rows(added.correction, robot.servo.control_dt, rows.rows_per_step)
        followed, speed = followed + moved[: len(followed)], speed + change[: len(speed)]
        correction["correction.position"] = moved[: len(followed)]
    feedback = servo_torque(robot.servo, followed - position, speed - velocity, state.integral)
    command = feedback.u_fb + rows.feedforward + compensation
    # friction of the bristles, where it is all friction there is
    peak, friction = robot.drive.peak_torque, {}
    if not machine.added_torques:  # with effects that add to it, a part would be taken for all of it
        at, lugre = plant.addresses, robot.friction
        bristles = (1 - robot.arm_share) * lugre.torque(state.bristle, state.motor_velocity)
        friction["friction.effort"] = np.where(at.has_bristle, bristles, 0.0)
        if at.has_arm_bristle.any():
            turning = robot.drive.gear_ratio * state.link_velocity
            behind = robot.drive.gear_ratio * robot.arm_share * lugre.torque(state.arm_bristle, turning)
            friction["arm_friction.effort"] = np.where(at.has_arm_bristle, behind, 0.0)
    return {
        "motor.position": position,
        "motor.velocity": velocity,
        "motor.effort": np.clip(command, -peak, peak),
        "reference.position": followed,
        "reference.velocity": speed,
        **correction,
        "feedforward.effort": rows.feedforward,
        "feedback.effort": feedback.u_fb,
        "feedback.integral": feedback.u_i,
        "compensation.effort": compensation,
        "command.effort": command,
        **friction,
        "link.position": state.link_position,
        "link.velocity": state.link_velocity,
    }


def _correction_at_rows(correction: Array, dt: float, rows_per_step: int) -> tuple[Array, Array]:
    """Interpolate a correction (S, N) and its speed as the drive does, at the recorded rows."""
    speed = difference_speeds(correction, dt)
    samples = Setpoints(position=correction[None], velocity=speed[None], torque=np.zeros_like(speed)[None], dt=dt)
    position, velocity, _ = samples.at_rows(rows_per_step)
    return position[0], velocity[0]


def _header(reference: Reference, meta: dict[str, Any], plant: Plant, index: int, seed: int | None) -> Header:
    robot = reference.robot
    return Header(
        robot=robot.name,
        joints=robot.joints,
        gear_ratio=tuple(robot.drive.gear_ratio.tolist()),
        coupling=None if robot.drive.coupling is None else robot.drive.coupling.tolist(),
        joint_types=robot.kinematics.types,
        position_side="motor",
        torque_semantics="motor_side",
        hold="linear",
        segment=reference.name,
        phases=reference.phases,
        provenance={
            "simulated": True,
            "seed": seed,
            "ffgym": __version__,
            "mujoco": mujoco.__version__,
            "physics_fingerprint": plant.fingerprint(index),
            "physics_dt": plant.physics_dt,
        },
        meta=meta,
    )
