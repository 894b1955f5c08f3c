"""Amortised estimators, trained on drawn machines in simulation: `python -m scripts.train_estimator`.

First the draws run one lap each, in chunks that are kept; then every variant and seed is trained on them (PyTorch). A
seed decides which draws are left out for validation, first weights, noise and the order of batches. Logged at the end
of each: the share of variance that is explained on the draws left out, by group of numbers.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import torch

from ffgym.agents.amortised.draws import draw_machine
from ffgym.agents.amortised.estimator import (
    VARIANTS,
    Estimator,
    fix_torque,
    nominal_signals,
    read_signals,
    select_channels,
)
from ffgym.agents.amortised.numbers import machine_with, numbers_of, split
from ffgym.agents.artefacts import ANYWHERE, TRAINED, add_artefacts, describe_artefact
from ffgym.agents.elastic import elastic_law
from ffgym.agents.residual.actor import LSTM, LinearLayer
from ffgym.agents.torque_response import task_error
from ffgym.core.files import decode_arrays, encode_arrays, filled_folder, made_folder, write_bytes
from ffgym.core.types import Array, IntArray
from ffgym.leaderboard.adaptation.protocol import LAP, lap, practice_motion
from ffgym.paths import SPEEDS
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation import Rig, Run, simulate

COMMAND = "python -m scripts.train_estimator"
_LEAST_MOVED = 1e-3
"""Floor under the logarithm of the tool's mean square distance from that of the teacher, in parts of what the spread of
machines does; chosen: 3 % of the way, below which other errors rule."""
_LIKELIHOOD = 0.1
"""Weight of the likelihood beside it, which keeps numbers that move no tool at their mean."""
NAMES = {"tracker": "amortised", "motors": "amortised_motors", "recurrent": "amortised_recurrent"}
"""Names of the artefacts by variant."""


@dataclass(frozen=True)
class Config:
    """Estimators to train."""

    robot: str = "irb4600_60_205_commissioned_arm_drives"
    """Nominal robot that machines are drawn around."""
    draws: int = 5120
    """Machines; those of other counts begin with the same ones."""
    chunk: int = 256
    """Machines that are simulated side by side, and kept in one file."""
    draw_seed: int = 1
    """Seed of the draws."""
    variants: tuple[str, ...] = VARIANTS
    seeds: tuple[int, ...] = (0, 1, 2, 3, 4)
    """Seeds of the training."""
    components: int = 150
    """Largest number of components of the signals."""
    noise: float = 4.0
    """Noise added to the signals in training, in units of that of sensors; more makes up for what no draw has. Chosen
    on workcells drives-1 to drives-6, which are no part of a round."""
    hidden: tuple[int, ...] = (128, 128)
    """Widths of the network."""
    cells: int = 64
    """Cells of the LSTM of the recurrent variant."""
    epochs: int = 60
    """Passes over the draws; the network of the least validation loss is kept."""
    threads: int = 0
    """Threads of the engine, 0 for all cores."""
    work: Path = Path("out/estimator")
    """Folder of the simulated laps."""
    out: Path = TRAINED
    """Folder of the artefacts."""


def main(config: Config) -> None:
    """Simulate what is missing, train, write."""
    arm = RigidArm(load_robot(config.robot))
    signals, numbers = (np.concatenate(parts) for parts in zip(*simulate_draws(config, arm), strict=True))
    signals = signals[: config.draws] - nominal_signals(arm)
    for variant in config.variants:
        name, entries = NAMES[variant], []
        with filled_folder(config.out / name / ANYWHERE):
            pass
        for seed in config.seeds:
            metric = teacher_metric(arm, numbers.std(axis=0)) if variant == "recurrent" else None
            estimator, explained = train(config, select_channels(signals, variant), numbers, variant, seed, metric)
            print(name, seed, *(f"{group} {share:.2f}" for group, share in explained.items()), flush=True)
            file = f"{ANYWHERE}/seed_{seed}.npz"
            meta = {"command": COMMAND, "seed": seed, "robot": config.robot, "explained": explained}
            estimator.save(config.out / name / file, meta)
            what = {"seed": seed, "plant": ANYWHERE, "fingerprint": Rig(arm=arm).fingerprint, "robot_seconds": 0.0}
            steps = config.draws * (len(lap(arm).t) - 1)
            entries.append(describe_artefact(name, file, config.out, env_steps=steps, **what))
        add_artefacts(name, COMMAND, entries, config.out)


def simulate_draws(config: Config, arm: RigidArm) -> Iterator[tuple[Array, Array]]:
    """Yield signals (B, T, N + 3) and numbers (B, K) of the machines of each chunk, simulated if no file has them."""
    reference = lap(arm)
    law = fix_torque(elastic_law(arm), reference)
    rng = np.random.default_rng(config.draw_seed)
    for start in range(0, config.draws, config.chunk):
        # draws come from one generator in a row, also those that are not simulated again
        machines = [draw_machine(arm.robot, rng) for _ in range(config.chunk)]
        file = config.work / f"{config.robot}_{config.draw_seed}" / f"{start}.npz"
        if not file.exists():
            runs = [Run(reference=reference, law=law)] * len(machines)
            recordings = simulate(runs, arm=arm, machine=machines, n_threads=config.threads)
            arrays = {
                "signals": np.array([read_signals(each, arm) for each in recordings], dtype=np.float32),
                "numbers": np.array([numbers_of(machine, arm.robot) for machine in machines], dtype=np.float32),
            }
            with made_folder(file.parent):
                write_bytes(file, encode_arrays(arrays))
            print(f"draws {start} to {start + config.chunk}", flush=True)
        arrays = decode_arrays(file.read_bytes())
        yield arrays["signals"].astype(np.float64), arrays["numbers"].astype(np.float64)


@lru_cache(maxsize=2)
def _tool_by_number(arm: RigidArm, steps: tuple[float, ...]) -> Array:
    """Compute how far the tool moves if a number of the machine grows by a step, (M, K, T), on M laps of practice."""
    machines = [machine_with(arm.robot, row) for row in (np.zeros(len(steps)), *np.diag(steps))]
    found = []
    for speed in SPEEDS:
        motion = practice_motion(arm, LAP[0], speed)
        runs = [Run(reference=motion, law=fix_torque(elastic_law(arm), motion))] * len(machines)
        ways = [task_error(each, motion, "tcp").ravel() for each in simulate(runs, arm=arm, machine=machines)]
        found.append(np.array(ways[1:]) - ways[0])
    longest = max(each.shape[1] for each in found)
    return np.stack([np.pad(each, ((0, 0), (0, longest - each.shape[1]))) for each in found])


def teacher_metric(arm: RigidArm, spread: Array) -> Array:
    """Compute the matrix M (K, K) by which wrong numbers move the tool, in units of their spread (K,).

    The teacher is the law with the true numbers. A student whose numbers differ from them by d moves the tool by J d,
    to first order; d' M d is the mean of its square over motions, each in parts of what the spread of all numbers does.
    """
    slopes = _tool_by_number(arm, tuple(np.where(spread > 0, spread, 0.0).tolist()))
    squares = np.einsum("mkt,mlt->mkl", slopes, slopes)
    return np.asarray((squares / np.trace(squares, axis1=1, axis2=2)[:, None, None]).mean(axis=0))


def train(
    config: Config, signals: Array, numbers: Array, variant: str, seed: int, metric: Array | None = None
) -> tuple[Estimator, dict[str, float]]:
    """Train one estimator; return it, and the explained share of variance on the draws left out, by group.

    Args:
        config: the options.
        signals: differences to the nominal machine (B, T, C).
        numbers: numbers of the machines (B, K).
        variant: key of `VARIANTS`.
        seed: of the draws left out, weights, noise and batches.
        metric: that of `teacher_metric` for a recurrent estimator, which is trained by it.
    """
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(signals))
    held, rows = order[: len(order) // 10], order[len(order) // 10 :]
    # components of the signals, and numbers in units of their spread
    flat = signals.reshape(len(signals), -1)
    _, sizes, components = np.linalg.svd(flat[rows], full_matrices=False)
    spread = sizes / np.sqrt(len(rows))
    kept = min(config.components, int((spread > config.noise).sum()))
    components, spread = components[:kept], spread[:kept]
    x = flat @ components.T / spread
    middle, size = numbers[rows].mean(axis=0), numbers[rows].std(axis=0)
    size = np.where(size > 0, size, 1.0)
    y = (numbers - middle) / size
    # linear part: ridge regression under the noise that training adds
    damping = np.diag((config.noise / spread) ** 2) * len(rows)
    slope = np.linalg.solve(x[rows].T @ x[rows] + damping, x[rows].T @ y[rows]).T
    lstm = None
    if metric is None:
        network = _fit(config, x, y, slope, config.noise / spread, rows, held, seed)
    else:
        lstm, network = _fit_recurrent(
            config, signals, y, slope @ (components / spread[:, None]), metric, rows, held, seed
        )
    # in the units of the numbers: the mean beside the linear part, the logarithm of the deviation
    last, k = network[-1], y.shape[1]
    weight, bias = last.weight.copy(), last.bias.copy()
    weight[:k], bias[:k] = weight[:k] * size[:, None], bias[:k] * size
    bias[k:] += np.log(size)
    estimator = Estimator(
        variant=variant,
        components=components,
        spread=spread,
        linear=LinearLayer(weight=slope * size[:, None], bias=middle),
        layers=(*network[:-1], LinearLayer(weight=weight, bias=bias)),
        lstm=lstm,
    )
    return estimator, _explained(estimator, signals[held], numbers[held])


def _fit(
    config: Config, x: Array, y: Array, slope: Array, noise: Array, rows: IntArray, held: IntArray, seed: int
) -> list[LinearLayer]:
    """Fit mean, beside the linear part, and log deviation of y to x by the likelihood of a Gaussian; return layers."""
    torch.manual_seed(seed)
    widths = [x.shape[1], *config.hidden]
    layers: list[torch.nn.Module] = []
    for inputs, outputs in pairwise(widths):
        layers += [torch.nn.Linear(inputs, outputs), torch.nn.ReLU()]
    last = torch.nn.Linear(widths[-1], 2 * y.shape[1])
    torch.nn.init.zeros_(last.weight)
    torch.nn.init.zeros_(last.bias)
    model = torch.nn.Sequential(*layers, last)
    features, targets, linear_part, size = (torch.as_tensor(each, dtype=torch.float32) for each in (x, y, slope, noise))
    train_rows, held_rows = torch.as_tensor(rows), torch.as_tensor(held)

    def loss_of(batch: torch.Tensor) -> torch.Tensor:
        seen = features[batch] + size * torch.randn(len(batch), len(size))
        mean, log_deviation = model(seen).chunk(2, dim=1)
        error = targets[batch] - seen @ linear_part.T - mean
        return (0.5 * (error / log_deviation.exp()) ** 2 + log_deviation).mean()

    _optimise(config, model, loss_of, train_rows, held_rows)
    return [_layer(layer) for layer in model if isinstance(layer, torch.nn.Linear)]


def _optimise(
    config: Config,
    model: torch.nn.Module,
    loss_of: Callable[[torch.Tensor], torch.Tensor],
    train_rows: torch.Tensor,
    held_rows: torch.Tensor,
) -> None:
    """Minimise a loss over rows of the training by AdamW; keep the weights of the least loss on rows left out."""
    optimiser = torch.optim.AdamW(model.parameters(), lr=1e-3, weight_decay=1e-2)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, config.epochs)
    best, least = {name: value.clone() for name, value in model.state_dict().items()}, np.inf
    for _ in range(config.epochs):
        model.train()
        for batch in train_rows[torch.randperm(len(train_rows))].split(64):
            optimiser.zero_grad()
            loss_of(batch).backward()
            optimiser.step()
        schedule.step()
        with torch.no_grad():
            now = float(loss_of(held_rows))
        if now < least:
            best, least = {name: value.clone() for name, value in model.state_dict().items()}, now
    model.load_state_dict(best)


def _layer(layer: torch.nn.Linear) -> LinearLayer:
    """Return a layer of torch in numpy."""
    weight, bias = (each.detach().numpy().astype(np.float64) for each in (layer.weight, layer.bias))
    return LinearLayer(weight=weight, bias=bias)


class _Student(torch.nn.Module):
    """LSTM over the rows of a lap, and a linear layer on its last output that begins with zero."""

    def __init__(self, channels: int, cells: int, outputs: int) -> None:
        super().__init__()
        self.lstm = torch.nn.LSTM(channels, cells, batch_first=True)
        self.last = torch.nn.Linear(cells, outputs)
        torch.nn.init.zeros_(self.last.weight)
        torch.nn.init.zeros_(self.last.bias)

    def forward(self, rows: torch.Tensor) -> torch.Tensor:
        """Compute outputs (B, O) of rows (B, T, C)."""
        out: torch.Tensor = self.last(self.lstm(rows)[0][:, -1])
        return out


def _fit_recurrent(
    config: Config,
    signals: Array,
    y: Array,
    slope: Array,
    metric: Array,
    rows: IntArray,
    held: IntArray,
    seed: int,
) -> tuple[LSTM, list[LinearLayer]]:
    """Fit an LSTM to y, beside the linear part of slope (K, T C), so that the tool goes as under the teacher's law."""
    torch.manual_seed(seed)
    unit = signals[rows].std(axis=(0, 1))
    model = _Student(signals.shape[2], config.cells, 2 * y.shape[1])
    seen, targets, linear_part, size, weight = (
        torch.as_tensor(each, dtype=torch.float32) for each in (signals, y, slope, unit, metric)
    )
    train_rows, held_rows = torch.as_tensor(rows), torch.as_tensor(held)

    def loss_of(batch: torch.Tensor) -> torch.Tensor:
        noisy = seen[batch] + config.noise * torch.randn(seen[batch].shape)
        mean, log_deviation = model(noisy / size).chunk(2, dim=1)
        error = targets[batch] - noisy.flatten(1) @ linear_part.T - mean
        moved = torch.einsum("bk,kl,bl->b", error, weight, error)
        likelihood = 0.5 * (error / log_deviation.exp()) ** 2 + log_deviation
        return 0.5 * (moved + _LEAST_MOVED).log().mean() + _LIKELIHOOD * likelihood.mean()

    _optimise(config, model, loss_of, train_rows, held_rows)
    weights = {name: value.detach().numpy().astype(np.float64) for name, value in model.lstm.named_parameters()}
    lstm = LSTM(
        inputs=LinearLayer(weight=weights["weight_ih_l0"] / unit, bias=weights["bias_ih_l0"]),
        hidden=LinearLayer(weight=weights["weight_hh_l0"], bias=weights["bias_hh_l0"]),
    )
    return lstm, [_layer(model.last)]


def _explained(estimator: Estimator, signals: Array, numbers: Array) -> dict[str, float]:
    """Compute the mean share of variance explained, by group of numbers; one that does not vary counts as 1."""
    if estimator.variant != "tracker":
        signals = np.concatenate([signals, np.zeros((*signals.shape[:2], 3))], axis=2)
    found = np.array([estimator.estimate(each).mean for each in signals])
    variance = numbers.var(axis=0)
    left = ((found - numbers) ** 2).mean(axis=0)
    share = 1 - np.divide(left, variance, where=variance > 0, out=np.zeros_like(variance))
    n = signals.shape[2] - 3
    return {name: round(float(np.mean(part)), 3) for name, part in split(share, n).items()}


if __name__ == "__main__":
    import tyro

    main(tyro.cli(Config))
