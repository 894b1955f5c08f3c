"""Options of the commands that learn and compare: train, leaderboard."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import tyro

from ffgym.cli.options import RECORD_DT_MS, TEST_SPEEDS_MM_S, Numbers, Threads, Yes

if TYPE_CHECKING:
    from ffgym.agents.residual.plan import Training


@dataclass(frozen=True)
class PolicyOptions:
    """Options that decide a policy, but its seed."""

    algorithm: Literal["ppo", "sac", "tqc", "recurrent_ppo"] = "ppo"
    """Algorithm of stable-baselines3 and sb3-contrib."""
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
    gain_margin: float = 1.0
    """Largest factor by which the residual acts in training, drawn for each episode: a loop that bears more gain."""
    delay_margin: int = 0
    """Largest delay by which it acts in training, in samples of the controller: a loop that bears more delay."""
    nominal: bool = False
    """Train on the nominal robot alone, with nothing drawn."""
    machines: int = 0
    """Machines with physical effects to draw and train on, for robots with drives and losses as
    irb4600_60_205_arm_drives; 0 draws robots without effects."""
    set: tuple[str, ...] = ()
    """Hyper-parameters in place of those of the algorithm's file, e.g. gamma=0.95 hidden=[64,64]."""

    def with_seed(self, seed: int) -> "Training":
        """Make the training that these options describe, with a seed.

        Raises:
            FFGymError: if they make no training.
        """
        from ffgym.agents.residual.bases import base_named
        from ffgym.agents.residual.hyperparameters import hyperparameters
        from ffgym.agents.residual.plan import Training

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
            gain_margin=self.gain_margin,
            delay_margin=self.delay_margin,
            randomization=not self.nominal,
            machines=self.machines,
            seed=seed,
            steps=self.steps,
            hyperparameters=hyperparameters(self.algorithm, self.set),
        )


@dataclass(frozen=True)
class PolicyTraining(PolicyOptions):
    """Train a residual policy at position p1, on robots drawn around the nominal one; go on where it was stopped."""

    seed: int = 0
    """Seed of everything that is random."""
    out: Path | None = None
    """Folder for policy.npz, training.json and TensorBoard's files; a training that was stopped in it goes on."""
    json: Numbers = None


@dataclass(frozen=True)
class NetworkOptions:
    """Options of a network: its task, its motions and its training."""

    network: Literal["static", "extended", "tensor"] = "extended"
    """One B-spline network per motor, two by the sign of the acceleration, or one over speed and position."""
    position_knots: int = 9
    """Knots over the range of each joint on these motions (tensor)."""
    unnormalised: bool = False
    """Learn by the plain gradient, thesis (3.16), instead of dividing by the sum of each spline; needs --gamma."""
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
    record_dt_ms: float = RECORD_DT_MS
    """Time between the rows that are learned from. 4 is the samples of the reference, where the law acts: steadier at
    high speeds, see docs/agents/learning_stability.md."""
    threads: Threads = 0


@dataclass(frozen=True)
class BSpline(NetworkOptions):
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
    """Seed of the noise of a workcell's sensors."""
    json: Numbers = None
    yes: Yes = False


@dataclass(frozen=True)
class Stability(NetworkOptions):
    """Print the largest stable learning rate per motion and joint, and what is left of the signal at a chosen rate."""

    speeds_mm_s: tuple[float, ...] = TEST_SPEEDS_MM_S
    """TCP speeds of the circles to learn on (robots with a work area)."""
    frequencies_hz: tuple[float, ...] = (1.0, 3.0)
    """Frequencies of the sines to learn on (robots with one axis)."""
    changing: bool = False
    """Also predict trials that each run another one of these motions, in any order."""
    figure: Path | None = None
    """Also simulate learning along the first motion, and draw it beside the prediction, in this file."""
    figure_rates: tuple[float, ...] = (0.4, 0.95, 1.6, 2.2)
    """Learning rates of the figure, ascending."""
    figure_joints: tuple[str, ...] = ()
    """Joints of the figure; none given is all."""
    yes: Yes = False


