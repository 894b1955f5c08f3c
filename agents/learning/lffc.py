"""Learning feed-forward control: a network adapted after every trial by what the feedback still had to do.

Idea and source: thesis 5.2 and (5.5)-(5.7). The torque that feedback adds along a motion is torque that feed-forward
lacked. After each trial the network learns it as a function of the reference, and the next trial runs with the result.

    trial 0         the network as given; with zero weights, no compensation
    trial k         the network after k updates, each `network.adapted(lessons, rate)`; (5.5) for B-spline networks

Run it:

    ffgym lffc --network extended --out network.npz
    ffgym lffc --network extended --speeds-mm-s 10 40 100 --prior --out wide.npz

Logged, per trial k, motion m and joint, over all samples but standstill (5.6):

    error[k, m]         mean square of the motor position error e_p [rad^2]
    signal[k, m]        mean square of the learning signal z: u_p = u_c - u_I, u_c, or K_p e_p [(N m)^2]
    relative(x)[k]      mean over the motions of x[k, m] / x[0, m]: the normalised mean square of thesis Figure 5.10

A joint is done when the change from trial to trial (5.7) of the relative mean squares says so: when error and signal
did not both fall by more than `tolerance`, `patience` trials in a row. Its weights are then locked to those of its
lowest relative error so far, and the law that comes out has the weights of the lowest on every joint.

Departures from the source: the last update is tried as well, so that n iterations are n + 1 trials and no weights come
out that were not tried, if not all in one trial: joints whose lowest errors lie in different trials never ran together
as they come out; `patience`, since one bad trial does not make a trend; several motions can be learned from at
once, each counting alike however large its errors; z = e_p is multiplied by K_p, so that it is a torque and the rate
means the same.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ffgym.agents.common.law_files import digest
from ffgym.agents.common.network import Network
from ffgym.agents.common.trials import SIGNALS, Lesson, Signal, Trial, performed
from ffgym.agents.learning.progress import Learning
from ffgym.agents.learning.progress_file import LearningFile
from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole
from ffgym.paths import Reference
from ffgym.simulation import Run

Watch = Callable[[Learning, int], None]
"""Called after every trial with what is known by then, and how many trials there will be at most."""


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
        check_number("learning rate gamma", self.rate, low=0.0, open_low=True)
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
            network: to begin with.
            references: motions of one trial.
            trial: runs them on the machine.
            state: file that is written after every trial; where it exists, learning goes on from there.
            machine: text that tells machines apart, so that a file is not used for another one.
            watch: called after every trial.

        Raises:
            FFGymError: if there is no reference, one is for another robot than the network, or the file belongs to
                other learning or has come further.
        """
        if not references:
            raise FFGymError("There is no motion to learn from; give one or more references.")
        settings = self._settings(network, references, machine)
        file = None if state is None else LearningFile(path=state, settings=settings)
        learning = self._begin(network, len(references), file)
        while learning.trials <= self.iterations and not learning.locked.all():
            lessons = self._try(learning, references, trial)
            learning = learning.after(lessons, rate=self.rate, tolerance=self.tolerance, patience=self.patience)
            if file is not None:
                file.write(learning)
            if watch is not None:
                watch(learning, self.iterations + 1)
        return learning

    def _begin(self, network: Network, n_motions: int, file: LearningFile | None) -> Learning:
        learning = Learning.begin(network, n_motions) if file is None else file.read(network, n_motions)
        if file is not None and learning.trials > self.iterations + 1:
            raise FFGymError(
                f"{file.path}: has {learning.trials - 1} iterations already, more than the {self.iterations} asked "
                f"for; ask for as many or more, or begin anew with another file."
            )
        return learning

    def _try(self, learning: Learning, references: Sequence[Reference], trial: Trial) -> list[Lesson]:
        recordings = performed(trial, [Run(reference=r, law=learning.network) for r in references], learning.trials)
        return [Lesson.of(r, recording, self.signal) for r, recording in zip(references, recordings, strict=True)]

    def _settings(self, network: Network, references: Sequence[Reference], machine: str) -> dict[str, Any]:
        """What must not change while learning; more iterations may be asked for later."""
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


def robot_seconds(references: Sequence[Reference], trials: int) -> float:
    """Time that the machine moved in so many trials [s]."""
    return trials * sum(reference.duration for reference in references)
