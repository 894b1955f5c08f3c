"""Trials of many learners at once: the next runs of all of them go through the machine's simulation together.

A simulation with effects computes these for a whole batch at little more cost than for one motion, and no recording
depends on the others: thirty learners side by side learn as each would alone, in a tenth of the time.
"""

import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np

from ffgym.recordings import Recording
from ffgym.simulation.plant import Machine
from ffgym.simulation.rig import Rig
from ffgym.simulation.run import RECORD_DT, Run

Learned = TypeVar("Learned")

Trial = Callable[[Sequence[Run], int], Sequence[Recording]]
"""Function that runs motions on a machine and returns one recording for each; the number counts trials from 0."""


@dataclass(kw_only=True, eq=False)
class _Request:
    """Runs that one learner requests."""

    runs: Sequence[Run]
    noise: Sequence[np.random.Generator]
    machine: Machine | None
    """Machine in place of the rig's own."""
    recordings: list[Recording] | None = None


@dataclass(kw_only=True, eq=False)
class SharedRig:
    """A rig that runs once every learner that still learns has requested its runs."""

    rig: Rig
    learners: int
    """Number of learners that have not ended."""
    record_dt: float = RECORD_DT
    n_threads: int = 0
    _requests: list[_Request] = field(default_factory=list, init=False, repr=False)
    _failure: BaseException | None = field(default=None, init=False, repr=False)
    turn: threading.Condition = field(default_factory=threading.Condition, init=False, repr=False)
    """Held by the learner that computes: one at a time, since they share the model of the arm and its work space."""

    def trial(self, seed: int, machine: Machine | None = None) -> Trial:
        """Make the trials of one learner, with the same noise as `RigTrial` of that seed; on a machine of its own."""

        def run(runs: Sequence[Run], number: int) -> list[Recording]:
            own = int(np.random.SeedSequence([seed, number]).generate_state(1)[0])
            request = _Request(runs=runs, noise=np.random.default_rng(own).spawn(len(runs)), machine=machine)
            self._requests.append(request)
            self._run_if_complete()
            self.turn.wait_for(lambda: request.recordings is not None or self._failure is not None)
            if request.recordings is None:
                raise RuntimeError("the trial of another learner failed") from self._failure
            return request.recordings

        return run

    def leave(self) -> None:
        """Count out a learner that has ended, in its turn."""
        self.learners -= 1
        self._run_if_complete()

    def _run_if_complete(self) -> None:
        """Run the requests of all learners, in the thread of the last one to request."""
        if not self._requests or len(self._requests) < self.learners:
            return
        requests, self._requests = self._requests, []
        runs = [run for request in requests for run in request.runs]
        noise = [rng for request in requests for rng in request.noise]
        machines = [request.machine for request in requests for _ in request.runs]
        try:
            recordings = self.rig.run(
                runs, seed=noise, machines=machines, record_dt=self.record_dt, n_threads=self.n_threads
            )
        except BaseException as error:
            self._failure = error
            raise
        finally:
            self.turn.notify_all()
        for request in requests:
            request.recordings, recordings = recordings[: len(request.runs)], recordings[len(request.runs) :]


def learn_together(
    rig: Rig,
    learners: Mapping[Any, tuple[int, Callable[[Trial], Learned]]],
    n_threads: int = 0,
    machines: Mapping[Any, Machine | None] = MappingProxyType({}),
) -> dict[Any, Learned]:
    """Let learners learn side by side on a rig; return their results by key.

    Args:
        rig: the machine.
        learners: by key, the seed of the sensors' noise and the function that learns from trials.
        n_threads: threads of the engine, 0 for all cores.
        machines: by key, the machine of a learner in place of the rig's own, under the same controller and sensors.

    Raises:
        FFGymError: if one of them cannot learn.
    """
    shared = SharedRig(rig=rig, learners=len(learners), n_threads=n_threads)

    def learn(seed: int, learner: Callable[[Trial], Learned], machine: Machine | None) -> Learned:
        with shared.turn:
            try:
                return learner(shared.trial(seed, machine))
            finally:
                shared.leave()

    with ThreadPoolExecutor(len(learners)) as threads:  # all at once, as each waits for the others
        futures = {key: threads.submit(learn, *learner, machines.get(key)) for key, learner in learners.items()}
        return {key: future.result() for key, future in futures.items()}
