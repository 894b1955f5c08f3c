"""Fit the weakly known parameters of the built-in robot so that, uncompensated, it behaves like the published one.

    python -m scripts.calibrate_nominal            # about four minutes on 2 cores; rewrites the robot's TOML

Objective: the sum over 24 cells (10 and 40 mm/s x 3 radii x 4 positions) of the squared logarithm of simulated over
published RMS path error without compensation (thesis, Tables 4.1b and 4.2b), plus the squared distance of each
parameter's logarithm from its prior in units of its spread, weighted by PRIOR_WEIGHT, plus a penalty where the lowest
locked resonance leaves RESONANCE_HZ. Bounds: no logarithm moves by more than BOUND spreads. Sourced numbers are not
touched. The published results with static and dynamic LuGre, and all maxima, play no part.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import tomlkit
import tyro
from scipy.optimize import least_squares

from ffgym.control import NoCompensation
from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.diagnosis.tables.structures import main_motors
from ffgym.published import published_mm
from ffgym.recordings.metrics import path_errors
from ffgym.robot import RigidArm, RobotDescription, load_robot, resonances
from ffgym.simulation import Run, simulate
from ffgym.studies import circle_references

SPEEDS = (0.010, 0.040)
PRIOR_WEIGHT = 0.4
"""Chosen: a parameter that moves by its spread costs as much as one cell that is off by a factor 1.5."""
BOUND = 3.0
"""Chosen: no parameter moves by more than three spreads."""
RESONANCE_HZ = (9.1, 10.9)
"""Lowest locked resonance of the design, 9-11 Hz, with a margin of 0.1 Hz."""
RESONANCE_WEIGHT = 5.0
"""Chosen: 0.1 Hz outside costs like a cell that is off by a factor 1.65."""


JOINTS = ("j1", "j2", "j3", "j4", "j5", "j6")
"""Joints of the robot that FREE is written for: main motors first, then the wrist's."""


_RATES = ("damping rate", "position bandwidth", "integral rate")
FREE = {
    **{f"{rate} of the {group} servos": 0.7 for group in ("main", "wrist") for rate in _RATES},
    "viscous friction of joints without a source": 0.7,
    **{f"stiffness of joint {j}": 0.25 for j in (1, 2, 3)},
}
"""Parameters of the fit, log-normal factors on prior values, with the standard deviation of their logarithm: how well
the prior is known. Servo gains are set by three rates per group, gain = rate x the gain before it, so that motors of
one size are treated alike: velocity_gain = damping rate x rotor_inertia, position_gain = bandwidth x velocity_gain,
integral_gain = rate x position_gain. Spreads: 0.7 is a factor 2; 0.25 keeps the stiffness near the interpolated one,
well within its factor 2.5."""


@dataclass(frozen=True)
class Config:
    """Calibration of the nominal robot."""

    robot: Path = Path("ffgym/robot/data/irb4600_60_205.toml")
    """Description to read and to rewrite."""
    starts: int = 40
    """Random starts, drawn from the prior, before the local search."""
    seed: int = 0
    """Seed of the starts."""
    iterations: int = 30
    """Largest number of steps of the local search."""
    dry_run: bool = False
    """Print the result, but leave the file alone."""


def prior_robot(robot: RobotDescription) -> RobotDescription:
    """The robot before any fit: each fitted quantity at its `prior`."""
    groups: dict[str, dict[str, Array]] = {}
    for path, quantity in robot.quantities.items():
        if quantity.prior is not None:
            group, name = path.split(".")
            groups.setdefault(group, {})[name] = quantity.prior
    return replace(robot, **{group: replace(getattr(robot, group), **values) for group, values in groups.items()})


def apply(robot: RobotDescription, factors: Sequence[float] | Array) -> RobotDescription:
    """The prior robot with each free parameter multiplied by its factor, in the order of FREE."""
    f = np.asarray(factors)
    inertia, servo, drive, main = robot.drive.rotor_inertia, robot.servo, robot.drive, main_motors(robot)
    damping = _group_mean(servo.velocity_gain / inertia, main) * np.where(main, f[0], f[3])
    bandwidth = _group_mean(servo.position_gain / servo.velocity_gain, main) * np.where(main, f[1], f[4])
    integral = _group_mean(servo.integral_gain / servo.position_gain, main) * np.where(main, f[2], f[5])
    velocity_gain = inertia * damping
    position_gain = velocity_gain * bandwidth
    stiffness = np.ones(robot.n_joints)
    stiffness[:3] = f[7:10]
    sourced = np.array([origin == "sourced" for origin in robot.quantities["friction.viscous"].origin])
    return replace(
        robot,
        servo=replace(
            servo, velocity_gain=velocity_gain, position_gain=position_gain, integral_gain=position_gain * integral
        ),
        drive=replace(
            drive, joint_stiffness=drive.joint_stiffness * stiffness, joint_damping=drive.joint_damping * stiffness
        ),
        friction=robot.friction.scale(viscous=np.where(sourced, 1.0, f[6])),
    )


def _group_mean(values: Array, main: Array) -> Array:
    """Geometric mean of the main and of the wrist motors, each in its places."""
    means = {group: np.exp(np.log(values[main == group]).mean()) for group in (True, False)}
    return np.where(main, means[True], means[False])


