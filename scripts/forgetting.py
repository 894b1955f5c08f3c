"""Measure what a network forgets while it learns something else: thesis 3.2 on perceptrons and B-splines.

python -m scripts.forgetting --out forgetting.png

The thesis argues that the samples of a motion are highly correlated, and that a multi-layer perceptron, whose weights
all answer everywhere, then fits the last data presented; a B-spline network moves the weights near the sample only.

The experiment: both networks learn the friction of a motor over all of its speeds. Then it runs at high forward
speeds only, up and down, slowly, and friction there has changed by a fifth, as it does where a gearbox warms up. The
networks go on learning sample by sample in the order of time, by (3.15). What do they then say at the other speeds?

Printed: how far what a network says at the other speeds has moved (forgotten), and how much of the change it has missed
at those that came (missed): RMS, as shares of the RMS friction there.

Departures from the source: the thesis argues and refers to Velthuis (2000), it shows no numbers. Friction is known here
and free of noise, so that all that is seen is what learning does.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ffgym.agents.bspline import StaticBSN
from ffgym.agents.feedback_error import MLP
from ffgym.control import StaticLuGre
from ffgym.core.errors import FFGymError
from ffgym.core.measures import rms
from ffgym.core.types import Array
from ffgym.report import panels, save_figure
from ffgym.robot import RobotDescription, load_robot

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TOP_SPEED = 10.0
"""Motor speed [rad/s], either way: about the fastest of the circles at p1."""
SEEN_FROM = 5.0
"""Lowest speed of the second stage [rad/s]; chosen, friction is smooth from there on."""
CHANGE = 1.2
"""Friction of the second stage over that of the first; chosen."""
N_UPDATES = 20
"""Full-batch updates of the perceptron in the first stage; chosen, by then it is off by a few percent."""
N_SAMPLES = 250
"""Samples of one sweep through the second stage: 0.02 rad/s apart, so that neighbours hardly differ."""
N_SWEEPS = 20
"""Through the second stage; chosen, by then the splines have learned the change."""
SPLINE_RATE = 0.1
"""gamma of (3.15) for the B-splines, that of `ffgym.agents.online_lffc`."""
MLP_RATE = 0.01
"""gamma of (3.15) for the perceptron; chosen, learns the change about as fast."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Curves:
    """Torque of a network for one motor before and after the second stage, T speeds."""

    speed: Array
    """Motor speed [rad/s], ascending, shape (T,)."""
    friction: Array
    """Friction that was learned first [N m], shape (T,)."""
    before: Array
    """Output of the network after the first stage [N m], shape (T,)."""
    after: Array
    """Output after the second [N m], shape (T,)."""

    @property
    def forgotten(self) -> float:
        """RMS of what moved at all speeds that did not come again, as a share of the RMS friction there."""
        other = self.speed < SEEN_FROM
        return rms((self.after - self.before)[other]) / rms(self.friction[other])

    @property
    def missed(self) -> float:
        """RMS error at the speeds that came, as a share of the RMS friction there."""
        seen = self.speed >= SEEN_FROM
        return rms((self.after - CHANGE * self.friction)[seen]) / rms(self.friction[seen])


def compare(robot: RobotDescription, rng: np.random.Generator, n_sweeps: int = N_SWEEPS) -> dict[str, Curves]:
    """Run the experiment on a robot with one joint, for `bsn_static` and `mlp_fel`; `rng` draws first weights.

    Raises:
        FFGymError: if the robot has more joints, or torch is missing.
    """
    if robot.n_joints != 1:
        raise FFGymError(f"Robot {robot.name!r} has {robot.n_joints} joints; the experiment is for one: 'one_axis'.")
    friction = StaticLuGre(robot.friction).at_speed
    speed = np.linspace(-TOP_SPEED, TOP_SPEED, 4 * N_SAMPLES)[:, None]
    still = np.zeros_like(speed)  # so slow that there is no acceleration to speak of
    perceptron = MLP.untrained(robot, rng)
    for _ in range(N_UPDATES):
        perceptron = perceptron.fit_to(speed, still, friction(speed))
    first: dict[str, StaticBSN | MLP] = {"bsn_static": StaticBSN.zero(1).with_curve(friction), "mlp_fel": perceptron}
    up = np.linspace(SEEN_FROM, TOP_SPEED, N_SAMPLES)[:, None]
    sweeps = np.concatenate([up if i % 2 == 0 else up[::-1] for i in range(n_sweeps)])
    second = {name: _in_order(network, sweeps, CHANGE * friction(sweeps)) for name, network in first.items()}
    return {
        name: Curves(
            speed=speed[:, 0],
            friction=friction(speed)[:, 0],
            before=first[name].torque_at(speed, still)[:, 0],
            after=second[name].torque_at(speed, still)[:, 0],
        )
        for name in first
    }


def _in_order(network: StaticBSN | MLP, motor_dq: Array, wanted: Array) -> StaticBSN | MLP:
    """A network of one motor after samples (T, 1) one by one, thesis (3.15)."""
    still = np.zeros_like(motor_dq)
    if isinstance(network, MLP):
        return network.adapt_in_order(motor_dq, still, wanted, MLP_RATE)
    values, places = network.active(motor_dq, still)
    weights = network.coefficients.ravel().copy()
    for mu, at, torque in zip(values[:, 0], places[:, 0], wanted[:, 0], strict=True):
        weights[at] += SPLINE_RATE * (torque - (mu * weights[at]).sum()) * mu
    return network.with_weights({"coefficients": weights.reshape(network.coefficients.shape)})


def forgetting_figure(results: Mapping[str, Curves]) -> "Figure":
    """One panel per network: torque before and after, over motor speed; speeds that came again are shaded."""
    with panels(1, len(results), size=(4.2 * len(results), 3.2), sharey=True) as (figure, grid):
        for axes, (name, curves) in zip(grid[0], results.items(), strict=True):
            axes.axvspan(SEEN_FROM, float(curves.speed[-1]), color="#eeeeee")
            axes.plot(curves.speed, curves.before, color="#888888", label="all speeds learned")
            axes.plot(curves.speed, curves.after, color="#c0392b", label="after the shaded speeds alone")
            axes.set_title(name)
            axes.set_xlabel("motor speed [rad/s]")
        grid[0, 0].set_ylabel("torque [N m]")
    return figure


@dataclass(frozen=True)
class Forgetting:
    """Compare a B-spline network and a perceptron."""

    out: Path = Path("forgetting.png")
    """Figure to write: .png, .svg or .pdf."""
    seed: int = 0
    """Seed of the perceptron's first weights."""


def main(config: Forgetting) -> None:
    """Run the experiment, write the figure, print the numbers."""
    results = compare(load_robot("one_axis"), np.random.default_rng(config.seed))
    save_figure(forgetting_figure(results), config.out)
    for name, curves in results.items():
        print(f"{name:12s} forgotten {curves.forgotten:7.2%}   missed {curves.missed:7.2%}")
    print(f"figure: {config.out}")


if __name__ == "__main__":
    import tyro

    main(tyro.cli(Forgetting))
