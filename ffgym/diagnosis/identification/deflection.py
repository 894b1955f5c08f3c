"""Deflection of a joint's elasticity at constant speeds, as a tracker or an encoder behind the gearbox measures it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.diagnosis.identification.friction_data import FrictionTorque
from ffgym.diagnosis.identification.stribeck_fit import average_windows, find_steady_windows
from ffgym.diagnosis.settings import settings

_TOOL_NOISE = 2e-5
"""Position of the tool that deflections are weighed against [m]: noise of a laser tracker (thesis 2.2.4)."""

_SHORTEST_LEVER = 0.05
"""Way of the tool with a joint that others do not make [m/rad] below which its deflection is not seen: 20 um are then
400 microrad, several times the deflection."""


_SHORTEST_RUN = 3
"""Windows of a run at least; of fewer, each has a ramp beside it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SteadyDeflection:
    """One joint in windows of constant speed, R windows of records in which it runs both ways; link side."""

    deflection: Array
    """Link minus motor angle over the gear ratio [rad], shape (R,); a constant of each record is not known."""
    torque: Array
    """Torque of the motor behind the gearbox [N m], friction and load, shape (R,)."""
    friction: Array
    """Friction torque behind the gearbox [N m], mean of each run, without what both directions share, shape (R,)."""
    speed: Array
    """[rad/s], shape (R,)."""
    position: Array
    """From the middle of each record [rad], shape (R,)."""
    run: IntArray
    """Run at one speed, shape (R,)."""
    record: IntArray
    """Record, shape (R,)."""
    by_tool: BoolArray
    """True for records in which a tracker sees the deflection, not an encoder, shape (n_records,)."""

    @property
    def n_records(self) -> int:
        """Number of records."""
        return len(self.by_tool)

    @property
    def sensor(self) -> str:
        """Sensors that saw the deflection."""
        seen = (("encoder", ~self.by_tool), ("tracker", self.by_tool))
        return " and ".join(name for name, records in seen if records.any())

    @property
    def n_runs(self) -> int:
        """Number of runs."""
        return int(self.run.max()) + 1 if len(self.run) else 0


def sees_deflection(torque: FrictionTorque, joint: int) -> str:
    """Name the sensor that sees one joint's deflection in a record: 'encoder', 'tracker', or '' if there is none."""
    if torque.links is not None and np.isfinite(torque.links[:, joint]).any():
        return "encoder"
    if torque.tool is None or torque.arm.robot.tool is None:
        return ""
    return "tracker" if np.isfinite(torque.tool).any() else ""


def measure_deflection(torques: Sequence[FrictionTorque], joint: int, presliding: float) -> SteadyDeflection:
    """Measure the deflection of one joint wherever it runs at constant speed, once bristles and spring have settled.

    Bristles bend by `presliding`, f_s / sigma_0 [rad], motor side. An encoder behind the gearbox is preferred; by the
    tool a joint is measured where all others rest.
    """
    robot = torques[0].signals.robot
    drive, friction = robot.drive, robot.friction
    # way of the motor after a reversal: bristles settle, and the spring takes the arm's friction the other way
    winding = 2 * friction.static[joint] * drive.gear_ratio[joint] ** 2 / drive.joint_stiffness[joint]
    settling = settings().friction.settling_travel * presliding + winding
    tables: list[Array] = []
    by_tool: list[bool] = []
    n_runs = 0
    for torque in torques:
        sensor = sees_deflection(torque, joint)
        runs = find_steady_windows(torque, joint, settling) if sensor else []
        runs = [rows for rows in runs if len(rows) >= _SHORTEST_RUN]
        table = _measure_record(torque, joint, sensor, runs) if runs else np.zeros((0, 6))
        if len(table):
            table[:, 5] += n_runs
            n_runs = int(table[-1, 5]) + 1
            tables.append(np.column_stack([table, np.full(len(table), len(by_tool))]))
            by_tool.append(sensor == "tracker")
    stacked = np.concatenate(tables) if tables else np.zeros((0, 7))
    deflection, driving, sliding, speed, position, run, record = stacked.T
    return SteadyDeflection(
        deflection=deflection,
        torque=driving,
        friction=sliding,
        speed=speed,
        position=position,
        run=run.astype(np.intp),
        record=record.astype(np.intp),
        by_tool=np.array(by_tool, dtype=np.bool_),
    )


