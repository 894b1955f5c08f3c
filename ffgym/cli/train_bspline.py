"""`ffgym train bspline` and `stability`: B-spline networks, learned trial by trial, and how fast they may learn."""

import sys
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ffgym.agents.bspline import BSplineNetwork, ExtendedBSN, SplineBasis, StaticBSN
from ffgym.agents.coulomb_prior import CoulombPrior
from ffgym.agents.law_files import save_law
from ffgym.agents.lffc import LFFC, Learning, relative, robot_seconds, thesis_training
from ffgym.agents.stability import LearningStability
from ffgym.agents.trials import RigTrial, SimulatedTrial, training_motions
from ffgym.cli.descriptions import described_robot
from ffgym.cli.outputs import check_outputs
from ffgym.cli.unused import given_options, refuse_unused
from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole
from ffgym.core.files import write_json
from ffgym.core.provenance import versions
from ffgym.core.types import Array
from ffgym.envs.machines import is_workcell, rig_of
from ffgym.paths import SPEEDS, Reference
from ffgym.robot import RigidArm
from ffgym.simulation import RECORD_DT, Rig

NETWORKS: dict[str, type[StaticBSN] | type[ExtendedBSN]] = {"static": StaticBSN, "extended": ExtendedBSN}
"""Networks by the word for them on the command line."""


@dataclass(frozen=True)
class Procedure:
    """What is learned, on which motions, and how."""

    network: Literal["static", "extended"] = "extended"
    """One B-spline network per motor, or two by the sign of the acceleration."""
    robot: str = "irb4600_60_205"
    """Built-in robot, a path to a description that ends in .toml, or, to train, workcell:<name or seed>."""
    positions: tuple[str, ...] = ("p1",)
    """Positions of the circles to learn on (robots with a work area)."""
    speeds_mm_s: tuple[float, ...] = (10.0,)
    """TCP speeds of the circles to learn on (robots with a work area)."""
    frequencies_hz: tuple[float, ...] = (1.0,)
    """Frequencies of the sines to learn on (robots with one axis)."""
    gamma: float | None = None
    """Learning rate; none given is the thesis', 0.95, or 0.8 on one axis."""
    iterations: int | None = None
    """Updates at most; none given is the thesis', 10, or 15 on one axis."""
    signal: Literal["u_p", "u_c", "e_p"] = "u_p"
    """Learning signal."""
    record_dt_ms: float = RECORD_DT * 1e3
    """Time between the rows that are learned from. 4 is the samples of the reference, where the law acts: steadier at
    high speeds, see docs/agents/learning_stability.md."""
    threads: int = 0
    """Threads of the simulation, 0 for all cores; results are the same at any number."""

    @property
    def record_dt(self) -> float:
        """Time between rows [s]."""
        return self.record_dt_ms / 1e3

    def motions(self, arm: RigidArm) -> list[Reference]:
        """Motions of one trial.

        Raises:
            FFGymError: if an option says nothing about this robot, or there is no such motion.
        """
        refuse_unused(self, arm.robot)
        speeds = [speed / 1e3 for speed in self.speeds_mm_s]
        return training_motions(arm, self.positions, speeds, self.frequencies_hz)

    def rate_and_iterations(self, n_joints: int) -> tuple[float, int]:
        """Learning rate and updates, those of the thesis where none are given."""
        usual = thesis_training(n_joints)
        return (
            usual.rate if self.gamma is None else self.gamma,
            usual.iterations if self.iterations is None else self.iterations,
        )


@dataclass(frozen=True)
class BSpline(Procedure):
    """Train a network on test motions, trial by trial; print how errors fall; write the law that was learned."""

    order: int = 2
    """Order of the splines; 2 is hats."""
    prior: bool = False
    """Begin with a Coulomb torque, estimated from one more trial, instead of zero weights."""
    out: Path = Path("network.npz")
    """Law to write; its name is that of the file without .npz."""
    resume: bool = False
    """Go on where an interrupted training with the same options stopped; begin if there is none."""
    seed: int = 0
    """Of the noise of a workcell's sensors."""
    json: Path | None = None
    """Also write every number to this file."""

    def run(self) -> None:
        """Learn, write, print."""
        self._check()
        rig = self._rig
        motions = self.motions(rig.arm)
        trial = RigTrial(rig=rig, seed=self.seed, record_dt=self.record_dt, n_threads=self.threads)
        first = NETWORKS[self.network].zero(rig.robot.n_joints, SplineBasis(order=self.order), name=self.out.stem)
        if self.prior:
            first = first.filled(CoulombPrior.estimated(motions, trial).torque_at)
        self._warn(first, motions)
        learning = self._learn(first, motions, trial)
        info = self._provenance(motions, learning)
        save_law(self.out, learning.best, meta=info)
        if self.json is not None:
            write_json(self.json, info)
        self._state.unlink(missing_ok=True)
        print(learning_table(learning, rig.robot.joints))
        print(f"{info['trials']} trials, {info['robot_seconds']:.0f} s of robot time")
        print(f"law: {self.out}")
        if self.json is not None:
            print(f"numbers: {self.json}")

    @cached_property
    def _rig(self) -> Rig:
        return rig_of(self.robot)

    @cached_property
    def _procedure(self) -> LFFC:
        rate, iterations = self.rate_and_iterations(self._rig.robot.n_joints)
        return LFFC(rate=rate, iterations=iterations, signal=self.signal)

    @property
    def _state(self) -> Path:
        """What is kept between trials, beside the law."""
        return self.out.with_suffix(".state.npz")

    def _check(self) -> None:
        if self.out.suffix != ".npz":
            raise FFGymError(f"--out {self.out}: the name of a law's file must end in .npz.")
        if not is_workcell(self.robot) and (given := given_options(self, ("seed",))):
            raise FFGymError(f"{given[0]} has no effect on {self.robot}: only a workcell's sensors are random.")
        check_outputs({"--out": self.out, "--json": self.json})
        if self._state.exists() and not self.resume:
            raise FFGymError(
                f"{self._state}: holds a training that was interrupted; go on with it by --resume, or delete it."
            )

    def _warn(self, first: BSplineNetwork, motions: list[Reference]) -> None:
        """Say so where the rate is too high for these motions; training goes on, and keeps its best trial."""
        study = LearningStability.of(first, self._rig.arm, motions, signal=self.signal, record_dt=self.record_dt)
        warning = study.warning(self._procedure.rate)
        if warning is not None:
            print(f"ffgym: warning: {warning}", file=sys.stderr)

    def _learn(self, first: BSplineNetwork, motions: list[Reference], trial: RigTrial) -> Learning:
        from ffgym.cli.progress import progress_bar

        with progress_bar("learning", "trials") as progress:
            return self._procedure.learn(
                first,
                motions,
                trial,
                state=self._state,
                machine=f"{self._rig.fingerprint}, rows every {self.record_dt_ms:g} ms",
                watch=lambda learning, total: progress(learning.trials, total),
            )

    def _provenance(self, motions: list[Reference], learning: Learning) -> dict[str, Any]:
        """Every number, and its origin. Nothing is random but the sensors of a workcell; the seed is null without."""
        trials = learning.trials + self.prior
        return {
            "command": "ffgym train bspline",
            "config": {k: str(v) if isinstance(v, Path) else v for k, v in asdict(self).items()},
            "learning": asdict(self._procedure),
            "robot": self._rig.robot.name,
            "motions": [motion.name for motion in motions],
            "trials": trials,
            "robot_seconds": robot_seconds(motions, trials),
            "mean_square_error_rad2": learning.error.tolist(),
            "mean_square_signal": learning.signal.tolist(),
            "best_trial": learning.best_trial.tolist(),
            "locked": learning.locked.tolist(),
            "seed": self.seed if is_workcell(self.robot) else None,
            "versions": versions(),
            "physics_fingerprint": self._rig.fingerprint,
        }


