"""`ffgym train policy`: a residual policy on top of a feed-forward law, by reinforcement learning in simulation."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from ffgym.agents.residual.bases import base_named
from ffgym.agents.residual.hyperparameters import Value, hyperparameters
from ffgym.agents.residual.plan import Training
from ffgym.cli.outputs import check_outputs, provenance
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import FFGymError
from ffgym.core.files import write_json
from ffgym.core.provenance import installed

PACKAGES = ("torch", "stable-baselines3", "sb3-contrib")
"""What training needs."""


@dataclass(frozen=True)
class Options:
    """What decides a policy, but its seed."""

    algorithm: Literal["ppo", "sac", "tqc", "recurrent_ppo"] = "ppo"
    """Of stable-baselines3 and sb3-contrib."""
    base: str = "elastic"
    """Law below the policy: none, lugre_static, lugre_dynamic, elastic, or model:machine.toml."""
    robot: str = "irb4600_60_205"
    """Built-in robot with a work area."""
    steps: int | None = None
    """Control steps of all robots together, rounded up to whole updates; none given is 983040 for ppo and
    recurrent_ppo, 196608 for sac and tqc."""
    joint: bool = False
    """One network that sees all motors, in place of one that serves each of them; recurrent_ppo always has it."""
    memory: int = 1
    """Samples of errors and residuals that the policy sees."""
    bound: float = 0.6
    """Largest residual torque, in breakaway torques of each joint."""
    reward: str = "relative_path_error"
    """Reward of the environment."""
    nominal: bool = False
    """Train on the nominal robot alone, with nothing drawn."""
    set: tuple[str, ...] = ()
    """Hyper-parameters in place of those of the algorithm's file, e.g. gamma=0.95 hidden=[64,64]."""

    def with_seed(self, seed: int) -> Training:
        """What these options ask for.

        Raises:
            FFGymError: if they make no training.
        """
        base, machine = base_named(self.base)
        return Training(
            algorithm=self.algorithm,
            base=base,
            machine=machine,
            robot=self.robot,
            factored=not (self.joint or self.algorithm == "recurrent_ppo"),
            memory=self.memory,
            bound=self.bound,
            reward=self.reward,
            randomization=not self.nominal,
            seed=seed,
            steps=self.steps,
            hyperparameters=hyperparameters(self.algorithm, self.set),
        )


def options_of(training: Training, base: str | None = None) -> list[str]:
    """Options that ask for a training, but its seed; those that are not needed are left out.

    Args:
        training: what to ask for.
        base: law below the policy as the option has it; one with a machine file needs it, e.g. 'model:machine.toml'.

    Raises:
        FFGymError: if options cannot ask for it.
    """
    words = ["--algorithm", training.algorithm, "--base", base or training.base, "--steps", str(training.total)]
    usual = Options()
    for name in ("robot", "memory", "bound", "reward"):
        value = getattr(training, name)
        words += [f"--{name}", str(value)] if value != getattr(usual, name) else []
    words += [] if training.factored or training.algorithm == "recurrent_ppo" else ["--joint"]
    words += [] if training.randomization else ["--nominal"]
    file = hyperparameters(training.algorithm)
    changes = [f"{name}={_text(value)}" for name, value in training.hyperparameters.items() if value != file[name]]
    words += ["--set", *changes] if changes else []
    _check_said(training, words)
    return words


def _check_said(training: Training, words: list[str]) -> None:
    """Read options as a command does, and compare.

    Raises:
        FFGymError: if they ask for something else.
    """
    import tyro

    wanted, said = training.document(), tyro.cli(Options, args=words).with_seed(training.seed).document()
    lost = [name for name, value in wanted.items() if said[name] != value]
    if lost:
        raise FFGymError(
            f"No options of ffgym train policy ask for this training: its {' and '.join(lost)} would differ. Train "
            f"with ffgym train policy or scripts.train."
        )


def _text(value: Value) -> str:
    """A hyper-parameter as `--set` reads it."""
    return value if isinstance(value, str) else json.dumps(value, separators=(",", ":"))


def need_training() -> None:
    """Check that all is installed that training needs.

    Raises:
        FFGymError: if something is not.
    """
    missing = [name for name in PACKAGES if not installed(name)]
    if missing:
        raise FFGymError(f"ffgym train policy needs {', '.join(missing)}; pip install 'ffgym[rl]'.")


@dataclass(frozen=True)
class Policy(Options):
    """Train a residual policy at position p1, on robots drawn around the nominal one; go on where it was stopped."""

    seed: int = 0
    """Of everything that is random."""
    out: Path | None = None
    """Folder for policy.npz, training.json and TensorBoard's files; a training that was stopped in it goes on."""
    json: Path | None = None
    """Also write every number to this file."""

    def run(self) -> None:
        """Check, train, print."""
        need_training()
        if self.out is None:
            raise FFGymError("Say where the policy goes: --out FOLDER.")
        if self.out.exists() and not self.out.is_dir():
            raise FFGymError(f"--out {self.out}: is a file, must be a folder; choose another name.")
        if self.json is not None and self.json.resolve().is_relative_to(self.out.resolve()):
            raise FFGymError(f"--json {self.json}: lies in --out {self.out}, whose files are the training's own.")
        check_outputs({"--json": self.json})
        training = self.with_seed(self.seed)
        robot = training.known()
        from ffgym.agents.residual.training import train

        with progress_bar("training", "steps") as progress:
            trained = train(training, self.out, watch=progress)
        if self.json is not None:
            fingerprint = str(trained.policy.meta["origin"]["physics_fingerprint"])
            curve = [list(point) for point in trained.curve]
            own = {"env_steps": trained.env_steps, "sha256": trained.sha256, "learning_curve": curve}
            head = provenance("ffgym train policy", self, robot.name, fingerprint, self.seed)
            write_json(self.json, head | {"training": training.document()} | own)
        (_, first), (_, last) = trained.curve[0], trained.curve[-1]
        print(f"{training.algorithm} on {training.base}, seed {training.seed}: {trained.env_steps} steps")
        print(f"reward per step, with exploration: {first:.4f} at first, {last:.4f} at last")
        print(f"policy: {trained.file}")
