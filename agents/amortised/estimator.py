r"""Amortised estimator: numbers of a machine from one lap of a circle, and feed-forward with them.

Idea: identification by simulation asks which numbers of a model make it move as the machine does, and searches for
them, machine by machine. Here the search is done once, beforehand: many machines are drawn around the nominal robot
(`ffgym.agents.amortised.draws`), each runs one lap under elastic feed-forward with nominal numbers, and a network
learns to read the numbers from the recording. On a machine that nobody has seen it takes one lap and a millisecond.

The network sees the difference d between signals of the machine and those that the nominal machine shows in simulation
on the same lap: feedback torques, and in one variant the way of the tool as a laser tracker sees it. With components V
of the differences in training, their spread s, and a network N with two outputs for each number,

.. math:: x = V d / s, \quad \mu = A x + b + N_\mu(x), \quad \log \sigma = N_\sigma(x)

The recurrent variant reads the rows of d in their order instead: N is a long short-term memory, whose output after the
last row takes the place of x in N, and which is trained as the student of a teacher that knows the true numbers: to
move the tool as the teacher's law does, to first order (`scripts.train_estimator`).

The mean is corrected once by simulating the machine that it describes (`Estimator.correct`), and goes into
`ffgym.agents.model.model_law`. Further laps run under the law so far, and correct the numbers in the same way. Where a
lap does not tell a number, the mean of the Gaussian is that of the draws, which is the nominal number for all factors.
Where d is no larger than the noise, the nominal numbers stay, and the law is the base law to the bit.

Source: Papamakarios and Murray (2016), Fast epsilon-free inference of simulation models with Bayesian conditional
density estimation, NeurIPS: a network with a density as output, trained on simulated pairs. Departures: one Gaussian
with a diagonal covariance; a linear part by ridge regression beside the network; components of signals as features;
the correction.

Run it:

    python -m scripts.train_estimator
    python -m scripts.adaptation

Logged by the training: the likelihood, and the share of each number's variance that is explained on draws left out.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Self

import numpy as np

from ffgym.agents.amortised.numbers import machine_with
from ffgym.agents.elastic import elastic_law
from ffgym.agents.law_files import pack, unpack
from ffgym.agents.model import model_law
from ffgym.agents.residual.actor import ACTIVATIONS, LSTM, LinearLayer
from ffgym.agents.task_torques import MotionTorque, TaskTorques
from ffgym.control import FeedForwardLaw
from ffgym.core.errors import FFGymError, check_choice, check_shape
from ffgym.core.files import write_bytes
from ffgym.core.types import Array
from ffgym.leaderboard.adaptation.protocol import AdaptationSetting, lap
from ffgym.logs.preparation import read_motor_torque
from ffgym.paths import Reference
from ffgym.recordings import Recording
from ffgym.recordings.metrics.path_error import standstill_offset
from ffgym.robot import RigidArm
from ffgym.simulation import Run, simulate

KIND = "amortised_estimator"
"""Kind of the files of estimators."""
VARIANTS = ("tracker", "motors", "recurrent")
"""Estimators: of feedback torques and the tool's way; of feedback torques alone; of these by a recurrent network."""
ROWS = 16
"""Rows of a recording of 1 kHz in one row of the signals, which is their mean; chosen: 16 ms, a tenth of the shortest
feature of friction on the lap."""
TORQUE_NOISE = 0.005
"""Unit of feedback torques [N m]; chosen: differences below it are taken for noise."""
TOOL_NOISE = 3e-6
"""Unit of the tool's way [m]: a tracker's noise of 10 um in the mean of 16 rows, rounded up."""
SILENT = 1.25
"""RMS of the difference in these units up to which the nominal numbers stay: a quarter above that of the noise of the
built-in sensors, 0.98, and at most 1.06 in 40 laps of the nominal machine. Drawn workcells show 18 and more."""