def _measure_record(torque: FrictionTorque, joint: int, sensor: str, runs: Sequence[IntArray]) -> Array:
    """Measure one record; columns as SteadyDeflection up to the run, shape (R, 6), none if it does not go back."""
    signals, drive = torque.signals, torque.signals.robot.drive
    rows = np.concatenate(runs)
    measured = _links(torque, joint, rows) if sensor == "encoder" else _tool(torque, joint, rows)
    driven = drive.joint_torque(signals.torque - drive.rotor_inertia * signals.motor_ddq)
    columns = (driven, drive.gear_ratio * torque.friction, signals.dq, signals.q)
    means = average_windows(torque, joint, np.stack([column[:, joint] for column in columns], axis=1))[rows]
    table = np.column_stack([measured, means, np.repeat(np.arange(len(runs)), [len(own) for own in runs])])
    table = table[np.isfinite(table).all(axis=1)]
    if not _goes_back(table[:, 3], table[:, 4]):
        return table[:0]
    table[:, 4] -= table[:, 4].mean()
    table[:, 2] -= _common_part(table[:, 2], table[:, 3], table[:, 4])
    # runs from 0 on; friction of each is its mean: noise of single windows would make it a worse regressor than speed
    number = np.unique(table[:, 5], return_inverse=True)[1]
    table[:, 5] = number
    table[:, 2] = (np.bincount(number, table[:, 2]) / np.bincount(number))[number]
    return table


def _goes_back(speed: Array, position: Array) -> bool:
    """Tell if a joint goes both ways over about the same positions, so that direction and position are told apart."""
    forth, back = position[speed > 0], position[speed < 0]
    if not len(forth) or not len(back):
        return False
    return bool(abs(forth.mean() - back.mean()) < 0.25 * np.ptp(position))


def _common_part(friction: Array, speed: Array, position: Array) -> Array:
    """Part of the friction torque [N m] that both directions share in a record: errors of gravity, offsets."""
    both = np.stack([np.ones_like(position), position], axis=1)
    solution = np.linalg.lstsq(np.column_stack([both, np.sign(speed), speed]), friction, rcond=None)[0]
    shared: Array = both @ solution[:2]
    return shared


def _links(torque: FrictionTorque, joint: int, rows: IntArray) -> Array:
    """Deflection by an encoder behind the gearbox [rad], mean of each window."""
    assert torque.links is not None
    deflection = torque.links[:, [joint]] - torque.signals.q[:, [joint]]
    return average_windows(torque, joint, deflection)[rows, 0]


def _tool(torque: FrictionTorque, joint: int, rows: IntArray) -> Array:
    r"""Deflection by the tool [rad], mean of each window; NaN where other joints move or the tool does not show it.

    The position p beside that of the rigid arm at the motor angles is :math:`p - p(q) = \sum_k J_k \delta_k` and noise.
    Of all joints k that are not asked for, whose friction holds them in some part of a loop, a deflection of n f_c / K
    is expected, and the unbiased estimate of least variance is

    .. math:: \delta_j = \frac{J_j^T C^{-1} (p - p(q))}{J_j^T C^{-1} J_j}, \quad
        C = \sigma^2 I + \sum_{k \ne j} (n f_c / K)_k^2 J_k J_k^T
    """
    assert torque.tool is not None
    signals, robot = torque.signals, torque.signals.robot
    # means of the samples that the tracker has, at the mean of the motor angles of the same rows
    seen: BoolArray = np.all(np.isfinite(torque.tool), axis=1)
    columns = np.where(seen[:, None], np.column_stack([torque.tool, signals.q, seen]), 0.0)
    means = average_windows(torque, joint, columns)[rows]
    others = np.delete(np.arange(robot.n_joints), joint)
    moving = average_windows(torque, joint, np.abs(signals.motor_dq[:, others]))[rows]
    rests: BoolArray = np.all(moving < settings().patterns.rest, axis=1) & (means[:, -1] > 0)
    deflection = np.full(len(rows), np.nan)
    if not rests.any():
        return deflection
    position, q = np.split(means[rests, :-1] / means[rests, -1:], [3], axis=1)
    nominal, _, jacobian = torque.arm.pose_and_jacobian(q)
    # the joint's own direction, less what other joints do along it
    expected = np.abs(robot.drive.gear_ratio) * robot.friction.coulomb / robot.drive.joint_stiffness
    beside = jacobian[:, :3, others] * expected[others]
    noise = _TOOL_NOISE**2 * np.eye(3) + beside @ beside.swapaxes(1, 2)
    own = jacobian[:, :3, joint]
    weighed = np.linalg.solve(noise, own[..., None])[..., 0]
    information = np.sum(own * weighed, axis=1)
    information[information * _TOOL_NOISE**2 < _SHORTEST_LEVER**2] = np.nan
    deflection[rests] = np.sum(weighed * (position - nominal), axis=1) / information
    return deflection
