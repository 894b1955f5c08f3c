"""`ffgym lffc`: learning feed-forward control, a B-spline network trained from trials on a simulated robot."""

import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from ffgym.agents.bspline import BSplineNetwork, ExtendedBSN, SplineBasis, StaticBSN
from ffgym.agents.coulomb_prior import CoulombPrior
from ffgym.agents.law_files import save_law
from ffgym.agents.lffc import LFFC, Learning, relative, robot_seconds, thesis_training
from ffgym.agents.stability import LearningStability
from ffgym.agents.trials import RigTrial, training_motions
from ffgym.cli.outputs import check_outputs
from ffgym.cli.unused import given_options, refuse_unused
from ffgym.core.errors import FFGymError
from ffgym.core.files import write_json
from ffgym.core.provenance import versions
from ffgym.core.types import Array
from ffgym.envs.machines import is_workcell, rig_of
from ffgym.paths import Reference
from ffgym.robot import RobotDescription
from ffgym.simulation import RECORD_DT

NETWORKS: dict[str, type[StaticBSN] | type[ExtendedBSN]] = {"static": StaticBSN, "extended": ExtendedBSN}
"""Networks by the word for them on the command line."""


@dataclass(frozen=True)
class Lffc:
    """Train a network on test motions, trial by trial; print how errors fall; write the law that was learned."""

    network: Literal["static", "extended"] = "extended"
    """One B-spline network per motor, or two by the sign of the acceleration."""
    order: int = 2
    """Order of the splines; 2 is hats."""
    robot: str = "irb4600_60_205"
    """Built-in robot, a path to a description that ends in .toml, or workcell:<name or seed>."""
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
    threads: int = 0
    """Threads of the simulation, 0 for all cores; results are the same at any number."""

    def run(self) -> None:
        """Learn, write, print."""
        self._check()
        rig = rig_of(self.robot)
        robot, arm = rig.robot, rig.arm
        refuse_unused(self, robot)
        motions = training_motions(
            arm, self.positions, [speed / 1e3 for speed in self.speeds_mm_s], self.frequencies_hz
        )
        trial = RigTrial(rig=rig, seed=self.seed, record_dt=self.record_dt_ms / 1e3, n_threads=self.threads)
        fingerprint = rig.fingerprint
        first = self._first(robot, motions, trial)
        self._warn(first, motions, trial)
        learning = self._learn(first, motions, trial, fingerprint)
        info = self._provenance(robot, motions, learning, fingerprint)
        save_law(self.out, learning.best, meta=info)
        if self.json is not None:
            write_json(self.json, info)
        self._state.unlink(missing_ok=True)
        print(learning_table(learning, robot.joints))
        print(f"{info['trials']} trials, {info['robot_seconds']:.0f} s of robot time")
        print(f"law: {self.out}")
        if self.json is not None:
            print(f"numbers: {self.json}")

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

    def _first(self, robot: RobotDescription, motions: list[Reference], trial: RigTrial) -> BSplineNetwork:
        """The network to begin with."""
        network = NETWORKS[self.network].zero(robot.n_joints, SplineBasis(order=self.order), name=self.out.stem)
        return network.filled(CoulombPrior.estimated(motions, trial).torque_at) if self.prior else network

    def _warn(self, first: BSplineNetwork, motions: list[Reference], trial: RigTrial) -> None:
        """Say so where the rate is too high for these motions; training goes on, and keeps its best trial."""
        study = LearningStability.of(first, trial.rig.arm, motions, signal=self.signal, record_dt=trial.record_dt)
        warning = study.warning(self._procedure(first.n_joints).rate)
        if warning is not None:
            print(f"ffgym: warning: {warning}", file=sys.stderr)

    def _learn(self, first: BSplineNetwork, motions: list[Reference], trial: RigTrial, fingerprint: str) -> Learning:
        from ffgym.cli.progress import progress_bar

        with progress_bar("learning", "trials") as progress:
            return self._procedure(first.n_joints).learn(
                first,
                motions,
                trial,
                state=self._state,
                machine=f"{fingerprint}, rows every {self.record_dt_ms:g} ms",
                watch=lambda learning, total: progress(learning.trials, total),
            )

    def _procedure(self, n_joints: int) -> LFFC:
        usual = thesis_training(n_joints)
        return LFFC(
            rate=usual.rate if self.gamma is None else self.gamma,
            iterations=usual.iterations if self.iterations is None else self.iterations,
            signal=self.signal,
        )

    def _provenance(
        self, robot: RobotDescription, motions: list[Reference], learning: Learning, fingerprint: str
    ) -> dict[str, Any]:
        """Every number, and its origin. Nothing is random but the sensors of a workcell; the seed is null without."""
        trials = learning.trials + self.prior
        return {
            "command": "ffgym lffc",
            "config": {k: str(v) if isinstance(v, Path) else v for k, v in asdict(self).items()},
            "learning": asdict(self._procedure(robot.n_joints)),
            "robot": robot.name,
            "motions": [motion.name for motion in motions],
            "trials": trials,
            "robot_seconds": robot_seconds(motions, trials),
            "mean_square_error_rad2": learning.error.tolist(),
            "mean_square_signal": learning.signal.tolist(),
            "best_trial": learning.best_trial.tolist(),
            "locked": learning.locked.tolist(),
            "seed": self.seed if is_workcell(self.robot) else None,
            "versions": versions(),
            "physics_fingerprint": fingerprint,
        }


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
