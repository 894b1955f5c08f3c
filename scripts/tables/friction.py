"""Identified friction: docs/identification.md (how often intervals are right) and docs/narx.md (networks; two minutes).

The first runs the speed ladder and the records of Table 6.1 that the thesis estimates from, once and exactly; then it
measures them again and again with other noise, identifies every joint each time, and counts.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ffgym.core.types import Array
from ffgym.diagnosis.identification import friction_torques, identify_friction
from ffgym.diagnosis.identification.bristle_fit import NAMES
from ffgym.published import ESTIMATION_RECORDS
from ffgym.recordings import Recording
from ffgym.robot import ModelOptions, RigidArm, load_robot
from ffgym.simulation import Resolver, SimulatedRig, TorqueSensor
from ffgym.simulation.protocols import Protocol, plan_session, record
from ffgym.simulation.protocols.one_by_one import SpeedLadder, Table61
from ffgym.simulation.sensors import measure
from scripts.tables.page import Contents, markdown
from scripts.thesis.narx import (
    ESTIMATION,
    EXTENDED,
    N_STARTS,
    OTHERS,
    PUBLISHED,
    VALIDATION,
    NarxFit,
    fit_narx,
    narx_records,
    reach_records,
    record_name,
    static_misfit,
)
from scripts.thesis.tables import VALIDATING, columns_of, spread

BEFORE: dict[str, float] = {
    "coulomb": 0.8,
    "static": 0.9,
    "viscous": 1.3,
    "stribeck_velocity": 1.4,
    "bristle_stiffness": 1.6,
    "bristle_damping": 0.6,
}
"""Factors on the true parameters in the model that is known before."""
REPETITIONS = {"one_axis": 50, "irb4600_60_205": 5}
"""Robots of the page, and the times that noise is drawn anew."""


@dataclass(frozen=True)
class Trial:
    """An identification with known truth."""

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
    """Seed of the noise and the resamples."""

    def exact_recordings(self, arm: RigidArm) -> list[Recording]:
        """Ladder and sines without noise."""

        def run(protocol: Protocol, physics_dt: float | None) -> list[Recording]:
            options = ModelOptions(physics_dt=physics_dt, looks=False)
            rig = SimulatedRig(arm=arm, sensors=(), options=options)
            return list(record(plan_session(arm, [protocol]), rig, record_dt=self.record_dt))

        sines = Table61(joints=arm.robot.joints, records=ESTIMATION_RECORDS)
        return run(SpeedLadder(joints=arm.robot.joints), None) + run(sines, self.physics_dt)

    def known_model(self, arm: RigidArm) -> RigidArm:
        """Model that is known before: less inertia and other friction."""
        robot, share = arm.robot, 1 - self.inertia_error
        bodies = replace(robot.bodies, inertia=share * robot.bodies.inertia)
        drive = replace(robot.drive, rotor_inertia=share * robot.drive.rotor_inertia)
        return RigidArm(replace(robot, bodies=bodies, drive=drive, friction=robot.friction.scaled(**BEFORE)))

    def repetition(self, model: RigidArm, exact: Sequence[Recording], number: int) -> tuple[Array, Array]:
        """Parameters found with other noise, (N, 6), and their intervals, (N, 6, 2)."""
        robot = model.robot
        bits = robot.sensors.encoder_bits
        sensors = (
            Resolver(bits=bits, noise=self.angle_noise_steps * 2 * np.pi / 2**bits),
            TorqueSensor(noise=self.noise_percent / 100 * robot.drive.peak_torque),
        )
        generators = np.random.default_rng([self.seed, number]).spawn(len(exact))
        recordings = [measure(recording, sensors, rng) for recording, rng in zip(exact, generators, strict=True)]
        torques = friction_torques(model, recordings)
        found = identify_friction(torques, joints=robot.joints, seed=number, n_resamples=self.resamples)
        values = [[estimate.value for estimate in joint.estimates] for joint in found.joints]
        ends = [[(estimate.low, estimate.high) for estimate in joint.estimates] for joint in found.joints]
        return np.array(values), np.array(ends)


def coverage(robots: dict[str, int] = REPETITIONS, trial: Trial = Trial()) -> Contents:
    """How well friction is found again where it is known, and how often its intervals are right.

    Args:
        robots: repetitions by robot, built-in or a path to a description.
        trial: how it is measured.
    """
    parts, numbers = {}, {}
    for name, repetitions in robots.items():
        arm = RigidArm(load_robot(name))
        model, exact = trial.known_model(arm), trial.exact_recordings(arm)
        found, ends = zip(*(trial.repetition(model, exact, i) for i in range(repetitions)), strict=True)
        numbers[arm.robot.name] = {"joints": list(arm.robot.joints), **counted(arm, np.stack(found), np.stack(ends))}
        parts[f"friction of {arm.robot.name}"] = _coverage_table(numbers[arm.robot.name])
    return Contents(parts=parts, numbers=numbers)


def counted(arm: RigidArm, found: Array, ends: Array) -> dict[str, Any]:
    """Errors and shares of intervals that hold the truth, for parameters (B, N, 6) and intervals (B, N, 6, 2)."""
    truth = np.stack([getattr(arm.robot.friction, name) for name in NAMES], axis=1)
    error = found / truth - 1
    inside = (ends[..., 0] <= truth) & (truth <= ends[..., 1])
    return {
        "mean_error": error.mean(axis=0).tolist(),
        "largest_error": np.abs(error).max(axis=0).tolist(),
        "half_width": (np.ptp(ends, axis=-1).mean(axis=0) / 2 / truth).tolist(),
        "coverage": inside.mean(axis=0).tolist(),
        "repetitions": len(found),
    }


def _coverage_table(numbers: dict[str, Any]) -> str:
    """Mean error, largest error, and how often the interval holds the truth."""
    rows = []
    for j, joint in enumerate(numbers["joints"]):
        errors = zip(*(numbers[what][j] for what in ("mean_error", "largest_error", "coverage")), strict=True)
        rows.append((joint, *(f"{mean:+.1%}, {largest:.1%}, {share:.0%}" for mean, largest, share in errors)))
    return markdown(("joint", "f_c", "f_s", "f_v", "v_s", "sigma_0", "sigma_1"), rows)


CANDIDATES = {each.name: each for each in (*PUBLISHED, *OTHERS, *EXTENDED)}


def networks(candidates: Sequence[str] = tuple(CANDIDATES), n_starts: int = N_STARTS, seed: int = 0) -> Contents:
    """NARX networks beside one another: fits in free run and one step ahead, over random starts.

    Args:
        candidates: names of those of `scripts.thesis.narx` to fit, to data of the LuGre model as thesis 6.2.
        n_starts: random starts of each.
        seed: of their first weights.
    """
    friction = load_robot("one_axis").friction
    records, reach = narx_records(friction), reach_records(friction)
    floors = {name: static_misfit(friction, each).fit for name, each in (records | reach).items()}
    fits = [fit_narx(CANDIDATES[name], records | reach, n_starts=n_starts, seed=seed) for name in candidates]
    on_v = np.stack([floors[record_name(n)] for n in VALIDATING])
    floor = [floors[ESTIMATION], floors[VALIDATION], None, np.median(on_v, axis=0), on_v.min(axis=0)]
    rows = [("static curve", *("" if each is None else f"{each[0]:.1f}" for each in floor))]
    rows += [(fit.candidate.label, *map(spread, columns_of(fit))) for fit in fits]
    far = [("static curve", *(f"{floors[name][0]:.1f}" for name in reach))]
    far += [(fit.candidate.label, *(spread(fit.errors[name].simulation.fit) for name in reach)) for fit in fits]
    head = ("", "f = 1", "f = 0.5", "f = 0.5, one step", "set V, median record", "set V, worst record")
    return Contents(
        parts={"fits": markdown(head, rows), "reach": markdown(("", *reach), far)},
        numbers={"config": {"n_starts": n_starts, "seed": seed}, "fits": [_numbers(fit) for fit in fits]},
    )


def _numbers(fit: NarxFit) -> dict[str, object]:
    errors = {
        name: {"prediction_rms_nm": each.prediction.rms.tolist(), "simulation_rms_nm": each.simulation.rms.tolist()}
        for name, each in fit.errors.items()
    }
    return {"candidate": asdict(fit.candidate), "errors": errors}
