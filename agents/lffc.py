"""Learning feed-forward control: a network adapted after every trial by the torque that the feedback still gave.

Idea and source: thesis 5.2 and (5.5)-(5.7). The torque that feedback adds along a motion is torque that feed-forward
lacked. After each trial the network learns it as a function of the reference, and the next trial runs with the result.

    trial 0         the network as given; with zero weights, no compensation
    trial k         the network after k updates, each `network.adapt(lessons, rate)`; (5.5) for B-spline networks

Run it:

    ffgym train bspline --network extended --out network.npz
    ffgym train bspline --network extended --speeds-mm-s 10 40 100 --prior --out wide.npz

Logged, per trial k, motion m and joint, over all samples but standstill (5.6):

    error[k, m]         mean square of the motor position error e_p [rad^2]
    signal[k, m]        mean square of the learning signal z: u_p = u_c - u_I, u_c, or K_p e_p [(N m)^2]
    relative(x)[k]      mean over the motions of x[k, m] / x[0, m]: the normalised mean square of thesis Figure 5.10

A joint is done when the change from trial to trial (5.7) of the relative mean squares shows it: when error and signal
did not both fall by more than `tolerance`, `patience` trials in a row. Its weights are then locked to those of its
lowest relative error so far, and the law that comes out has the weights of the lowest on every joint.

Departures from the source: the last update is tried as well, so that n iterations are n + 1 trials and no weights come
out that were not tried, if not all in one trial: joints whose lowest errors lie in different trials never ran together
as they come out; `patience`, since one bad trial does not make a trend; several motions can be learned from at
once, each counting alike however large its errors; z = e_p is multiplied by K_p, so that it is a torque and the rate
means the same.
"""

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

import numpy as np

from ffgym.agents.law_files import StateFile, StoredLaw, digest
from ffgym.agents.trials import SIGNALS, Lesson, Signal, Trial, run_trial
from ffgym.control import CausalLaw
from ffgym.core.errors import FFGymError, check_choice, check_number, check_shape, check_whole
from ffgym.core.types import Array, BoolArray, IntArray
from ffgym.paths import Reference
from ffgym.simulation import Run


class Network(CausalLaw, StoredLaw):
    """A law that learns from trials. A network is never changed: learning returns a new one."""

    @property
    @abstractmethod
    def weights(self) -> dict[str, Array]:
        """Learned numbers by name; the first axis of each counts joints, shape (N, ...)."""

    def with_weights(self, weights: Mapping[str, Array]) -> Self:
        """Return the network with other weights."""
        return replace(self, **weights)  # type: ignore[type-var]

    @abstractmethod
    def adapt(self, lessons: Sequence[Lesson], rate: float) -> Self:
        """Return the network after one update from the lessons of one trial, at learning rate `rate`."""

    def merge(self, other: Self, joints: BoolArray) -> Self:
        """Return this network with the weights of `other` on `joints` (N,)."""
        theirs, mixed = other.weights, {}
        for name, own in self.weights.items():
            mixed[name] = np.where(joints.reshape(-1, *[1] * (own.ndim - 1)), theirs[name], own)
        return self.with_weights(mixed)


