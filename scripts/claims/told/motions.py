"""What pages of motions, of reading and of the robot tell of constants of the code."""

import re
from collections.abc import Iterator

import numpy as np

from ffgym.control import DynamicLuGreEuler
from ffgym.paths import RADII, SPEEDS
from ffgym.paths.limits import CURVE_SHARE, MARGIN, MotionLimits
from ffgym.paths.motions.table_part import AT_REST
from ffgym.paths.motions.tool_run import RESOLVED
from ffgym.paths.rapid import predefined
from ffgym.paths.rapid.controller import MAX_STATEMENTS
from ffgym.paths.rapid.targets import LARGEST_NORM_ERROR
from ffgym.paths.route import GRID, SHARPEST
from ffgym.recordings.metrics.contour import WINDOW
from ffgym.robot import load_robot
from ffgym.robot.inverse_kinematics import newton
from ffgym.simulation import RECORD_DT
from ffgym.simulation.export.play import TOLERANCE
from ffgym.simulation.protocols.sessions import BATCH
from ffgym.simulation.protocols.stage import NEARBY, TOOL_DROP, TOOL_NEARBY
from ffgym.studies.torque_prediction import CUTOFF, MOVING
from scripts.claims.claim import claim

CODE = "the code itself"


@claim(CODE)
def limits_of_rapid() -> Iterator[str]:
    """Bounds of the reader of programs."""
    yield f"After {MAX_STATEMENTS} repeated statements there is an error"
    yield f"the norm of a unit quaternion within {LARGEST_NORM_ERROR:g}."
    yield f"`vmax` is {1e-3 * predefined._LARGEST_SPEED:g} m/s."


@claim(CODE)
def circles_of_thesis_program() -> Iterator[str]:
    """Radii of the test motion."""
    small, middle, large = (f"{1e3 * radius:g}" for radius in RADII)
    yield f"circles of {small}, {middle} and {large} mm, each led in"


@claim(CODE)
def window_of_path_error() -> Iterator[str]:
    """Time in which the nearest point of a path is looked for."""
    yield f"within {WINDOW:g} s,"


@claim(CODE)
def grid_of_time_laws() -> Iterator[str]:
    """Grid on which joint positions along a path are known."""
    yield f"of {GRID} intervals on each line"
    yield f"change by less than {100 * RESOLVED:g} % of their largest"


@claim(CODE)
def shares_of_time_laws() -> Iterator[str]:
    """Shares of the limits of joints."""
    yield f"may use {100 * CURVE_SHARE:g} % of a joint's acceleration and jerk"
    yield f"{100 * (1 - MARGIN):.0f} % stays unused"


@claim(CODE)
def limits_of_motions() -> Iterator[str]:
    """Angle of a stop, and default limits along and across the path."""
    limits = MotionLimits()
    yield (
        f"{limits.acceleration:g} m/s^2 and {limits.jerk:g} m/s^3 along the path, {limits.normal_acceleration:g} m/s^2 "
        "across it"
    )
    radius, speed = min(RADII), max(SPEEDS)
    assert speed**2 / radius < limits.normal_acceleration
    yield f"circle of {1e3 * radius:g} mm runs at its {1e3 * speed:g} mm/s"


@claim(CODE)
def turns_that_stop() -> Iterator[str]:
    """Angle by which a path turns back where the robot stops."""
    yield f"turns back by more than {np.rad2deg(SHARPEST):.0f} degrees"


@claim(CODE)
def slow_ends_of_tables() -> Iterator[str]:
    """Share of the speed below which a table begins or ends at rest."""
    yield f"is slower than {100 * AT_REST:g} %"


@claim(CODE)
def poses_of_kinematics() -> Iterator[str]:
    """Poses from which an arm's freedoms follow, and what counts as rounding."""
    yield f"Jacobian at {newton._SAMPLES} poses"
    yield f"up to {re.sub('e-0', 'e-', f'{newton.ROUNDING:.0e}')} m or rad count as rounding"


@claim(CODE)
def tolerances_of_kinematics() -> Iterator[str]:
    """Tolerance of Newton steps, and the largest condition number."""
    yield f"by Newton steps to {newton.TOLERANCE:.0e} m and rad"
    yield f"exceeds {newton.MAX_CONDITION:g}:"


@claim(CODE)
def tolerance_of_the_player() -> Iterator[str]:
    """Difference at which the player of an exported motion fails."""
    yield f"is above {re.sub('e-0', 'e-', f'{TOLERANCE:.0e}')}."


@claim(CODE)
def reach_of_protocols() -> Iterator[str]:
    """How far large motions go."""
    yield f"Large motions stay within {100 * NEARBY:g} % of each joint's range"
    yield f"no farther than {100 * TOOL_NEARBY:g} % of its distance from the base, downwards {100 * TOOL_DROP:g} %:"


@claim(CODE)
def batch_of_protocols() -> Iterator[str]:
    """Motions that are simulated together."""
    yield f"up to {BATCH:g} s"


@claim(CODE)
def rows_of_recordings() -> Iterator[str]:
    """Time between rows, as docs/simulate.md and docs/recorder.md have it."""
    yield f"time between rows of a recording; {1e3 * RECORD_DT:g} if left out"
    yield f"sample time [s], default {RECORD_DT:g}"


@claim(CODE)
def sub_steps_of_lugre() -> Iterator[str]:
    """Sub-steps of forward Euler."""
    yield f"forward Euler with {DynamicLuGreEuler(load_robot('one_axis').friction).n_substeps} sub-steps"


@claim("ffgym/robot/parameters/irb4600_60_205_servo_drives.toml")
def drives_that_are_not_ideal() -> Iterator[str]:
    """Numbers of the drives that a robot may be given."""
    robot = load_robot("irb4600_60_205_servo_drives")
    drive = robot.drive
    assert drive.torque_lag is not None
    assert drive.torque_delay is not None
    assert drive.torque_rate is not None
    bandwidth = 1 / (2 * np.pi * float(drive.torque_lag.max()))
    rise = float((drive.peak_torque / drive.torque_rate).max())
    yield f"a torque loop of {round(bandwidth, -1):.0f} Hz, a delay of {1e3 * float(drive.torque_delay.max()):g} ms"
    yield f"peak torque in {1e3 * rise:g} ms at the earliest"
    yield f"a resolver of {robot.sensors.encoder_bits} bits read every {1e3 * drive.resolver_period:g} ms"


@claim("ffgym.studies.torque_prediction")
def scoring_of_predicted_torque() -> Iterator[str]:
    """Filter, and speed below which a joint is not scored."""
    yield f"forward and backward at {CUTOFF:g} Hz"
    yield f"A joint slower than {MOVING:g} rad/s is not scored"