@dataclass(frozen=True)
class Leaderboard:
    """Run agents on the circles of the thesis and on held-out ones; print standings; write results and a page."""

    agents: tuple[str, ...] = ("fixed",)
    """Names; or fixed, all laws but those that practise on every task first; or all; and submissions, files .zip."""
    plants: tuple[str, ...] = ("nominal", "workcell:thesis")
    """nominal, workcell:<name or seed>, draw:<number>."""
    draws: int = 0
    """Drawn plants beside these: draw:0 to one less than this number."""
    splits: tuple[str, ...] = ("train", "positions")
    """Circles: train and positions are the 36 of the thesis; radii and speeds are others; or all."""
    seeds: int = 1
    """Trainings of each row that a seed changes; five ship."""
    margins: bool = False
    """Also measure stability margins of agents with feedback, on a robot with drives: half a minute for each seed."""
    out: Path | None = None
    """Folder of result files, one per row. What is complete in it is not run again."""
    page: Path | None = None
    """Page to write, one file with tables, pictures and cards."""
    adaptation: Path | None = None
    """Results of `python -m scripts.adaptation`, whose curve the page shows then."""
    json: Path | None = None
    """Also write every circle to this file."""
    executor: Literal["local", "ray"] = "local"
    """Place of the work: on this machine, or on a Ray cluster."""
    address: str | None = None
    """Address of a running Ray cluster; none begins one on this machine."""
    jobs: int = 0
    """Processes, or pieces that a cluster works on at once; 0 is one per core. Results are the same at any number."""


@dataclass(frozen=True)
class Submit:
    """Run an agent where it sees observations only, and pack it with its logged actions and what came out."""

    agent: tyro.conf.Positional[str]
    """Law of docs/agents that needs no learning, model:machine.toml, a file .npz of a learned law or a residual policy,
    or a Python file of your own (docs/leaderboard/submissions.md)."""
    name: str
    """Short name, as in tables."""
    author: str
    """Author of the row."""
    track: Literal["causal", "causal, nominal parameters", "per task"]
    """Knowledge that the agent may use, see docs/agents."""
    feedback: bool = True
    """Track: with feedback observes present errors of the motors; feed-forward (--no-feedback, and every law) does
    not, and is shown none."""
    channel: Literal["torque", "setpoint"] = "torque"
    """Quantity that it acts on: torque of the motors, or set-points of position that their servos follow, one every
    4 ms, as controllers of industrial robots take them."""
    title: str | None = None
    """Title in a line; none is the name."""
    out: Path = Path("agent.zip")
    """File to write."""
    seed: int = 0
    """Seed of the agent's randomness and the sensors' noise."""
    env_steps: int = 0
    """Control steps of simulated training that it took; a claim that cannot be checked."""
    robot_seconds: float = 0.0
    """Time that a machine moved while it learned; a claim that cannot be checked."""
    inference_us: float | None = None
    """Time of one decision to claim; none claims nothing. It is measured when a submission is verified."""
    json: Path | None = None
    """Also write the manifest and where it comes from to this file."""
    threads: Threads = 0


@dataclass(frozen=True)
class Verify:
    """Check a submission: replay its actions, and score its agent on machines and motions that are drawn now.

    Agents see observations only. Bubblewrap isolates foreign code if it is installed;
    docs/leaderboard/submissions.md has a container for others.
    """

    submission: tyro.conf.Positional[Path]
    """File of ffgym leaderboard submit."""
    machines: int = 10
    """Machines to draw; 0 replays the public motions alone, which gives no score."""
    motions: int = 6
    """Motions to draw; every machine runs all of them."""
    series: str = "workcell:"
    """Series that machines are drawn from: workcell: or draw:."""
    kinds: tuple[str, ...] = ("circle", "square", "spiral", "tilted")
    """Kinds of motions, in turn: circles, squares with rounded corners, spirals, circles in tilted planes."""
    round_seed: int | None = None
    """Seed of the draw, to repeat a verification; none draws a fresh one and prints it."""
    round: Path | None = None
    """Revealed round of ffgym leaderboard round, whose machines and motions are run."""
    committed: Path | None = None
    """File of the same round that was published before; its hash must be that of the revealed one."""
    beside: tuple[str, ...] = ("elastic",)
    """Laws that need no learning, and other submissions, files .zip, to run on the same machines and motions; elastic
    and zero action always run."""
    json: Path | None = None
    """Also write the verdict to this file, accepted or refused."""
    threads: Threads = 0


@dataclass(frozen=True)
class NewRound:
    """Draw a round: commit to the seed of its machines and motions by a hash, and reveal it afterwards.

    Publish the file of --out before submissions are made, and that of --secret after the last one. A round whose secret
    is there already is kept, and its hash is written again.
    """

    out: Path = Path("round.json")
    """File to publish before: the hash, and no seed."""
    secret: Path = Path("round_secret.json")
    """File to publish afterwards: seed and salt, which fit the hash."""
    machines: int = 10
    """Machines to draw."""
    motions: int = 6
    """Motions to draw; every machine runs all of them."""
    series: str = "workcell:"
    """Series that machines are drawn from: workcell: or draw:."""
    kinds: tuple[str, ...] = ("circle", "square", "spiral", "tilted")
    """Kinds of motions, in turn: circles, squares with rounded corners, spirals, circles in tilted planes."""
