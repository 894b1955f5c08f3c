"""Plan of a training of a residual policy: everything that decides its result, bit for bit."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from ffgym.agents.residual.bases import ACTION_SCALES, base_law
from ffgym.agents.residual.composition import AHEAD
from ffgym.agents.residual.hyperparameters import ALGORITHMS, Value, check_hyperparameters, hyperparameters
from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole
from ffgym.robot import RigidArm, RobotDescription, load_robot
from ffgym.simulation import SimulatedRig

ENVIRONMENT = "ffgym/CirclePath-v0"
"""Id of the training environment."""
POSITION = "p1"
"""Position of the training circles; all other named positions are held out, so this is no option."""
ENCODER_BITS = 16
"""Bits of the resolvers that a policy sees motors through, per turn of the motor, as of industrial resolvers."""
MACHINES_SEED = 20_261_127
"""Seed of the machines of a training; those of the validation have another one."""
DEFAULT_STEPS: Mapping[str, int] = {"ppo": 983_040, "recurrent_ppo": 983_040, "sac": 196_608, "tqc": 196_608}
"""Control steps by default, in whole segments; chosen: learning curves are flat there, within minutes."""
MOST_STEPS = 100_000_000
"""Most control steps, which take a day; chosen, a hundred times as many as by default."""


@dataclass(frozen=True, kw_only=True)
class Training:
    """One training; equal trainings give equal policies on one machine."""

    algorithm: str = "ppo"
    """One of `ffgym.agents.residual.hyperparameters.ALGORITHMS`."""
    base: str = "elastic"
    """Law below the policy, one of `ffgym.agents.residual.bases.BASES`."""
    machine: str | None = field(default=None, repr=False)
    """Text of the machine file of the base 'model'."""
    robot: str = "irb4600_60_205"
    """Nominal robot of the controller, around which robots are drawn: a built-in robot with a work area."""
    factored: bool = True
    """True: one network of each motor's own numbers serves all motors. False: one network sees all of them."""
    memory: int = 1
    """Samples of errors and residuals that the policy sees."""
    bound: float = 0.6
    """Largest residual torque, in breakaway torques."""
    reward: str = "relative_path_error"
    """Name of a reward of the environment; privileged ones are for training alone, the policy does not see them."""
    gain_margin: float = 1.0
    """Factor that the loop must bear: in each episode the residual acts times a factor drawn from 1 to it."""
    delay_margin: int = 0
    """Delay that the loop must bear [samples of the controller]: in each episode the residual acts later by one drawn
    from 0 to it. Rewards of the path alone pay for loops that chatter (docs/leaderboard/margins.md)."""
    randomization: bool = True
    """True: each episode has a robot drawn around the nominal one (`PlantDistribution()`). False: all the nominal."""
    machines: int = 0
    """Number of machines with physical effects, drawn once around the nominal robot, one of which each episode has
    (`ffgym.agents.amortised.draws`); the robot must have drives and losses as they do. 0: robots without effects, as
    `randomization` says."""
    seed: int = 0
    steps: int | None = None
    """Control steps of all robots together, rounded up to whole updates; defaults to DEFAULT_STEPS."""
    hyperparameters: Mapping[str, Value] = field(default_factory=dict)
    """All hyper-parameters; defaults to those of the algorithm's file."""

    def __post_init__(self) -> None:
        check_choice("algorithm", self.algorithm, list(ALGORITHMS))
        check_choice("base", self.base, list(ACTION_SCALES))
        check_whole("memory", self.memory, unit="samples", low=1, high=1000)
        check_number("bound of the residual", self.bound, unit="breakaway torques", low=0.0, open_low=True)
        check_number("gain_margin", self.gain_margin, low=1.0, high=100.0)
        check_whole("delay_margin", self.delay_margin, unit="samples", low=0, high=100)
        check_whole("machines", self.machines, low=0, high=100_000)
        if self.machines and not self.randomization:
            raise FFGymError(
                f"machines = {self.machines} are drawn, so that randomization = False cannot be asked for."
            )
        check_whole("seed", self.seed, low=0)
        if self.factored and self.algorithm == "recurrent_ppo":
            raise FFGymError("The LSTM of recurrent_ppo sees all motors at once: train it with factored=False.")
        own = check_hyperparameters(self.algorithm, self.hyperparameters or hyperparameters(self.algorithm))
        object.__setattr__(self, "hyperparameters", own)
        steps = DEFAULT_STEPS[self.algorithm] if self.steps is None else self.steps
        object.__setattr__(self, "steps", check_whole("steps", steps, low=1, high=MOST_STEPS))
        if self.total <= own.get("learning_starts", -1):  # type: ignore[operator]
            raise FFGymError(
                f"steps = {self.total} must be more than learning_starts = {own['learning_starts']}, the steps before "
                f"which {self.algorithm} does not learn. Train for longer, or lower learning_starts."
            )

    @property
    def total(self) -> int:
        """Least number of control steps."""
        assert self.steps is not None  # see __post_init__
        return self.steps

    @property
    def n_segments(self) -> int:
        """Parts between which a training can be interrupted without a trace."""
        return -(-self.total // self.integer("segment_steps"))

    @property
    def action_scale(self) -> float:
        """Torque of an action of 1, in breakaway torques."""
        return ACTION_SCALES[self.base]

    @property
    def preview(self) -> int:
        """Samples of the reference that are observed."""
        return AHEAD[-1]

    def number(self, name: str) -> float:
        """Return a hyper-parameter."""
        return float(self.hyperparameters[name])  # type: ignore[arg-type]

    def integer(self, name: str) -> int:
        """Return a hyper-parameter that is whole."""
        return int(self.hyperparameters[name])  # type: ignore[arg-type]

    def widths(self, name: str) -> list[int]:
        """Return a hyper-parameter that is widths of layers."""
        return list(self.hyperparameters[name])  # type: ignore[arg-type]

    def learning_rate(self, segment: int) -> float:
        """Compute the learning rate of a segment: from the first to the final one in even steps."""
        first, final = self.number("learning_rate"), self.number("final_learning_rate")
        return first + (final - first) * segment / max(self.n_segments - 1, 1)

    def known(self) -> RobotDescription:
        """Load the nominal robot of the controller.

        Raises:
            FFGymError: if it has no place to train at, or the base cannot be made for it.
        """
        robot = load_robot(self.robot)
        if robot.work_area is None or POSITION not in robot.work_area.positions:
            raise FFGymError(
                f"Robot {robot.name!r} has no position {POSITION!r} for circles; policies are trained there."
            )
        base_law(self.base, self.machine, robot)
        return robot

    def document(self) -> dict[str, Any]:
        """Return all settings for JSON."""
        values = asdict(self)
        own = {name: list(v) if isinstance(v, tuple) else v for name, v in self.hyperparameters.items()}
        return values | {"hyperparameters": own}

    def origin(self) -> dict[str, Any]:
        """Return the rest that decides the result: environment and physics."""
        return {
            "environment": ENVIRONMENT,
            "position": POSITION,
            "encoder_bits": ENCODER_BITS,
            "action_scale": self.action_scale,
            "physics_fingerprint": SimulatedRig(arm=RigidArm(self.known())).fingerprint,
        }
