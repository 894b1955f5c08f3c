r"""Separating motion of two fitted structures: the session in which their machines differ most, over the noise.

Compared is the tool as a tracker sees it beside the tool where the motors' angles put it: what happens behind the
motors, whatever the servos do. A difference counts as far as the numbers of the rival, within their priors, cannot make
up for it:

.. math:: \min_x |d - A x|^2 + |x|^2

with d in units of the tracker's noise, and the changes A that a standard deviation of each number makes.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.measures import rms
from ffgym.core.types import Array
from ffgym.diagnosis.sessions import SessionProposal, propose_sessions
from ffgym.diagnosis.tables.parts import find_structure
from ffgym.diagnosis.tables.problem import SEARCH_DT
from ffgym.diagnosis.tables.structure_fit import StructureFit
from ffgym.diagnosis.tables.structures import main_motors
from ffgym.logs.preparation import read_joint_side
from ffgym.robot import ModelOptions, RigidArm, RobotDescription
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Machine
from ffgym.simulation.protocols import plan_session

SESSIONS = ("loops", "circles")
"""Proposed sessions that are simulated: slow ones, in which losses show more than servos; chosen."""

_STEP = 0.2
"""Step of finite differences, in standard deviations."""


@dataclass(frozen=True, kw_only=True)
class SeparatingSession:
    """Session of motions, and how far apart two structures are in it."""

    protocol: str
    why: str
    """Purpose, in one phrase."""
    between: tuple[str, str]
    """Names of the structures."""
    seconds: float
    rms_mm: float
    """RMS difference of the tool beside the motors' tool, over the session [mm]."""
    max_mm: float
    """Largest difference [mm]."""
    unexplained_rms_mm: float
    """RMS of what numbers of the rival cannot make up for [mm]."""
    unexplained_max_mm: float
    """Largest value of it [mm]."""
    noise_mm: float
    """Standard deviation of the tracker's noise, each coordinate [mm]."""
    over_noise: float
    """`unexplained_max_mm` over the noise of a distance in space."""
    toml: str
    """Text of the protocol file that `ffgym record` runs."""


def find_separating_sessions(
    robot: RobotDescription, one: StructureFit, other: StructureFit, names: Sequence[str] = SESSIONS
) -> list[SeparatingSession]:
    """Simulate short sessions in the machines of two structures; return them, the one that separates most first."""
    arm = RigidArm(robot)
    joints = [name for name, main in zip(robot.joints, main_motors(robot), strict=True) if main]
    found = []
    for proposal in propose_sessions(robot, joints):
        if proposal.name in names:
            with suppress(FFGymError):  # the robot cannot make this one, or a machine becomes unstable in it
                found.append(_compare(arm, one, other, proposal))
    return sorted(found, key=lambda each: -each.over_noise)


def _compare(arm: RigidArm, one: StructureFit, other: StructureFit, proposal: SessionProposal) -> SeparatingSession:
    motions = plan_session(arm, proposal.protocols())
    seconds = float(motions[-1].end - motions[0].start)
    runs = [Run(reference=motion.reference) for motion in motions]
    # both machines, and the rival with each of its numbers moved
    rival, x = find_structure(other.name), np.array(other.x)
    steps = _STEP * rival.spread
    moved = [rival.candidate(arm.robot, x + step).machine for step in np.diag(steps)]
    first = find_structure(one.name).candidate(arm.robot, np.array(one.x)).machine
    (own,) = _behind_motors(arm, runs, [first])
    base, *shifted = _behind_motors(arm, runs, [rival.candidate(arm.robot, x).machine, *moved])
    apart = own - base
    noise = 2e-5 if arm.robot.sensors is None else float(arm.robot.sensors.tracker_noise)
    tangents = np.stack([(each - base).ravel() / _STEP for each in shifted], axis=1) / noise
    explained = np.linalg.solve(tangents.T @ tangents + np.eye(tangents.shape[1]), tangents.T @ (apart.ravel() / noise))
    left = apart - noise * (tangents @ explained).reshape(apart.shape)
    size, rest = np.linalg.norm(apart, axis=1), np.linalg.norm(left, axis=1)
    return SeparatingSession(
        protocol=proposal.name,
        why=proposal.why,
        between=(one.name, other.name),
        seconds=seconds,
        rms_mm=1e3 * rms(size),
        max_mm=1e3 * float(size.max()),
        unexplained_rms_mm=1e3 * rms(rest),
        unexplained_max_mm=1e3 * float(rest.max()),
        noise_mm=1e3 * noise,
        over_noise=float(rest.max() / (np.sqrt(3.0) * noise)),
        toml=proposal.toml(),
    )


def _behind_motors(arm: RigidArm, runs: Sequence[Run], machines: Sequence[Machine]) -> list[Array]:
    """Simulate the tool as seen minus the tool where the motors put it [m], from its start in each motion, (T, 3)."""
    recordings = simulate(
        [run for _ in machines for run in runs],
        arm=arm,
        machine=[machine for machine in machines for _ in runs],
        options=ModelOptions(looks=False, physics_dt=SEARCH_DT),
        record_dt=arm.robot.servo.control_dt,
        n_threads=1,
    )
    found = []
    for recording in recordings:
        away = recording.vector("tcp.position") - arm.tcp_position(read_joint_side(arm.robot, recording))
        found.append(away - away[0])
    n = len(runs)
    return [np.concatenate(found[i * n : (i + 1) * n]) for i in range(len(machines))]
