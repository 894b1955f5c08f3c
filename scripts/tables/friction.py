"""Identified friction: docs/identification.md (how often intervals are right) and docs/narx.md (networks; two minutes).

The first runs the speed ladder and the records of Table 6.1 that the thesis estimates from, once and exactly; then it
measures them again and again with other noise, identifies every joint each time, and counts.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import matplotlib.pyplot as plt
import numpy as np
import scipy

from ffgym.core.executors import Executor
from ffgym.core.types import Array
from ffgym.diagnosis.identification import JointFriction, friction_torques, identify_friction
from ffgym.diagnosis.identification.bristle_fit import NAMES
from ffgym.diagnosis.resampling import LEVEL
from ffgym.published import ESTIMATION_RECORDS
from ffgym.recordings import Recording
from ffgym.robot import ModelOptions, RigidArm, RobotDescription, load_robot
from ffgym.simulation import Resolver, SimulatedRig, TorqueSensor
from ffgym.simulation.protocols import plan_session, record
from ffgym.simulation.protocols.one_by_one import SpeedLadder, Table61
from ffgym.simulation.sensors import measure
from scripts.tables.page import Contents, markdown
from scripts.thesis.narx import (
    ESTIMATION,
    EXTENDED,
    LINEAR,
    N_STARTS,
    OTHERS,
    PUBLISHED,
    VALIDATION,
    fit_narx,
    narx_records,
    reach_records,
    record_name,
    static_misfit,
)
from scripts.thesis.tables import VALIDATING, columns_of, spread, write_fit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BEFORE: dict[str, float] = {
    "coulomb": 0.8,
    "static": 0.9,
    "viscous": 1.3,
    "stribeck_velocity": 1.4,
    "bristle_stiffness": 1.6,
    "bristle_damping": 0.6,
}
"""Factors on the true parameters in the model that is known before."""
REPETITIONS: Mapping[str, int] = {"one_axis": 50, "irb4600_60_205": 50}
"""Robots of the page, and the times that noise is drawn anew."""

JOINTS: Mapping[str, tuple[str, ...]] = {"irb4600_60_205": ("j1", "j2", "j5")}
"""Joints that are identified; all of a robot that is not named."""

NOISE = 0.005
"""White noise of the torque at each sample, as a share of the peak torque."""
ANGLE_NOISE = 0.3
"""White noise of the angle at each sample before it is rounded, in steps of the encoder; as much as rounding adds, so
that rounding errors do not repeat from period to period."""
INERTIA_ERROR = 0.05
"""Share of the inertia that the known model lacks; the thesis estimates up to 5 %."""
SEED = 0
"""Seed of the noise."""
FIRST = 50
"""Number of the first repetition; `friction.widened` was calibrated on those before it."""


@dataclass(frozen=True)
class Repetition:
    """One measurement of a robot with noise of its own, and what is identified from it."""

    robot: str
    """Built-in robot, or a path to a description."""
    joints: tuple[str, ...]
    """Joints that move, one after the other, and are identified."""
    number: int
    """Number of the noise."""
    resamples: int
    """Behind each interval."""
    physics_dt: float
    """Physics step of the records with reversals [s]."""
    record_dt: float
    """Sample time of the records [s]."""


def coverage(
    robots: Mapping[str, int] = REPETITIONS,
    resamples: int = 200,
    physics_dt: float = 6.25e-5,
    record_dt: float = 5e-4,
    jobs: int = 0,
    joints: Mapping[str, tuple[str, ...]] = JOINTS,
) -> Contents:
    """Identify friction where it is known, and count how often intervals hold it.

    Args:
        robots: repetitions by robot, built-in or a path to a description.
        resamples: behind each interval.
        physics_dt: physics step of the records with reversals [s]; see docs/identification.md.
        record_dt: sample time of the records [s], by default that of the thesis.
        jobs: processes; 0 is one per core.
        joints: joints that are identified, by robot; all of a robot that is not named.
    """
    parts, numbers = {}, {}
    for name, repetitions in robots.items():
        robot = load_robot(name)
        own = joints.get(name, robot.joints)
        drawn = range(FIRST, FIRST + repetitions)
        todo = [Repetition(name, own, number, resamples, physics_dt, record_dt) for number in drawn]
        repeated = dict(Executor(jobs=jobs).run(identify_again, todo))
        found, ends = (np.stack([repeated[i][which] for i in range(repetitions)]) for which in (0, 1))
        numbers[robot.name] = {"joints": list(own), **count_covered(true_friction(robot, own), found, ends)}
        # mean error, largest error, and how often the interval holds the truth
        rows = []
        for j, joint in enumerate(own):
            errors = zip(
                *(numbers[robot.name][what][j] for what in ("mean_error", "largest_error", "coverage")), strict=True
            )
            rows.append((joint, *(f"{mean:+.1%}, {largest:.1%}, {right:.0%}" for mean, largest, right in errors)))
        head = ("joint", "f_c", "f_s", "f_v", "v_s", "sigma_0", "sigma_1")
        parts[f"friction of {robot.name}"] = markdown(head, rows)
    return Contents(parts=parts, numbers=numbers, pictures={"interval_coverage": draw_coverage(numbers)})


@lru_cache(maxsize=1)
def _exact_recordings(name: str, joints: tuple[str, ...], physics_dt: float, record_dt: float) -> list[Recording]:
    """Speed ladder and sines of joints of a robot, without noise."""
    arm = RigidArm(load_robot(name))
    sines = Table61(joints=joints, records=ESTIMATION_RECORDS)
    exact: list[Recording] = []
    for protocol, dt in ((SpeedLadder(joints=joints), None), (sines, physics_dt)):
        rig = SimulatedRig(arm=arm, sensors=(), options=ModelOptions(physics_dt=dt, looks=False))
        exact += record(plan_session(arm, [protocol]), rig, record_dt=record_dt)
    return exact


def identify_again(repetition: Repetition) -> tuple[Array, Array]:
    """Return parameters found with noise drawn anew, (J, 6), and their intervals, (J, 6, 2)."""
    estimates = [joint.estimates for joint in identify_joints(repetition)]
    values = [[estimate.value for estimate in own] for own in estimates]
    ends = [[(estimate.low, estimate.high) for estimate in own] for own in estimates]
    return np.array(values), np.array(ends)


def identify_joints(repetition: Repetition) -> list[JointFriction]:
    """Measure the joints with noise drawn anew, and identify their friction."""
    robot, joints = load_robot(repetition.robot), repetition.joints
    exact = _exact_recordings(repetition.robot, joints, repetition.physics_dt, repetition.record_dt)
    # the model that is known before has less inertia and other friction
    share = 1 - INERTIA_ERROR
    bodies = replace(robot.bodies, inertia=share * robot.bodies.inertia)
    drive = replace(robot.drive, rotor_inertia=share * robot.drive.rotor_inertia)
    model = RigidArm(replace(robot, bodies=bodies, drive=drive, friction=robot.friction.scale(**BEFORE)))
    # the same motions, measured with other noise
    bits = robot.sensors.encoder_bits
    resolver = Resolver(bits=bits, noise=ANGLE_NOISE * 2 * np.pi / 2**bits)
    sensors = (resolver, TorqueSensor(noise=NOISE * robot.drive.peak_torque))
    generators = np.random.default_rng([SEED, repetition.number]).spawn(len(exact))
    recordings = [measure(recording, sensors, rng) for recording, rng in zip(exact, generators, strict=True)]
    torques = friction_torques(model, recordings)
    found = identify_friction(torques, joints=joints, seed=repetition.number, n_resamples=repetition.resamples)
    return [joint for joint in found.joints if joint.joint in joints]


def true_friction(robot: RobotDescription, joints: Sequence[str]) -> Array:
    """Return the true parameters of some joints, shape (J, 6)."""
    numbers = [robot.joints.index(joint) for joint in joints]
    return np.stack([getattr(robot.friction, name)[numbers] for name in NAMES], axis=1)


def count_covered(truth: Array, found: Array, ends: Array) -> dict[str, Any]:
    """Count intervals (B, J, 6, 2) that hold the truth (J, 6), and compute errors of parameters (B, J, 6)."""
    error = found / truth - 1
    inside = (ends[..., 0] <= truth) & (truth <= ends[..., 1])
    return {
        "mean_error": error.mean(axis=0).tolist(),
        "largest_error": np.abs(error).max(axis=0).tolist(),
        "half_width": (np.ptp(ends, axis=-1).mean(axis=0) / 2 / truth).tolist(),
        "coverage": inside.mean(axis=0).tolist(),
        "repetitions": len(found),
    }


def draw_coverage(numbers: Mapping[str, Any]) -> "Figure":
    """Draw how often intervals hold the truth, for each parameter of each joint, and what chance makes of 90 %."""
    figure, panels = plt.subplots(1, len(numbers), figsize=(9.0, 3.4), sharey=True, squeeze=False, layout="constrained")
    for axes, (robot, own) in zip(panels[0], numbers.items(), strict=True):
        n = own["repetitions"]
        low, high = scipy.stats.binom.interval(LEVEL, n, LEVEL)
        axes.axhspan(100 * low / n, 100 * high / n, color="0.9", label=f"90 % of {n} counts, if intervals are right")
        axes.axhline(100 * LEVEL, color="0.4", linewidth=1.0)
        places = np.arange(len(NAMES))
        for j, (joint, share) in enumerate(zip(own["joints"], own["coverage"], strict=True)):
            shift = 0.16 * (j - (len(own["joints"]) - 1) / 2)
            axes.plot(places + shift, 100 * np.array(share), "o", label=f"joint {joint}")
        axes.set_xticks(places, ["f_c", "f_s", "f_v", "v_s", "sigma_0", "sigma_1"])
        axes.set_ylim(60, 101)
        axes.set_title(f"{robot}, {n} repetitions", fontsize=10)
        axes.legend(fontsize=8, loc="lower left")
    panels[0, 0].set_ylabel("intervals that hold the truth [%]")
    return figure


CANDIDATES = {each.name: each for each in (*PUBLISHED, *OTHERS, *EXTENDED, *LINEAR)}


def networks(candidates: Sequence[str] = tuple(CANDIDATES), n_starts: int = N_STARTS, seed: int = 0) -> Contents:
    """NARX networks from random weights and linear models, fitted to data of the LuGre model as in thesis 6.2."""
    friction = load_robot("one_axis").friction
    records, reach = narx_records(friction), reach_records(friction)
    floors = {name: static_misfit(friction, each).fit for name, each in (records | reach).items()}
    fits = [fit_narx(CANDIDATES[name], records | reach, n_starts=n_starts, seed=seed) for name in candidates]
    on_v = np.stack([floors[record_name(n)] for n in VALIDATING])
    floor = [floors[ESTIMATION], floors[VALIDATION], None, np.median(on_v, axis=0), on_v.min(axis=0)]
    rows = [("static curve", *("" if each is None else write_fit(each[0]) for each in floor))]
    rows += [(fit.candidate.label, *map(spread, columns_of(fit))) for fit in fits]
    far = [("static curve", *(write_fit(floors[name][0]) for name in reach))]
    far += [(fit.candidate.label, *(spread(fit.errors[name].simulation.fit) for name in reach)) for fit in fits]
    head = ("", "f = 1", "f = 0.5", "f = 0.5, one step", "set V, median record", "set V, worst record")
    numbers = [
        {
            "candidate": asdict(fit.candidate),
            "errors": {
                name: {
                    "prediction_rms_nm": each.prediction.rms.tolist(),
                    "simulation_rms_nm": each.simulation.rms.tolist(),
                }
                for name, each in fit.errors.items()
            },
        }
        for fit in fits
    ]
    return Contents(
        parts={"fits": markdown(head, rows), "reach": markdown(("", *reach), far)},
        numbers={"config": {"n_starts": n_starts, "seed": seed}, "fits": numbers},
    )