@dataclass(frozen=True, kw_only=True, eq=False)
class Learning:
    """Learning after K trials; every trial makes a new one."""

    network: Network
    """Network of the next trial."""
    best: Network
    """Network with the weights of the lowest mean square error on each joint."""
    error: Array
    """Mean square motor position error of each trial and motion [rad^2], shape (K, M, N), thesis (5.6)."""
    signal: Array
    """Mean square of the learning signal of each trial and motion [(N m)^2], shape (K, M, N)."""
    best_trial: IntArray
    """Trial whose weights `best` has, shape (N,)."""
    stale: IntArray
    """Trials in a row that did not improve, shape (N,)."""
    locked: BoolArray
    """Joints that are done and keep their best weights, shape (N,)."""

    @classmethod
    def begin(cls, network: Network, n_motions: int) -> "Learning":
        """Begin before the first trial with M motions."""
        n = network.n_joints
        return cls(
            network=network,
            best=network,
            error=np.zeros((0, n_motions, n)),
            signal=np.zeros((0, n_motions, n)),
            best_trial=np.zeros(n, dtype=np.intp),
            stale=np.zeros(n, dtype=np.intp),
            locked=np.zeros(n, dtype=np.bool_),
        )

    @property
    def trials(self) -> int:
        """Number of trials K."""
        return len(self.error)

    def after(self, lessons: Sequence[Lesson], *, rate: float, tolerance: float, patience: int) -> "Learning":
        """Learn from the `lessons` of a trial of `network`, by the rule in the head of this file."""
        error = np.concatenate([self.error, [[_mean_square(lesson, lesson.error) for lesson in lessons]]])
        signal = np.concatenate([self.signal, [[_mean_square(lesson, lesson.signal) for lesson in lessons]]])
        cost = relative(error)
        # joints with their lowest error so far, and joints that no longer improve
        is_best = ~self.locked & (cost[-1] <= cost.min(axis=0))
        best = self.best.merge(self.network, is_best)
        stale = np.where(_fell(cost, tolerance) & _fell(relative(signal), tolerance), 0, self.stale + 1)
        locked = self.locked | (stale >= patience)
        return Learning(
            network=self.network.adapt(lessons, rate).merge(best, locked),
            best=best,
            error=error,
            signal=signal,
            best_trial=np.where(is_best, self.trials, self.best_trial),
            stale=stale,
            locked=locked,
        )


def relative(mean_square: Array) -> Array:
    """Divide mean squares (K, M, N) by those of the first trial, and average over motions, shape (K, N).

    A joint whose first is 0, as one that never moves, gets 0.
    """
    first = mean_square[:1]
    return np.asarray(np.divide(mean_square, first, out=np.zeros_like(mean_square), where=first > 0).mean(axis=1))


def _mean_square(lesson: Lesson, values: Array) -> Array:
    """Compute the mean square of values (T, N) of a lesson without standstill, shape (N,)."""
    return np.asarray(np.mean(values[lesson.moving] ** 2, axis=0))


def _fell(history: Array, tolerance: float) -> BoolArray:
    """Find joints whose last row of `history` (K, N) fell by more than a share of the one before, thesis (5.7)."""
    if len(history) < 2:
        return np.ones(history.shape[1], dtype=np.bool_)
    return np.asarray(history[-1] < (1 - tolerance) * history[-2])


_ROWS = ("error", "signal", "best_trial", "stale", "locked")
_NETWORKS = ("network", "best")


def _restore_learning(first: Network, n_motions: int, arrays: Mapping[str, Array]) -> Learning:
    """Rebuild learning from the arrays of a state file."""
    n = first.n_joints
    network, best = (
        first.with_weights({name: arrays[f"{role}.{name}"] for name in first.weights}) for role in _NETWORKS
    )
    error = check_shape("error", arrays["error"], (None, n_motions, n))
    signal = check_shape("signal", arrays["signal"], error.shape)
    best_trial, stale, locked = (check_shape(name, arrays[name], (n,)) for name in ("best_trial", "stale", "locked"))
    return Learning(
        network=network,
        best=best,
        error=error,
        signal=signal,
        best_trial=best_trial.astype(np.intp),
        stale=stale.astype(np.intp),
        locked=locked.astype(np.bool_),
    )


Watch = Callable[[Learning, int], None]
"""Function that is called after every trial with the state of learning, and the largest number of trials."""


RATES = (1e-9, 1e3)
"""Least and largest learning rate; chosen, far beyond those that learn: sums over a million samples need 1e-6, and a
rate of more than 2 grows."""


def check_rate(name: str, value: Any) -> float:
    """Return `value` as a learning rate."""
    return check_number(name, value, low=RATES[0], high=RATES[1])