@dataclass(frozen=True)
class Stability(Procedure):
    """Print the largest stable learning rate per motion and joint, and what is left of the signal at a chosen rate."""

    speeds_mm_s: tuple[float, ...] = tuple(speed * 1e3 for speed in SPEEDS)
    """TCP speeds of the circles to learn on (robots with a work area)."""
    frequencies_hz: tuple[float, ...] = (1.0, 3.0)
    """Frequencies of the sines to learn on (robots with one axis)."""
    figure: Path | None = None
    """Also simulate learning along the first motion, and draw it beside the prediction, in this file."""
    figure_rates: tuple[float, ...] = (0.4, 0.95, 1.6, 2.2)
    """Learning rates of the figure, ascending."""
    figure_joints: tuple[str, ...] = ()
    """Joints of the figure; none given is all."""

    def run(self) -> None:
        """Predict, print, and maybe simulate and draw."""
        if self.figure is not None:
            from ffgym.report import check_figure

            check_figure(self.figure)
            self._check_rates()
        arm = RigidArm(described_robot(self.robot))
        for joint in self.figure_joints:
            check_choice("joint", joint, arm.robot.joints)
        rate, iterations = self.rate_and_iterations(arm.robot.n_joints)
        rate = check_number("gamma", rate, low=0.0, open_low=True)
        iterations = check_whole("iterations", iterations, low=0)
        motions = self.motions(arm)
        if not motions:
            raise FFGymError("There is no motion to learn on; give one frequency or more.")
        network = NETWORKS[self.network].zero(arm.robot.n_joints)
        groups = [[motion] for motion in motions] + ([motions] if len(motions) > 1 else [])
        for group in groups:
            study = LearningStability.of(network, arm, group, signal=self.signal, record_dt=self.record_dt)
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
        from ffgym.report.learning_plots import learning_figure

        trial = SimulatedTrial(arm=arm, record_dt=self.record_dt, n_threads=self.threads)
        curves = learning_curves(network, trial, motion, self.figure_rates, iterations, signal=self.signal)
        shown = [joint in (self.figure_joints or arm.robot.joints) for joint in arm.robot.joints]
        curves = [each for each, wanted in zip(curves, shown, strict=True) if wanted]
        shown_curves = learning_figure(curves)
        save_figure(shown_curves.figure, path)
        print(f"{shown_curves.caption}\nfigure: {path}")


def learning_table(learning: Learning, joints: tuple[str, ...]) -> str:
    """Relative mean squares per trial and joint as text; the best trial of a joint has a star."""
    width = max(9, *(len(joint) for joint in joints))

    def rows(title: str, values: Array) -> list[str]:
        head = [title, "trial" + "".join(joint.rjust(width + 1) for joint in joints)]
        for k, row in enumerate(values):
            marks = ["*" if k == best else " " for best in learning.best_trial]
            head.append(f"{k:5d}" + "".join(f"{x:{width}.4f}{m}" for x, m in zip(row, marks, strict=True)))
        return head

    lines = [
        *rows("mean square of the motor error, trial 0 is 1", relative(learning.error)),
        "",
        *rows("mean square of the learning signal, trial 0 is 1", relative(learning.signal)),
        "",
        f"* weights kept. Done before the end: {_named(joints, learning)}.",
    ]
    return "\n".join(lines)


def _named(joints: tuple[str, ...], learning: Learning) -> str:
    return ", ".join(joint for joint, locked in zip(joints, learning.locked, strict=True) if locked) or "no joint"


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
