"""What docs/agents/learning_stability.md tells of predictions, which take seconds on one axis, and of its tables."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ffgym.agents import ExtendedBSN, LearningStability, StaticBSN
from ffgym.agents.bspline import BSplineNetwork
from ffgym.agents.lffc import thesis_training
from ffgym.agents.stability import STABLE_GROWTH
from ffgym.agents.trials import Signal
from ffgym.robot import RigidArm, RobotDescription, load_robot
from ffgym.simulation import RECORD_DT
from ffgym.studies import sine_references
from scripts.claims.claim import claim
from scripts.claims.page import ROOT
from scripts.tables.learning import AXIS, FREQUENCIES, ROBOT
from scripts.tables.page import rows_of

AGAIN = "python -m scripts.tables --page agents/learning_stability.md"
PAGE = ROOT / "docs" / "agents" / "learning_stability.md"


@claim("ffgym.agents.stability")
def what_counts_as_stable() -> Iterator[str]:
    """Growth of a pattern that still counts as stable."""
    yield f"growth below {100 * (STABLE_GROWTH - 1):.1f} % per iteration counts as stable"
    yield f"no pattern grows by more than the factor {STABLE_GROWTH:g}, per joint"
    yield f"largest gamma whose bound is {STABLE_GROWTH:g}: stable in any order"


@claim(AGAIN)
def distance_to_the_limit() -> Iterator[str]:
    """Limits over the rates of the thesis, and times of rows and samples."""
    robot, axis = (thesis_training(n_joints).rate for n_joints in (6, 1))
    (slow,) = (row[2:] for row in rows_of(PAGE, "largest rates") if row[0] == "10 mm/s")
    alone = [float(row[1]) for row in rows_of(PAGE, "one axis")]
    yield (
        f"the limit is {min(map(float, slow)) / robot:.1f} times its {robot:g} at 10 mm/s, and "
        f"{min(alone) / axis:.1f} times its {axis:g} on one axis."
    )
    control_dt = load_robot(ROBOT).servo.control_dt
    yield f"rows every {1e3 * RECORD_DT:g} ms, the law acts every {1e3 * control_dt:g} ms"


@claim("ffgym train stability --robot one_axis --frequencies-hz 1 --signal e_p")
def learning_from_e_p() -> Iterator[str]:
    """Growth of patterns that are learned from the error of the angle, and what comes of the signal."""
    robot = load_robot(AXIS)
    rate = thesis_training(1).rate
    slow, _ = sine_references(robot)
    static, extended = (study(kind, robot, slow, RECORD_DT, "e_p") for kind in (StaticBSN, ExtendedBSN))
    times = [1e3 * dt for dt in (RECORD_DT, robot.servo.control_dt)]
    late = study(ExtendedBSN, robot, slow, robot.servo.control_dt, "e_p")
    grown = {f"{100 * (each.growth(rate)[0] - 1):.0f} %" for each in (extended, late)}
    assert len(grown) == 1
    yield (
        f"with the extended network one pattern grows by {grown.pop()} per iteration at {rate:g}, from rows every "
        f"{times[0]:g} ms and every {times[1]:g} ms alike."
    )
    assert max(each.largest_rate[0] for each in (static, extended, late)) < 0.05
    yield f"on one axis at {slow:g} Hz no rate is stable"
    course = extended.mean_squares(rate, 40)[:, 0]
    first, second, last = ((k, np.sqrt(course[k] / course[0])) for k in (10, 20, 40))
    yield (
        f"is predicted to be {first[1]:.2f}, {second[1]:.2f} and {last[1]:.2f} after {first[0]}, {second[0]} and "
        f"{last[0]} iterations"
    )
    yield f"With the static network a pattern grows by {100 * (static.growth(rate)[0] - 1):.0f} %."


def study(
    kind: type[BSplineNetwork], robot: RobotDescription, frequency: float, record_dt: float, signal: Signal
) -> LearningStability:
    """Predict the learning of a network on a sine of one axis."""
    sine = sine_references(robot)[frequency]
    return LearningStability.of(kind.zero(1), RigidArm(robot), [sine], signal=signal, record_dt=record_dt)


@claim("ffgym train stability --robot one_axis --record-dt-ms 4, which takes other gains from a robot file")
def servo_damping() -> Iterator[str]:
    """Rates that a damped servo guarantees on one axis, and limits with other gains and without friction."""
    robot = load_robot(AXIS)
    servo = robot.servo
    inertia = robot.drive.rotor_inertia + robot.bodies.inertia[:, 2]
    lag = float((inertia * servo.position_gain / servo.velocity_gain**2)[0])
    slow = float((servo.integral_gain * servo.velocity_gain / servo.position_gain**2)[0])
    yield f"One axis has J K_p / K_v² = {lag:.2f}, so that {2 * (1 - max(lag, slow)):.2f} is safe on any motion."
    less = 0.3
    own, raised, lowered = (
        limit(replace(robot, servo=replace(servo, velocity_gain=factor * servo.velocity_gain)))
        for factor in (1.0, 1.5, 1.0 - less)
    )
    _, fast = sine_references(robot)
    yield (
        f"at {fast:g} Hz, rows every {1e3 * servo.control_dt:g} ms, the limit is {own:.2f}; with K_v raised by half it "
        f"is {raised:.2f}, and with K_v lowered by {100 * less:.0f} % (J K_p > K_v²) {lowered:.2f}."
    )
    smooth = robot.friction.scale(bristle_stiffness=1e-9, bristle_damping=0, viscous=0)
    yield f"without it the same limit is {limit(replace(robot, friction=smooth)):.2f}."


def limit(robot: RobotDescription) -> float:
    """Largest stable rate of the extended network on the fast sine of one axis, from the samples."""
    _, fast = sine_references(robot)
    return float(study(ExtendedBSN, robot, fast, robot.servo.control_dt, "u_p").largest_rate[0])


@claim(AGAIN)
def changing_motions() -> Iterator[str]:
    """Where motions in turn grow that are stable alone."""
    robot = load_robot(AXIS)
    *first, last = (f"{each:g}" for each in FREQUENCIES)
    yield f"sines of {', '.join(first)} and {last} Hz, rows every {1e3 * robot.servo.control_dt:g} ms"
    yield f"largest rate whose bound is {STABLE_GROWTH:g}"
    rows = {row[0]: row[1:] for row in rows_of(PAGE, "changing motions")}
    rate, alone, _, worst, *_ = rows["extended"]
    factor, _, order = worst.partition(": ")
    in_turn = order.removesuffix(" Hz").split(", ")
    limits = dict(zip((f"{each:g}" for each in FREQUENCIES), alone.split(", "), strict=True))
    yield (
        f"at the thesis' {rate}, the extended network grows by {100 * (float(factor) - 1):.1f} % a trial when "
        f"{' and '.join(in_turn)} Hz alternate, though alone they are stable up to "
        f"{' and '.join(limits[each] for each in in_turn)}."
    )
    safe = min(float(rows[name][-1]) for name in rows if "plain" in name)
    yield f"on one axis up to {np.floor(1e3 * safe) / 1e3:g}, which is proved by the bound"