class Objective:
    """Residuals of the fit as a function of the logarithms of the factors."""

    def __init__(self, robot: RobotDescription) -> None:
        self.prior = prior_robot(robot)
        self.references = circle_references(RigidArm(self.prior), speeds=SPEEDS)
        self.spread = np.array([*FREE.values()])
        self.best_cost, self.best = np.inf, np.zeros(len(FREE))

    def ratios(self, robot: RobotDescription) -> Array:
        """Simulated over published RMS without compensation, one per cell."""
        arm = RigidArm(robot)
        runs = [Run(reference=replace(ref, robot=robot), law=NoCompensation()) for ref in self.references.values()]
        ratios = []
        for recording, (position, speed) in zip(simulate(runs, arm=arm), self.references, strict=True):
            for error in path_errors(recording):
                published = published_mm("none", "rms", speed, round(error.radius, 6), position)
                assert published is not None
                ratios.append(error.rms * 1e3 / published)
        return np.array(ratios)

    def __call__(self, logs: Array) -> Array:
        """Residuals, all in units of 'one'."""
        robot = apply(self.prior, np.exp(logs))
        lowest, (low, high) = self.lowest_resonances(robot), RESONANCE_HZ
        outside = np.maximum(0, np.maximum(low - lowest, lowest - high))
        try:
            misfit = np.log(self.ratios(robot))
        except FFGymError:  # an unstable servo: worse than any stable one, and no reason to stop the search
            misfit = np.full(3 * len(self.references), 5.0)
        residuals = np.concatenate([misfit, PRIOR_WEIGHT * logs / self.spread, RESONANCE_WEIGHT * outside])
        cost = float((residuals**2).sum())
        if cost < self.best_cost:
            self.best_cost, self.best = cost, logs.copy()
            print(f"  cost {cost:7.3f}  within 1.5: {(np.abs(misfit) < np.log(1.5)).sum()}/{misfit.size}", flush=True)
        return residuals

    def lowest_resonances(self, robot: RobotDescription) -> Array:
        """Lowest resonance with locked motors [Hz] at the start of each motion of the first speed."""
        arm = RigidArm(robot)
        starts = [reference.q[0] for (_, speed), reference in self.references.items() if speed == SPEEDS[0]]
        return np.array([resonances(arm, q)[0] for q in starts])


def write_fitted(path: Path, before: RobotDescription, after: RobotDescription, source: str) -> None:
    """Write the numbers that differ from `before` into the description as fitted, keeping what they replace."""
    document = tomlkit.parse(path.read_text(encoding="utf-8"))
    for entry in before.quantities:
        group, _, name = entry.partition(".")
        if group not in ("servo", "drive", "friction") or name == "control_dt":
            continue
        old, new = (np.asarray(getattr(getattr(robot, group), name)) for robot in (before, after))
        changed = old != new
        table = document[group][name]
        if not changed.any() and "prior" not in table:  # a fit that ends at the prior replaces an earlier one
            continue
        quantity = before.quantities[entry]
        origin = quantity.origin * (len(old) if len(quantity.origin) == 1 else 1)
        table["value"] = [float(f"{x:.4g}") if c else float(x) for x, c in zip(new, changed, strict=True)]
        table["origin"] = ["fitted" if c else o for c, o in zip(changed, origin, strict=True)]
        if "prior" not in table:
            table["prior"], table["prior_source"] = old.tolist(), table["source"]
        table["source"] = source
    path.write_text(tomlkit.dumps(document), encoding="utf-8")


def main(config: Config) -> dict[str, object]:
    """Run the fit, print the outcome, and rewrite the description."""
    robot = load_robot(config.robot)
    if robot.joints != JOINTS:
        raise FFGymError(f"The free parameters are those of a robot with joints {JOINTS}, not {robot.joints}.")
    objective = Objective(robot)
    rng = np.random.default_rng(config.seed)
    print(f"{config.starts} starts from the prior, seed {config.seed}")
    limit = BOUND * objective.spread
    objective(np.zeros(len(FREE)))
    for _ in range(config.starts):
        objective(np.clip(rng.normal(scale=objective.spread), -limit, limit))
    if config.iterations > 0:
        print("local search")
        search = least_squares(
            objective,
            objective.best,
            bounds=(-limit, limit),
            diff_step=[0.03] * len(FREE),
            x_scale=objective.spread,
            ftol=1e-4,
            max_nfev=config.iterations,
        )
        print(f"  {search.nfev} steps: {search.message}")
    fitted = apply(objective.prior, np.exp(objective.best))
    ratios = objective.ratios(fitted)
    factors = {name: float(np.exp(x)) for name, x in zip(FREE, objective.best, strict=True)}
    for name, factor in factors.items():
        print(f"  {name:45s} prior x {factor:.3f}")
    print(f"cost {objective.best_cost:.3f}; lowest locked resonance {objective.lowest_resonances(fitted).round(2)} Hz")
    print(f"cells within a factor 1.5: {(np.abs(np.log(ratios)) < np.log(1.5)).sum()} of {ratios.size}")
    if not config.dry_run:
        source = "scripts/calibrate_nominal.py: uncompensated RMS path error of the published robot at 10 and 40 mm/s"
        write_fitted(config.robot, objective.prior, fitted, source)
    return {"cost": objective.best_cost, "factors": factors, "ratios": ratios.tolist()}


if __name__ == "__main__":
    main(tyro.cli(Config))
