"""Feedback-error learning: a small multi-layer perceptron per motor in place of the B-spline network.

Idea and source: Kawato, Furukawa & Suzuki (1987), Biological Cybernetics 57: the feedback torque is the error of the
feed-forward, and trains it; thesis 3.2 names it as the origin of LFFC. With motor speed v and acceleration a of the
reference, in units that breakaway torque f_s sets (`ffgym.control.observation.Scales`),

    u_lff / f_s = d + sum_h c_h tanh(w_h v + m_h a + b_h)

Offline, an update is the one of LFFC (`ffgym.agents.lffc`): the network is fitted to its own torque plus the rate times
the torque that the feedback still gave. Online, thesis (3.13) and (3.15): every sample moves all weights down the
gradient of its own squared error, in the order of time (`adapt_in_order`).

Run it:

    ffgym demo --agents none lugre_dynamic mlp_fel
    python -m scripts.forgetting

Logged while learning: mean squares of motor error and learning signal per joint, see `ffgym.agents.lffc`.

Departures from the source: one hidden layer instead of two, and only speed and acceleration as inputs, since the rigid
feed-forward is the drive's own; the fit runs a fixed number of full-batch steps of Adam instead of back-propagation
sample by sample, which is there for comparison (`scripts.forgetting`). Training needs torch, running does not. It
computes in double precision on one thread, and no joint touches another: Adam treats every weight by itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Self, final

import numpy as np

from ffgym.agents.declaration import AgentEntry, declare
from ffgym.agents.lffc import Network, thesis_training
from ffgym.agents.trials import Lesson, Trial, every_speed, pick_evenly
from ffgym.control import LawStyle, Window
from ffgym.control.observation import Scales
from ffgym.core.errors import FFGymError, check_shape, check_whole
from ffgym.core.types import Array
from ffgym.robot import RigidArm, RobotDescription

N_STEPS = 200
"""Full-batch steps of Adam in an update. Chosen: with 50, ten updates leave a tenth more motor error."""


STEP_SIZE = 0.02
"""Step size of Adam. Chosen: at 0.005, learning takes twice the trials."""


N_ROWS = 500
"""Samples of a lesson in an update, evenly in time. Chosen: a speed of the motors counts alike in each lesson, and an
update of six motors on three motions takes about a second."""


N_HIDDEN = 16
"""Hidden neurons per motor. Chosen: as many as make a curve of friction, with some to spare."""
SPEED_SLOPES = (1.0, 100.0)
"""First slopes w over scaled speed, drawn evenly in their logarithm: neurons that turn over within the whole range of
about 10 rad/s, and such that turn over within 0.1 rad/s, where friction changes its sign."""
ACCELERATION_SLOPES = (0.3, 30.0)
"""First slopes m over scaled acceleration, in the same way: between all of the fastest circles and the slowest."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class MLP(Network):
    """One hidden layer of tanh per motor; learning never changes the scales."""

    hidden: Array
    """Slopes w and m, shape (N, H, 2): over scaled speed, over scaled acceleration."""
    bias: Array
    """b, shape (N, H)."""
    output: Array
    """c, shape (N, H)."""
    offset: Array
    """d, shape (N,)."""
    scales: Array = field(repr=False)
    """Motor speed [rad/s], acceleration [rad/s^2] and torque [N m] that count as 1, shape (3, N), > 0."""
    name: str = "mlp_fel"
    kind: ClassVar[str] = "mlp_fel"

    def __post_init__(self) -> None:
        n, h, _ = check_shape("hidden", self.hidden, (None, None, 2)).shape
        shapes = {"hidden": (n, h, 2), "bias": (n, h), "output": (n, h), "offset": (n,), "scales": (3, n)}
        for name, shape in shapes.items():
            object.__setattr__(self, name, check_shape(name, getattr(self, name), shape))
        if np.any(self.scales <= 0):
            raise FFGymError(f"scales = {self.scales.tolist()} of law {self.name!r} must be > 0.")

    @classmethod
    def untrained(cls, robot: RobotDescription, rng: np.random.Generator, n_hidden: int = N_HIDDEN) -> Self:
        """Draw a network that adds nothing yet: hidden weights are drawn, output weights are 0.

        Raises:
            FFGymError: if a parameter of the robot that gives a scale is 0.
        """
        scales = Scales.of(robot)
        shape = (robot.n_joints, check_whole("n_hidden", n_hidden, low=1))
        slopes = []
        for limits in (SPEED_SLOPES, ACCELERATION_SLOPES):  # of either sign, evenly in the logarithm of their size
            low, high = np.log(limits)
            size = np.exp(rng.uniform(low, high, shape))
            slopes.append(size * rng.choice([-1.0, 1.0], shape))
        return cls(
            hidden=np.stack(slopes, axis=-1),
            bias=rng.normal(size=shape),
            output=np.zeros(shape),
            offset=np.zeros(robot.n_joints),
            scales=np.stack([scales.velocity, scales.acceleration, robot.friction.static]),
        )

    @property
    def n_joints(self) -> int:
        """Number of motors N."""
        return len(self.offset)

    @property
    def weights(self) -> dict[str, Array]:
        """Weights of both layers."""
        return {"hidden": self.hidden, "bias": self.bias, "output": self.output, "offset": self.offset}

    def step(self, memory: Array, window: Window) -> tuple[Array, Array]:
        """Return the torque of the next sample; the network has no memory."""
        return self.torque_at(window.motor_dq[..., 1, :], window.motor_ddq[..., 1, :]), memory

    def torque_at(self, motor_dq: Array, motor_ddq: Array) -> Array:
        """Compute the torque [N m] at motor speed [rad/s] and acceleration [rad/s^2], all of shape (..., N)."""
        v, a = motor_dq / self.scales[0], motor_ddq / self.scales[1]
        active = np.tanh(self.hidden[..., 0] * v[..., None] + self.hidden[..., 1] * a[..., None] + self.bias)
        return np.asarray(self.scales[2] * (self.offset + (self.output * active).sum(axis=-1)))

    def adapt(self, lessons: Sequence[Lesson], rate: float) -> Self:
        """Fit the network to its own torque plus `rate` times the signal, at `N_ROWS` samples of each lesson."""
        rows = [pick_evenly(lesson.moving, N_ROWS) for lesson in lessons]
        dq, ddq, signal = (
            np.concatenate([getattr(lesson, name)[chosen] for lesson, chosen in zip(lessons, rows, strict=True)])
            for name in ("motor_dq", "motor_ddq", "signal")
        )
        return self.fit_to(dq, ddq, self.torque_at(dq, ddq) + rate * signal)

    def fit_to(self, motor_dq: Array, motor_ddq: Array, wanted: Array) -> Self:
        """Take `N_STEPS` steps of Adam towards the least mean square error; arguments as for `adapt_in_order`."""
        return self._descend(motor_dq, motor_ddq, wanted, None)

    def adapt_in_order(self, motor_dq: Array, motor_ddq: Array, wanted: Array, rate: float) -> Self:
        """Take a step of `rate` down the gradient of each sample's own squared error, in order of time, thesis (3.15).

        Args:
            motor_dq: motor speed [rad/s], shape (T, N).
            motor_ddq: motor acceleration [rad/s^2], shape (T, N).
            wanted: torque that the network should give there [N m], shape (T, N).
            rate: learning rate for errors in units of the torque scale.
        """
        return self._descend(motor_dq, motor_ddq, wanted, rate)

    def _descend(self, motor_dq: Array, motor_ddq: Array, wanted: Array, rate: float | None) -> Self:
        """Take steps down the gradient: of Adam on all samples, or of `rate` on each sample in the order of time."""
        try:
            import torch
        except ImportError as error:
            raise FFGymError("Training a multi-layer perceptron needs torch; pip install 'ffgym[rl]'.") from error
        inputs = np.stack([motor_dq / self.scales[0], motor_ddq / self.scales[1]], axis=-1).swapaxes(0, 1)
        threads = torch.get_num_threads()
        torch.set_num_threads(1)  # so that sums do not depend on the machine
        try:
            # samples and weights as tensors, joints first
            x, y = torch.from_numpy(inputs.copy()), torch.from_numpy((wanted / self.scales[2]).T.copy())
            weights = {
                name: torch.tensor(value, dtype=torch.float64, requires_grad=True)
                for name, value in self.weights.items()
            }
            # optimiser, and the samples of each of its steps
            steps: torch.optim.Optimizer
            if rate is None:
                steps, share = torch.optim.Adam(weights.values(), lr=STEP_SIZE), 1.0
                rows = [slice(None)] * N_STEPS
            else:
                steps, share = torch.optim.SGD(weights.values(), lr=rate), 0.5
                rows = [slice(row, row + 1) for row in range(len(wanted))]
            # gradient descent on the squared error of each joint's network
            for chosen in rows:
                steps.zero_grad()
                inside = x[:, chosen] @ weights["hidden"].transpose(1, 2) + weights["bias"][:, None]
                said = (torch.tanh(inside) * weights["output"][:, None]).sum(-1) + weights["offset"][:, None]
                (share * ((said - y[:, chosen]) ** 2).mean(1).sum()).backward()  # rows are averaged, joints added up
                steps.step()
            return self.with_weights({name: tensor.detach().numpy().copy() for name, tensor in weights.items()})
        finally:
            torch.set_num_threads(threads)


def train_mlp(arm: RigidArm, trial: Trial, seed: int = 0) -> Network:
    """Train a perceptron on the motions of every speed, with rate and iterations of the thesis."""
    first = MLP.untrained(arm.robot, np.random.default_rng(seed))
    return thesis_training(arm.robot.n_joints).learn(first, every_speed(arm), trial).best


declare(
    AgentEntry(
        name="mlp_fel",
        title="perceptron, feedback-error learning",
        about="A small perceptron per motor, learned from the feedback error.",
        track="causal, nominal parameters",
        order=7,
        page="feedback_error.md",
        style=LawStyle(label="perceptron", colour="#7F4F24", marker="X", line="-."),
        make=lambda setting: train_mlp(setting.arm, setting.trial, setting.seed),
        package="torch",
        learns=True,
    )
)
