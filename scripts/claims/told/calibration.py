"""What docs/calibration.md tells of the fit that made the nominal robot, and of a stored record."""

from collections.abc import Iterator
from inspect import signature

import numpy as np

from ffgym.diagnosis.tables.structures import main_motors
from ffgym.paths import RADII
from ffgym.published import published_mm
from ffgym.robot import load_robot
from scripts.calibrate_nominal import RESONANCE_HZ, SPEEDS, Config, Objective, prior_robot
from scripts.claims.claim import claim
from scripts.claims.records import numbers_of
from scripts.tables.networks import path_mm

CODE = "scripts/calibrate_nominal.py"
CORNERS = ("p1", "p2", "p3", "p4")


@claim(CODE)
def how_the_robot_is_calibrated() -> Iterator[str]:
    """Settings of the fit."""
    slow, fast = (1e3 * speed for speed in SPEEDS)
    cells = len(SPEEDS) * len(RADII) * len(CORNERS)
    yield f"over the {cells} cells of Tables 4.1b and 4.2b ({slow:g} and {fast:g} mm/s, three radii, four positions)"
    low, high = RESONANCE_HZ
    yield f"Leaving {low:g} to {high:g} Hz with the lowest resonance"
    settings = signature(Config).parameters
    starts, steps = (settings[name].default for name in ("starts", "iterations"))
    yield f"**Search**: {starts} random starts, then {steps} Gauss-Newton steps at most"


@claim("ffgym/robot/data/irb4600_60_205.toml")
def what_was_calibrated() -> Iterator[str]:
    """Factors between the description and its priors, and the lowest resonances."""
    robot = load_robot("irb4600_60_205")
    prior, main = prior_robot(robot), main_motors(robot)
    of, before = (
        {
            "damping": each.servo.velocity_gain / each.drive.rotor_inertia,
            "bandwidth": each.servo.position_gain / each.servo.velocity_gain,
            "integral": each.servo.integral_gain / each.servo.position_gain,
        }
        for each in (robot, prior)
    )
    for name, motors in (("main", main), ("wrist", np.logical_not(main))):
        factors = [np.exp(np.mean(np.log(of[rate][motors] / before[rate][motors]))) for rate in of]
        told = ", ".join(f"{factor:.2f}" for factor in factors)
        yield f"damping rate, bandwidth, integral rate of the {name} servos | {told} |"
    viscous = robot.friction.viscous[1:] / prior.friction.viscous[1:]
    (factor,) = {f"{each:.2f}" for each in viscous}
    yield f"viscous friction of joints 2 to 6 | {factor} |"
    stiffness = robot.drive.joint_stiffness[:3] / prior.drive.joint_stiffness[:3]
    yield f"stiffness of joints 1, 2, 3 | {', '.join(f'{each:.2f}' for each in stiffness)} |"
    p1, p2, p3, p4 = (f"{each:.1f}" for each in Objective(robot).lowest_resonances(robot))
    assert (p1, p2) == (p4, p3)
    yield f"The lowest locked resonance is {p1} Hz at p1 and p4, and {p2} Hz at p2 and p3."


@claim("python -m scripts.claims --record networks")
def laws_of_the_nominal_robot() -> Iterator[str]:
    """Mean errors of ideal compensation, simulated and published."""
    published = np.mean([published_mm("lugre_dynamic", "rms", 0.01, r, place) for r in RADII for place in CORNERS])
    yield f"({path_mm('lugre_dynamic', 10.0):.3f} against {published:.3f} mm)"
    none, dynamic = (
        np.mean(
            [
                row["rms_mm"]
                for row in numbers_of("networks")["rows"]
                if (row["agent"], row["speed_mm_s"], row["radius_mm"]) == (law, 40.0, 1.0)
            ]
        )
        for law in ("none", "lugre_dynamic")
    )
    yield f"mean RMS {none:.2f} to {dynamic:.2f} mm), because"
