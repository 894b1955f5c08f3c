"""Servo gains of the leaderboard, tuned on drawn robots: `python -m scripts.tune_gains`, minutes on one core.

Nelder and Mead's simplex minimises the mean of ln(RMS path error / that of the base) of
`ffgym.agents.residual.validation`, on circles and robots that nobody is scored on. The policy keeps all that was tried.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tyro
from scipy.optimize import minimize

from ffgym.agents.artefacts import ANYWHERE, TRAINED, add_artefacts, describe_artefact
from ffgym.agents.residual.gains import SERVO_GAINS, make_gains
from ffgym.agents.residual.plan import Training
from ffgym.agents.residual.policy import save_policy
from ffgym.agents.residual.validation import SEED, SPEEDS, validate
from ffgym.core.errors import FFGymError
from ffgym.core.files import made_folder
from ffgym.core.types import Array
from ffgym.robot import load_robot

COMMAND = "python -m scripts.tune_gains"
START = (0.3, 0.1, 0.5)
"""Gains at which the search begins; chosen: small ones, behind a filter of two samples."""


@dataclass(frozen=True)
class Config:
    """Search for gains."""

    robot: str = "irb4600_60_205"
    plants: int = 2
    """Robots drawn for each circle of the validation."""
    evaluations: int = 60
    """Evaluations of the search."""
    out: Path = TRAINED
    """Folder of the artefacts."""


def main(config: Config) -> Array:
    """Search, write the policy and its manifest, and return the gains."""
    robot = load_robot(config.robot)
    tried: list[tuple[list[float], float]] = []

    def objective(gains: Array) -> float:
        try:
            value = validate(make_gains(gains, n_motors=robot.n_joints), config.robot, plants=config.plants).log_ratio
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
    training = Training(algorithm="ppo", base="elastic", seed=0)  # for the fingerprint of the nominal plant
    meta = {
        "search": tried,
        "log_ratio": value,
        "validation": {"seed": SEED, "speeds": SPEEDS, "plants": config.plants},
    }
    with made_folder(config.out / SERVO_GAINS / ANYWHERE) as folder:
        save_policy(folder / "seed_0.npz", make_gains(gains, n_motors=robot.n_joints, meta=meta))
    entry = describe_artefact(
        SERVO_GAINS,
        f"{ANYWHERE}/seed_0.npz",
        config.out,
        seed=0,
        plant=ANYWHERE,
        fingerprint=str(training.origin()["physics_fingerprint"]),
        robot_seconds=0.0,
        env_steps=0,
    )
    add_artefacts(SERVO_GAINS, COMMAND, [entry], config.out)
    return np.array(gains)


def _simplex() -> Array:
    """Corners of the first simplex (4, 3): the start, and a step in each gain."""
    return np.array(START) + np.vstack([np.zeros(3), np.diag([0.2, 0.1, 0.2])])


if __name__ == "__main__":
    print(main(tyro.cli(Config)))