def read_signals(recording: Recording, arm: RigidArm) -> Array:
    """Read the signals of a lap in units of their noise, shape (T, N + 3): feedback torques, then the tool's way.

    Both count from the first standstill, whose gravity is no property of the lap.

    Raises:
        FFGymError: if the recording lacks feedback torques, the tool, or a standstill at its start.
    """
    rest = recording.during(recording.phases_of("standstill")[0])
    torque = read_motor_torque(arm.robot, recording, "feedback.effort")
    torque = (torque - torque[rest][len(torque[rest]) // 2 :].mean(axis=0)) / TORQUE_NOISE
    way = recording.vector("tcp.position") - recording.vector("tcp_reference.position")
    way = (way - standstill_offset(recording)) / TOOL_NOISE
    whole = len(torque) // ROWS * ROWS
    signals = np.concatenate([torque, way], axis=1)[:whole]
    return np.asarray(np.nanmean(signals.reshape(-1, ROWS, signals.shape[1]), axis=1))


@lru_cache(maxsize=8)
def nominal_signals(arm: RigidArm) -> Array:
    """Compute the signals that the nominal machine shows on the lap under the base law, without noise."""
    run = Run(reference=lap(arm), law=elastic_law(arm))
    return read_signals(simulate([run], arm=arm, n_threads=1)[0], arm)


@dataclass(frozen=True, kw_only=True, eq=False)
class MachineEstimate:
    """Numbers of a machine as an estimator finds them, in the layout of `ffgym.agents.amortised.numbers`."""

    mean: Array
    """Shape (K,)."""
    deviation: Array
    """Standard deviation that the estimator claims, shape (K,)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Estimator:
    """Linear map and network from the differences of signals to numbers, see the head of this file."""

    variant: str
    """Key of VARIANTS."""
    components: Array
    """V, shape (D, T C) for T rows of C channels."""
    spread: Array
    """Spread s of each component in training, shape (D,), > 0."""
    linear: LinearLayer
    """A and b, D inputs and K outputs."""
    layers: tuple[LinearLayer, ...]
    """Layers of the network: D inputs, or the cells of the LSTM; 2 K outputs; all but the last are followed by ReLU."""
    lstm: LSTM | None = None
    """LSTM that reads the rows of the signals in front of the layers; only the variant 'recurrent' has one."""

    def __post_init__(self) -> None:
        check_choice("variant of an estimator", self.variant, list(VARIANTS))
        d, _ = check_shape("components", self.components, (None, None)).shape
        if np.any(check_shape("spread", self.spread, (d,)) <= 0):
            raise FFGymError(f"spread = {self.spread} of an estimator must be > 0.")
        numbers, width = self.linear.weight.shape
        ends = [width, *(layer.weight.shape[1] for layer in self.layers[:1]), self.layers[-1].weight.shape[0] // 2]
        if ends != [d, d if self.lstm is None else self.lstm.cells, numbers]:
            raise FFGymError(f"Layers with {ends} inputs and outputs do not fit {d} components and {numbers} numbers.")

    def estimate(self, difference: Array) -> MachineEstimate:
        """Estimate the numbers of a machine from the difference of its signals to the nominal ones, (T, N + 3)."""
        h = x = self.features(difference)
        if self.lstm is not None:
            state = np.zeros((2, self.lstm.cells))
            for row in select_channels(difference, self.variant):
                h, state = self.lstm.step(row, state)
        for layer in self.layers[:-1]:
            h = ACTIVATIONS["relu"](layer(h))
        mean, log_deviation = np.split(self.layers[-1](h), 2)
        return MachineEstimate(mean=self.linear(x) + mean, deviation=np.exp(log_deviation))

    def features(self, difference: Array) -> Array:
        """Compute the components of a difference of signals (T, N + 3) in units of their spread, shape (D,).

        Raises:
            FFGymError: if the signals are of another motion or robot than those of the training.
        """
        seen = select_channels(difference, self.variant).ravel()
        if seen.shape != self.components.shape[1:]:
            raise FFGymError(
                f"The lap has {seen.size} signals, the estimator was trained on {self.components.shape[1]}: another "
                f"motion, or another robot. Train one for this robot: python -m scripts.train_estimator."
            )
        return np.asarray(self.components @ seen / self.spread)

    def correct(self, numbers: Array, seen: Array, law: FeedForwardLaw, arm: RigidArm) -> Array:
        """Correct numbers of a machine, (K,), by a lap under a law: simulate it, and estimate from what is left.

        A step of Gauss and Newton in simulation, whose slopes are those of the linear part: what the network takes for
        linear, and the noise of other machines, is then right at these numbers. It costs no motion.
        """
        machine = machine_with(arm.robot, numbers)
        run = [Run(reference=lap(arm), law=law)]
        expected = read_signals(simulate(run, arm=arm, machine=machine, n_threads=1)[0], arm)
        return numbers + self.linear.weight @ self.features(seen - expected)

    # As parts of a file

    def save(self, path: Path, meta: Mapping[str, Any]) -> None:
        """Write the estimator in float32, components in float16, with how it was trained."""
        named = {"linear": self.linear} | {f"layer_{k}": layer for k, layer in enumerate(self.layers)}
        if self.lstm is not None:
            named |= {"lstm_inputs": self.lstm.inputs, "lstm_hidden": self.lstm.hidden}
        arrays = {
            f"{name}_{part}": getattr(layer, part) for name, layer in named.items() for part in ("weight", "bias")
        }
        arrays |= {"components": self.components, "spread": self.spread}
        header = {"format": 1, "kind": KIND, "variant": self.variant, "layers": len(self.layers), "meta": dict(meta)}
        kinds = {"components": np.float16}
        write_bytes(path, pack(header, {name: v.astype(kinds.get(name, np.float32)) for name, v in arrays.items()}))

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read an estimator.

        Raises:
            FFGymError: if the file is missing, damaged, or holds something else.
        """
        header, arrays = unpack(path)
        if header.get("kind") != KIND:
            raise FFGymError(f"{path}: is a file of kind {header.get('kind')!r}, an estimator's is {KIND!r}.")
        try:
            for name, values in arrays.items():
                if values.dtype.kind == "f" and not np.all(np.isfinite(values)):
                    raise FFGymError(f"{name} must be finite")
            arrays = {name: values.astype(np.float64) for name, values in arrays.items()}

            def layer(name: str) -> LinearLayer:
                return LinearLayer(weight=arrays[f"{name}_weight"], bias=arrays[f"{name}_bias"])

            layers = tuple(layer(f"layer_{k}") for k in range(header["layers"]))
            recurrent = "lstm_inputs_weight" in arrays
            lstm = LSTM(inputs=layer("lstm_inputs"), hidden=layer("lstm_hidden")) if recurrent else None
            components, spread = arrays["components"], arrays["spread"]
            own = {"variant": header["variant"], "components": components, "spread": spread}
            return cls(linear=layer("linear"), layers=layers, lstm=lstm, **own)
        except (KeyError, TypeError, ValueError, IndexError, FFGymError) as error:
            raise FFGymError(f"{path}: holds no complete estimator: {error}. Train it again.") from error


def select_channels(signals: Array, variant: str) -> Array:
    """Select the signals (..., N + 3) that a variant sees."""
    return signals if variant == "tracker" else signals[..., :-3]


def adapt(estimator: Estimator, setting: AdaptationSetting, name: str) -> FeedForwardLaw:
    """Run laps as the budget allows, the first under the base law, each further one under the law of those before.

    The first lap gives an estimate; every lap corrects it (`Estimator.correct`). Where the first lap differs from that
    of the nominal machine by no more than noise, the base law stays, and no further lap is run.
    """
    arm, reference, trial = setting.arm, lap(setting.arm), setting.trial
    law: FeedForwardLaw = elastic_law(arm, name=name)
    numbers: Array | None = None
    for number in range(int((trial.left + 1e-9) / reference.duration)):
        torque = fix_torque(law, reference)
        seen = read_signals(trial([Run(reference=reference, law=torque)], number)[0], arm)
        if numbers is None:
            difference = seen - nominal_signals(arm)
            if is_silent(difference, estimator.variant):
                break
            numbers = estimator.estimate(difference).mean
        numbers = estimator.correct(numbers, seen, torque, arm)
        law = model_law(machine_with(arm.robot, numbers), arm, name)
    return law


def fix_torque(law: FeedForwardLaw, reference: Reference) -> TaskTorques:
    """Compute the torque of a law along one motion, for several runs of it."""
    torque = law.torque(reference)
    return TaskTorques(tasks=(MotionTorque(name=reference.name, q=reference.q, torque=torque),), name=law.name)


def is_silent(difference: Array, variant: str) -> bool:
    """Tell if a difference to the nominal signals is no larger than the noise of sensors leaves it."""
    return bool(np.sqrt(np.mean(select_channels(difference, variant) ** 2)) <= SILENT)