@dataclass(frozen=True, kw_only=True)
class LFFC:
    """The training procedure; any `Network` learns by it."""

    rate: float = 0.95
    """Learning rate gamma, thesis 5.3.2; 0.8 on one axis."""
    iterations: int = 10
    """Updates at most, thesis 5.3.2; 15 on one axis."""
    signal: Signal = "u_p"
    """Learning signal z, thesis 5.2.1."""
    tolerance: float = 1e-3
    """Share by which error and signal must fall for a trial to count as better; chosen, the thesis gives no number."""
    patience: int = 2
    """Trials in a row without improvement after which a joint is locked; chosen."""

    def __post_init__(self) -> None:
        check_rate("learning rate gamma", self.rate)
        check_whole("iterations", self.iterations, low=0)
        check_choice("learning signal", self.signal, SIGNALS)
        check_number("tolerance", self.tolerance, low=0.0, high=1.0)
        check_whole("patience", self.patience, low=1)

    def learn(
        self,
        network: Network,
        references: Sequence[Reference],
        trial: Trial,
        *,
        state: Path | None = None,
        machine: str = "",
        watch: Watch | None = None,
    ) -> Learning:
        """Learn from trials along `references`; the learned law is `best` of what is returned.

        Args:
            network: network of the first trial.
            references: motions of each trial.
            trial: procedure that runs them on the machine.
            state: file that is written after every trial; where it exists, learning goes on from there.
            machine: text that identifies the machine, so that a file is not used for another one.
            watch: called after every trial.

        Raises:
            FFGymError: if there is no reference, one is for another robot than the network, or the file belongs to
                other learning or has come further.
        """
        if not references:
            raise FFGymError("There is no motion to learn from; give one or more references.")
        settings = self._settings(network, references, machine)
        file = None if state is None else StateFile(path=state, kind="learning", settings=settings)
        learning = self._begin(network, len(references), file)
        while learning.trials <= self.iterations and not learning.locked.all():
            # one trial of all motions, and the update from it
            runs = [Run(reference=reference, law=learning.network) for reference in references]
            pairs = zip(references, run_trial(trial, runs, learning.trials), strict=True)
            lessons = [Lesson.of(reference, recording, self.signal) for reference, recording in pairs]
            learning = learning.after(lessons, rate=self.rate, tolerance=self.tolerance, patience=self.patience)
            if file is not None:
                weights = {
                    f"{role}.{name}": array
                    for role in _NETWORKS
                    for name, array in getattr(learning, role).weights.items()
                }
                file.write({name: getattr(learning, name) for name in _ROWS} | weights)
            if watch is not None:
                watch(learning, self.iterations + 1)
        return learning

    def _begin(self, network: Network, n_motions: int, file: StateFile | None) -> Learning:
        arrays = None if file is None else file.read()
        if file is None or arrays is None:
            return Learning.begin(network, n_motions)
        try:
            learning = _restore_learning(network, n_motions, arrays)
        except (KeyError, FFGymError) as error:
            reason = str(error).rstrip(".")
            raise FFGymError(
                f"{file.path}: holds no complete learning: {reason}. Begin anew with another file."
            ) from error
        if learning.trials > self.iterations + 1:
            raise FFGymError(
                f"{file.path}: has {learning.trials - 1} iterations already, more than the {self.iterations} asked "
                f"for; ask for as many or more, or begin anew with another file."
            )
        return learning

    def _settings(self, network: Network, references: Sequence[Reference], machine: str) -> dict[str, Any]:
        """Return the settings that must not change while learning; iterations may be added later."""
        settings, arrays = network.parts()
        return {
            "rate": self.rate,
            "signal": self.signal,
            "tolerance": self.tolerance,
            "patience": self.patience,
            "network": {"kind": network.kind, **settings},
            "first weights": digest(*arrays.values()),
            "motions": [reference.name for reference in references],
            "samples": digest(*[part for r in references for part in (r.q, r.dq, r.ddq)]),
            "machine": machine,
        }


def thesis_training(n_joints: int) -> LFFC:
    """Make training with rate and iterations of thesis 5.3.1 for one axis, of 5.3.2 for a robot."""
    return LFFC(rate=0.8, iterations=15) if n_joints == 1 else LFFC(rate=0.95, iterations=10)


def robot_seconds(references: Sequence[Reference], trials: int) -> float:
    """Compute the time that the machine moves in a number of trials [s]."""
    return trials * sum(reference.duration for reference in references)
