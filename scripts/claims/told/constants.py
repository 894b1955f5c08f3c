"""What pages tell of constants of the code, as the defaults of options and the settings of methods."""

import inspect
from collections.abc import Callable, Iterator
from typing import Any

from ffgym.agents.residual.hyperparameters import hyperparameters
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.tuning import CUTOFFS
from ffgym.envs import EnvSettings
from ffgym.envs.rewards import STOP_STEPS
from ffgym.envs.settings import ACTION_SCALE, ERROR_LIMIT
from ffgym.leaderboard.comparison.statistics import CONFIDENCE, RESAMPLES
from ffgym.leaderboard.evaluation.margins import CIRCLES, DELAYS, FACTORS, FINE, PULSE, WINDOW
from ffgym.robot import load_robot
from scripts.claims.claim import claim

CODE = "the code itself"


def default(function: Callable[..., Any], name: str) -> Any:
    """Default of an argument of a function."""
    return inspect.signature(function).parameters[name].default


@claim(CODE)
def how_margins_are_measured() -> Iterator[str]:
    """Settings of the measurement of margins, and the machine that it is made on."""
    robot = load_robot("irb4600_60_205_arm_drives")
    lag, delay = robot.drive.torque_lag, robot.drive.torque_delay
    assert lag is not None
    assert delay is not None
    bandwidth = 1 / (2 * 3.141592653589793 * float(lag.max()))
    yield f"torque loop of {round(bandwidth, -1):.0f} Hz, {1e3 * float(delay.max()):g} ms of delay"
    yield f"speeds from {robot.sensors.encoder_bits}-bit resolvers"
    yield f"a pulse of {PULSE:g} f_s at one sample"
    yield f"in each window of {1e3 * WINDOW:g} ms of the second half"
    least = round(1 / FACTORS[0])
    yield (
        f"factors 1/{least}, 1/{round(1 / FACTORS[1])}, ..., {FACTORS[-1]:g}, then three steps of 2^(1/4) behind the "
        f"last that is borne, and so to {100 * (FINE[0] - 1):.0f} %; delays of {', '.join(map(str, DELAYS))} samples"
    )


@claim(CODE)
def circles_of_margins() -> Iterator[str]:
    """Radii of the circles that margins are measured on."""
    slow, *others = (1e3 * radius for circle in CIRCLES for radius in circle.radii)
    (fast,) = set(others)
    yield f"of {slow:g} mm at the lowest and of {fast:g} mm at the others."


@claim(CODE)
def how_intervals_are_made() -> Iterator[str]:
    """Settings of the intervals of the leaderboard."""
    yield f"with {100 * CONFIDENCE:g} % confidence. It comes from {RESAMPLES} resamples"


@claim(CODE)
def one_step_of_an_environment() -> Iterator[str]:
    """Time of a step, and its physics."""
    robot = load_robot("irb4600_60_205")
    steps = robot.servo.control_dt / robot.physics_dt
    yield f"One step is one control step of {1e3 * robot.servo.control_dt:g} ms, {steps:.0f} physics steps."


@claim(CODE)
def actions_of_environments() -> Iterator[str]:
    """Scale of actions."""
    yield f"1 is `action_scale` ({ACTION_SCALE:g}) times the breakaway torque"


@claim(CODE)
def stops_of_environments() -> Iterator[str]:
    """Error at which a robot is stopped, and what that costs."""
    yield f"exceeds `error_limit` ({ERROR_LIMIT:g} rad, motor side)"
    dt = load_robot("irb4600_60_205").servo.control_dt
    yield f"An emergency stop costs {STOP_STEPS} steps ({STOP_STEPS * dt:g} s) at the error"


@claim(CODE)
def settings_of_environments() -> Iterator[str]:
    """Defaults of the keyword arguments."""
    yield f"| `action_scale` | {ACTION_SCALE:g} |"
    yield f"| `preview` | {EnvSettings().preview} |"
    yield f"| `error_limit` | {ERROR_LIMIT:g} |"


@claim(CODE)
def residual_training() -> Iterator[str]:
    """Hyper-parameters that the page of residual policies tells."""
    ppo = hyperparameters("ppo", [])
    yield f"γ = {ppo['gamma']:g}:"
    yield f"The exploration's standard deviation is {ppo['first_std']:g} of the bound"


@claim(CODE)
def how_numbers_are_fitted() -> Iterator[str]:
    """Band that the fit of all numbers begins with."""
    yield f"**Slow first**: below {CUTOFFS[0]:g} Hz, then to the cut-off of a diagnosis."


@claim(CODE)
def how_fitted_numbers_are_known() -> Iterator[str]:
    """How far a diagnosis takes fitted numbers to be known."""
    yield f"takes them as known to {100 * settings().prior.fitted_share:g} %."
