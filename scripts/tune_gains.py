r"""Servo gains of the leaderboard, tuned on drawn robots or machines, in minutes on one core.

    python -m scripts.tune_gains
    python -m scripts.tune_gains --name servo_gains_drives --robot irb4600_60_205_arm_drives --effects
    python -m scripts.tune_gains --name servo_gains_stable --robot irb4600_60_205_arm_drives --effects \
        --gain-margin 2 --delay-margin 1 --start 0 0.1 0.5 --step 0.3 --evaluations 12

Nelder and Mead's simplex minimises the mean of ln(RMS path error / that of the base) of
`ffgym.agents.residual.validation`, on circles and robots that nobody is scored on. With required margins, gains count
only if their loop has them on the nominal robot and, with effects, on drawn machines
(`ffgym.agents.residual.required_margins`); the best are verified on the nominal one, on all circles of
`ffgym.leaderboard.evaluation.margins`. The policy keeps all that was tried; the value of what was refused is 1.

The search must begin at gains with these margins. Their border is rough, and the simplex shrinks where it meets it.
"""

import shlex
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import tyro
from scipy.optimize import minimize

from ffgym.agents.artefacts import ANYWHERE, TRAINED, add_artefacts, describe_artefact
from ffgym.agents.residual.gains import GAINS, SERVO_GAINS, make_gains
from ffgym.agents.residual.plan import Training
from ffgym.agents.residual.policy import save_policy
from ffgym.agents.residual.required_margins import has_margins, plants_around
from ffgym.agents.residual.validation import SEED, SPEEDS, validate
from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.files import filled_folder
from ffgym.core.types import Array
from ffgym.leaderboard.evaluation.margins import CIRCLES, LoopMargins
from ffgym.leaderboard.plants import TestPlant
from ffgym.robot import load_robot

START = (0.3, 0.1, 0.5)
"""Gains at which the search begins; chosen: small ones, behind a filter of two samples."""
STEPS = (0.2, 0.1, 0.2)
"""Steps of the gains to the corners of the first simplex; chosen."""
REFUSED = 1.0
"""Value of gains with which a robot stops, the filter grows, or the loop lacks the required margins."""


@dataclass(frozen=True)
class Config:
    """Search for gains."""

    name: str = SERVO_GAINS
    """Name of the row."""
    robot: str = "irb4600_60_205"
    """Nominal robot, around which robots are drawn."""
    effects: bool = False
    """Draw machines with physical effects, for robots with drives and losses as irb4600_60_205_arm_drives."""
    plants: int = 2
    """Robots drawn for each circle of the validation."""
    evaluations: int = 60
    """Evaluations of the search."""
    gain_margin: float | None = None
    """Factor on the gains that their loop must bear, e.g. 2; None asks for none but 1 beside a delay."""
    delay_margin: int = 0
    """Delay that it must bear, too [samples of the controller]."""
    start: tuple[float, float, float] = START
    """Gains at which the search begins."""
    step: float = 1.0
    """Size of the first simplex, in STEPS."""
    out: Path = TRAINED
    """Folder of the artefacts."""

    @property
    def command(self) -> str:
        """Command that makes the artefact again."""
        usual = Config()
        words = ["python", "-m", "scripts.tune_gains"]
        for name in ("name", "robot", "plants", "evaluations", "gain_margin", "delay_margin", "start", "step"):
            value = getattr(self, name)
            parts = value if isinstance(value, tuple) else (value,)
            words += [f"--{name.replace('_', '-')}", *map(str, parts)] if value != getattr(usual, name) else []
        return shlex.join([*words, *(["--effects"] if self.effects else [])])


def main(config: Config) -> Array:
    """Search, write the policy and its manifest, and return the gains.

    Raises:
        FFGymError: if the row is unknown, or no gains that were tried have the required margins.
    """
    check_choice("row of servo gains", config.name, GAINS)
    n_motors = load_robot(config.robot).n_joints
    run = partial(validate, robot=config.robot, plants=config.plants, effects=config.effects)
    required = None
    if config.gain_margin is not None or config.delay_margin:
        required = LoopMargins(gain=config.gain_margin or 1.0, delay=config.delay_margin)
    plants = plants_around(config.robot, config.plants if config.effects else 0)
    tried: list[tuple[list[float], float]] = []

    def objective(gains: Array) -> float:
        try:
            policy = make_gains(gains, n_motors=n_motors)
            stable = required is None or has_margins(policy, required, plants)
            value = run(policy).log_ratio if stable else REFUSED
        except FFGymError:  # a robot stopped, or the filter grows
            value = REFUSED
        tried.append(([float(f"{gain:.4g}") for gain in gains], float(f"{value:.5g}")))
        print(f"{len(tried):3d}  gains {tried[-1][0]}  ln(error / base) {value:+.4f}", flush=True)
        return value

    minimize(
        objective,
        np.array(config.start),
        method="Nelder-Mead",
        options={"maxfev": config.evaluations, "xatol": 0.01, "fatol": 1e-4, "initial_simplex": _simplex(config)},
    )
    gains, value = _take_best(tried, required, plants[0], n_motors)
    training = Training(base="elastic", robot=config.robot)  # for the fingerprint of the nominal plant
    meta = {
        "search": tried,
        "log_ratio": value,
        **({} if required is None else {"margins": {"gain": required.gain, "delay": required.delay}}),
        "validation": {"seed": SEED, "speeds": SPEEDS, "plants": config.plants, "effects": config.effects},
    }
    with filled_folder(config.out / config.name / ANYWHERE) as folder:
        save_policy(folder / "seed_0.npz", make_gains(gains, n_motors=n_motors, meta=meta))
    entry = describe_artefact(
        config.name,
        f"{ANYWHERE}/seed_0.npz",
        config.out,
        seed=0,
        plant=ANYWHERE,
        fingerprint=str(training.origin()["physics_fingerprint"]),
        robot_seconds=0.0,
        env_steps=0,
    )
    add_artefacts(config.name, config.command, [entry], config.out)
    return np.array(gains)


def _simplex(config: Config) -> Array:
    """Corners of the first simplex (4, 3): the start, and a step in each gain."""
    return np.array(config.start) + config.step * np.vstack([np.zeros(3), np.diag(STEPS)])


def _take_best(
    tried: list[tuple[list[float], float]], required: LoopMargins | None, nominal: TestPlant, n_motors: int
) -> tuple[list[float], float]:
    """Return the best gains and their value; those before them that lack margins on some circle are refused."""
    for i in sorted(range(len(tried)), key=lambda i: tried[i][1]):
        gains, value = tried[i]
        if value >= REFUSED:
            break
        if required is None or has_margins(make_gains(gains, n_motors=n_motors), required, [nominal], circles=CIRCLES):
            return gains, value
        tried[i] = (gains, REFUSED)
    raise FFGymError("None of the gains that were tried has the required margins: start the search at smaller ones.")


if __name__ == "__main__":
    print(main(tyro.cli(Config)))
