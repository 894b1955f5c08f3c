"""Servo gains of the leaderboard, tuned on drawn robots or machines, in minutes on one core.

    python -m scripts.tune_gains
    python -m scripts.tune_gains --name servo_gains_drives --robot irb4600_60_205_arm_drives --effects

Nelder and Mead's simplex minimises the mean of ln(RMS path error / that of the base) of
`ffgym.agents.residual.validation`, on circles and robots that nobody is scored on. The policy keeps all that was tried.
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
from ffgym.agents.residual.validation import SEED, SPEEDS, validate
from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.files import made_folder
from ffgym.core.types import Array
from ffgym.robot import load_robot

START = (0.3, 0.1, 0.5)
"""Gains at which the search begins; chosen: small ones, behind a filter of two samples."""


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
    out: Path = TRAINED
    """Folder of the artefacts."""

    @property
    def command(self) -> str:
        """Command that makes the artefact again."""
        usual = Config()
        words = ["python", "-m", "scripts.tune_gains"]
        for name in ("name", "robot", "plants", "evaluations"):
            value = getattr(self, name)
            words += [f"--{name}", str(value)] if value != getattr(usual, name) else []
        return shlex.join([*words, *(["--effects"] if self.effects else [])])


def main(config: Config) -> Array:
    """Search, write the policy and its manifest, and return the gains."""
    check_choice("row of servo gains", config.name, GAINS)
    robot = load_robot(config.robot)
    run = partial(validate, robot=config.robot, plants=config.plants, effects=config.effects)
    tried: list[tuple[list[float], float]] = []

    def objective(gains: Array) -> float:
        try:
            value = run(make_gains(gains, n_motors=robot.n_joints)).log_ratio
        except FFGymError:  # a robot stopped, or the filter grows
            value = 1.0
        tried.append(([float(f"{gain:.4g}") for gain in gains], float(f"{value:.5g}")))
        print(f"{len(tried):3d}  gains {tried[-1][0]}  ln(error / base) {value:+.4f}", flush=True)
        return value

    minimize(
        objective,
        np.array(START),
        method="Nelder-Mead",
        options={"maxfev": config.evaluations, "xatol": 0.01, "fatol": 1e-4, "initial_simplex": _simplex()},
    )
    gains, value = min(tried, key=lambda each: each[1])
    training = Training(base="elastic", robot=config.robot)  # for the fingerprint of the nominal plant
    meta = {
        "search": tried,
        "log_ratio": value,
        "validation": {"seed": SEED, "speeds": SPEEDS, "plants": config.plants, "effects": config.effects},
    }
    with made_folder(config.out / config.name / ANYWHERE) as folder:
        save_policy(folder / "seed_0.npz", make_gains(gains, n_motors=robot.n_joints, meta=meta))
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


def _simplex() -> Array:
    """Corners of the first simplex (4, 3): the start, and a step in each gain."""
    return np.array(START) + np.vstack([np.zeros(3), np.diag([0.2, 0.1, 0.2])])


if __name__ == "__main__":
    print(main(tyro.cli(Config)))
