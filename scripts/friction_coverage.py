"""How well friction is found again where it is known, and how often its intervals are right.

python -m scripts.friction_coverage --robot one_axis --write docs/identification.md

runs the speed ladder and the records of table 6.1 that the thesis estimates from, once and exactly; then it measures
them again and again with other noise, identifies every joint each time, and counts.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import tyro

from ffgym.core.files import check_writable, write_json, write_text
from ffgym.core.provenance import versions
from ffgym.core.types import Array
from ffgym.diagnosis.identification import friction_torques, identify_friction
from ffgym.diagnosis.identification.bristle_fit import NAMES
from ffgym.published import ESTIMATION_RECORDS
from ffgym.recordings import Recording
from ffgym.robot import ModelOptions, RigidArm, load_robot
from ffgym.robot.friction import LuGreParameters
from ffgym.simulation import Resolver, SimulatedRig, TorqueSensor
from ffgym.simulation.protocols import Protocol, plan_session, record
from ffgym.simulation.protocols.speed_ladder import SpeedLadder
from ffgym.simulation.protocols.table_6_1 import Table61
from ffgym.simulation.sensors import measure
from scripts.convergence_table import renewed

BEFORE: dict[str, float] = {
    "coulomb": 0.8,
    "static": 0.9,
    "viscous": 1.3,
    "stribeck_velocity": 1.4,
    "bristle_stiffness": 1.6,
    "bristle_damping": 0.6,
}
"""Factors on the true parameters in the model that is known before."""

LETTERS = ("f_c", "f_s", "f_v", "v_s", "sigma_0", "sigma_1")


@dataclass(frozen=True)
class Config:
    """Repetitions of an identification with known truth."""

    robot: str = "one_axis"
    """Built-in robot, or a path to a description."""
    repetitions: int = 50
    """Times that noise is drawn anew."""
    noise_percent: float = 0.5
    """White noise of the torque at each sample, in percent of the peak torque."""
    angle_noise_steps: float = 0.3
    """White noise of the angle at each sample before it is rounded, in steps of the encoder; as much as rounding adds,
    so that rounding errors do not repeat from period to period."""
    inertia_error: float = 0.05
    """Share of the inertia that the model lacks; the thesis estimates up to 5 %."""
    physics_dt: float = 6.25e-5
    """Physics step of the records with reversals [s]; see docs/identification.md."""
    record_dt: float = 5e-4
    """Sample time of the records [s], that of the thesis."""
    resamples: int = 200
    """Resamples behind each interval."""
    seed: int = 0
    """Of the noise and the resamples."""
    joints: tuple[str, ...] = ()
    """Joints; none given is all."""
    json: Path | None = None
    """Numbers as JSON."""
    write: Path | None = None
    """Markdown file whose table of this robot is renewed."""


def main(config: Config) -> dict[str, Any]:
    """Run, count, print, write."""
    if config.json is not None:
        check_writable(config.json)
    arm = RigidArm(load_robot(config.robot))
    joints = config.joints or arm.robot.joints
    exact = exact_recordings(arm, joints, config)
    model = known_model(arm, config)
    found, ends = zip(*(repetition(model, exact, joints, config, i) for i in range(config.repetitions)), strict=True)
    places = [arm.robot.joints.index(joint) for joint in joints]
    numbers = counted(arm.robot.friction, np.stack(found), np.stack(ends), places)
    text = table(numbers, joints)
    print(text)
    if config.json is not None:
        write_json(config.json, {"robot": config.robot, "versions": versions(), "joints": list(joints)} | numbers)
    if config.write is not None:
        page = config.write.read_text(encoding="utf-8")
        write_text(config.write, renewed(page, {f"friction of {arm.robot.name}": text}))
    return numbers


def exact_recordings(arm: RigidArm, joints: Sequence[str], config: Config) -> list[Recording]:
    """Ladder and sines without noise."""

    def run(protocol: Protocol, physics_dt: float | None) -> list[Recording]:
        options = ModelOptions(physics_dt=physics_dt, looks=False)
        rig = SimulatedRig(arm=arm, sensors=(), options=options)
        return list(record(plan_session(arm, [protocol]), rig, record_dt=config.record_dt))

    return run(SpeedLadder(joints=joints), None) + run(
        Table61(joints=joints, records=ESTIMATION_RECORDS), config.physics_dt
    )


def known_model(arm: RigidArm, config: Config) -> RigidArm:
    """What is known before: less inertia and other friction."""
    robot, share = arm.robot, 1 - config.inertia_error
    bodies = replace(robot.bodies, inertia=share * robot.bodies.inertia)
    drive = replace(robot.drive, rotor_inertia=share * robot.drive.rotor_inertia)
    return RigidArm(replace(robot, bodies=bodies, drive=drive, friction=robot.friction.scaled(**BEFORE)))


def repetition(
    model: RigidArm, exact: Sequence[Recording], joints: Sequence[str], config: Config, number: int
) -> tuple[Array, Array]:
    """Parameters found with other noise, (N, 6), and their intervals, (N, 6, 2)."""
    robot = model.robot
    bits = robot.sensors.encoder_bits
    sensors = (
        Resolver(bits=bits, noise=config.angle_noise_steps * 2 * np.pi / 2**bits),
        TorqueSensor(noise=config.noise_percent / 100 * robot.drive.peak_torque),
    )
    generators = np.random.default_rng([config.seed, number]).spawn(len(exact))
    recordings = [measure(recording, sensors, rng) for recording, rng in zip(exact, generators, strict=True)]
    torques = friction_torques(model, recordings)
    found = identify_friction(torques, joints=joints, seed=number, n_resamples=config.resamples)
    chosen = [joint for joint in found.joints if joint.joint in joints]
    values = [[estimate.value for estimate in joint.estimates] for joint in chosen]
    ends = [[(estimate.low, estimate.high) for estimate in joint.estimates] for joint in chosen]
    return np.array(values), np.array(ends)


def counted(friction: LuGreParameters, found: Array, ends: Array, joints: Sequence[int]) -> dict[str, Any]:
    """Errors and shares of intervals that hold the truth, for parameters (B, N, 6) and intervals (B, N, 6, 2)."""
    truth = np.stack([getattr(friction, name)[list(joints)] for name in NAMES], axis=1)
    error = found / truth - 1
    inside = (ends[..., 0] <= truth) & (truth <= ends[..., 1])
    return {
        "mean_error": error.mean(axis=0).tolist(),
        "largest_error": np.abs(error).max(axis=0).tolist(),
        "half_width": (np.ptp(ends, axis=-1).mean(axis=0) / 2 / truth).tolist(),
        "coverage": inside.mean(axis=0).tolist(),
        "repetitions": len(found),
    }


def table(numbers: dict[str, Any], joints: Sequence[str]) -> str:
    """Markdown table: mean error, largest error, and how often the interval holds the truth."""
    rows = [f"| joint | {' | '.join(LETTERS)} |", "|---" * (len(LETTERS) + 1) + "|"]
    for j, joint in enumerate(joints):
        cells = [
            f"{numbers['mean_error'][j][i]:+.1%}, {numbers['largest_error'][j][i]:.1%}, {numbers['coverage'][j][i]:.0%}"
            for i in range(len(LETTERS))
        ]
        rows.append(f"| {joint} | {' | '.join(cells)} |")
    return "\n".join(rows)


if __name__ == "__main__":
    main(tyro.cli(Config))
