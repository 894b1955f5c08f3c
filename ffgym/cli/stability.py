"""`ffgym stability`: how fast a B-spline network may learn, predicted from the robot's description."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from ffgym.agents.bspline import BSplineNetwork
from ffgym.agents.lffc import thesis_training
from ffgym.agents.stability import LearningStability
from ffgym.agents.trials import SimulatedTrial, training_motions
from ffgym.cli.descriptions import described_robot
from ffgym.cli.lffc import NETWORKS
from ffgym.cli.unused import refuse_unused
from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole
from ffgym.paths import SPEEDS, Reference
from ffgym.robot import RigidArm
from ffgym.simulation import RECORD_DT


@dataclass(frozen=True)
class Stability:
    """Print the largest stable learning rate per motion and joint, and what is left of the signal at a chosen rate."""

    network: Literal["static", "extended"] = "extended"
    """One B-spline network per motor, or two by the sign of the acceleration."""
    robot: str = "irb4600_60_205"
    """Built-in robot, or a path to a description that ends in .toml."""
    positions: tuple[str, ...] = ("p1",)
    """Positions of the circles to learn on (robots with a work area)."""
    speeds_mm_s: tuple[float, ...] = tuple(speed * 1e3 for speed in SPEEDS)
    """TCP speeds of the circles to learn on (robots with a work area)."""
    frequencies_hz: tuple[float, ...] = (1.0, 3.0)
    """Frequencies of the sines to learn on (robots with one axis)."""
    gamma: float | None = None
    """Learning rate; none given is the thesis', 0.95, or 0.8 on one axis."""
    iterations: int | None = None
    """Updates; none given is the thesis', 10, or 15 on one axis."""
    signal: Literal["u_p", "u_c", "e_p"] = "u_p"
    """Learning signal."""
    record_dt_ms: float = RECORD_DT * 1e3
    """Time between the rows that are learned from; 4 is the samples of the reference, where the law acts."""
    figure: Path | None = None
    """Also simulate learning along the first motion, and draw it beside the prediction, in this file."""
    figure_rates: tuple[float, ...] = (0.4, 0.95, 1.6, 2.2)
    """Learning rates of the figure, ascending."""
    figure_joints: tuple[str, ...] = ()
    """Joints of the figure; none given is all."""
    threads: int = 0
    """Threads of the simulation, 0 for all cores."""

    def run(self) -> None:
        """Predict, print, and maybe simulate and draw."""
        if self.figure is not None:
            from ffgym.report import check_figure

            check_figure(self.figure)
            self._check_rates()
        arm = RigidArm(described_robot(self.robot))
        refuse_unused(self, arm.robot)
        for joint in self.figure_joints:
            check_choice("joint", joint, arm.robot.joints)
        usual = thesis_training(arm.robot.n_joints)
        rate = check_number("gamma", usual.rate if self.gamma is None else self.gamma, low=0.0, open_low=True)
        iterations = check_whole("iterations", usual.iterations if self.iterations is None else self.iterations, low=0)
        speeds = [speed / 1e3 for speed in self.speeds_mm_s]
        motions = training_motions(arm, self.positions, speeds, self.frequencies_hz)
        if not motions:
            raise FFGymError("There is no motion to learn on; give one frequency or more.")
        network = NETWORKS[self.network].zero(arm.robot.n_joints)
        groups = [[motion] for motion in motions] + ([motions] if len(motions) > 1 else [])
        for group in groups:
            study = LearningStability.of(network, arm, group, signal=self.signal, record_dt=self.record_dt_ms / 1e3)
            print(f"{' + '.join(motion.name for motion in group)}\n{stability_table(study, rate, iterations)}")
            verdict = study.warning(rate) or f"{rate:g} is stable on every joint"
            print(f"{verdict[0].upper()}{verdict[1:]}.\n")
        if self.figure is not None:
            self._draw(network, arm, motions[0], iterations, self.figure)

    def _check_rates(self) -> None:
        for rate in self.figure_rates:
            check_number("figure rate", rate, low=0.0, open_low=True)
        if not self.figure_rates or np.any(np.diff(self.figure_rates) <= 0):
            raise FFGymError(f"figure rates = {list(self.figure_rates)} must be one or more, ascending.")

    def _draw(self, network: BSplineNetwork, arm: RigidArm, motion: Reference, iterations: int, path: Path) -> None:
        from ffgym.agents.stability import learning_curves
        from ffgym.report import save_figure
        from ffgym.report.learning.learning_plot import learning_caption, learning_figure

        trial = SimulatedTrial(arm=arm, record_dt=self.record_dt_ms / 1e3, n_threads=self.threads)
        curves = learning_curves(network, trial, motion, self.figure_rates, iterations, signal=self.signal)
        shown = [joint in (self.figure_joints or arm.robot.joints) for joint in arm.robot.joints]
        curves = [each for each, wanted in zip(curves, shown, strict=True) if wanted]
        save_figure(learning_figure(curves), path)
        print(f"{learning_caption(curves)}\nfigure: {path}")


def stability_table(study: LearningStability, rate: float, iterations: int) -> str:
    """Largest stable rates, growth at `rate`, and friction's share in the signal that is left, per joint, as text."""
    mean_squares = study.mean_squares(rate, iterations)
    left = np.sqrt(mean_squares[-1] / mean_squares[0])
    rows = {
        "largest stable learning rate": study.largest_rate,
        f"growth per iteration at {rate:g}": study.growth(rate),
        f"friction left after {iterations} (RMS)": left,
    }
    width = max(map(len, rows))
    lines = [" " * width + "".join(joint.rjust(9) for joint in study.joints)]
    lines += [name.ljust(width) + "".join(f"{value:9.3f}" for value in values) for name, values in rows.items()]
    return "\n".join(lines)
