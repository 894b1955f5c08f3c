"""Executors of many independent tasks: all cores of this machine, or a Ray cluster; results are the same."""

import multiprocessing
import os
import signal
import socket
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing.connection import wait as wait_for
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Any, Literal, TypeVar

from ffgym.core.errors import FFGymError, check_choice, check_whole

Argument = TypeVar("Argument")
Result = TypeVar("Result")

EXECUTORS = ("local", "ray")
_KNOCK = 5.0
"""Time in which the head of a cluster must answer [s]; chosen."""


@dataclass(frozen=True, kw_only=True)
class Executor:
    """Place where tasks run."""

    kind: Literal["local", "ray"] = "local"
    """This machine, or a Ray cluster."""
    jobs: int = 0
    """Number of processes on this machine, or of tasks that a cluster gets at once; 0 is one per core (of the
    cluster)."""
    address: str | None = None
    """Address of a running Ray cluster, e.g. 'auto' or 'ray://head:10001'; None starts a local one."""

    def __post_init__(self) -> None:
        check_choice("executor", self.kind, EXECUTORS)
        check_whole("jobs", self.jobs, low=0, high=100_000)
        if self.address is not None and self.kind != "ray":
            raise FFGymError(
                f"address = {self.address!r} is the address of a Ray cluster; choose the executor 'ray', or "
                "leave it out."
            )

    def run(
        self, function: Callable[[Argument], Result], arguments: Sequence[Argument]
    ) -> Iterator[tuple[int, Result]]:
        """Yield results as they come, each with the index of its argument.

        Args:
            function: function of a module, so that other processes find it; its result depends on its argument alone.
            arguments: values that pickle can carry.

        Raises:
            FFGymError: if Ray is asked for and not there, or a process dies; and whatever the function raises.
        """
        run = _run_on_ray if self.kind == "ray" else _run_here
        yield from run(function, arguments, self)


def _run_here(
    function: Callable[[Any], Any], arguments: Sequence[Any], executor: Executor
) -> Iterator[tuple[int, Any]]:
    jobs = min(executor.jobs or os.cpu_count() or 1, len(arguments))
    if jobs <= 1:
        yield from ((i, function(argument)) for i, argument in enumerate(arguments))
        return
    context = _Workers()
    pool = ProcessPoolExecutor(jobs, mp_context=context, initializer=_begin_worker)
    try:
        open_ones = {pool.submit(function, argument): i for i, argument in enumerate(arguments)}
        while open_ones:
            done, _ = wait(open_ones, return_when=FIRST_COMPLETED)
            for future in sorted(done, key=open_ones.__getitem__):
                yield open_ones.pop(future), future.result()
    except BrokenProcessPool as error:
        raise FFGymError(
            "A process that worked on a part has died: was it killed, or is memory used up? Results that were complete "
            "are kept; run the command again, with fewer jobs if memory is short."
        ) from error
    finally:
        # processes that still work have no reader any more
        workers = [child for child in multiprocessing.active_children() if child in context.begun]
        pool.shutdown(wait=False, cancel_futures=True)
        for worker in workers:
            worker.terminate()


class _Workers(SpawnContext):
    """Context that starts fresh processes, without locks of the engine's threads, and lists those that it started."""

    def __init__(self) -> None:
        super().__init__()
        self.begun: list[SpawnProcess] = []

    def Process(self, *args: Any, **kwargs: Any) -> SpawnProcess:  # type: ignore[override]
        """Start a process, and list it."""
        self.begun.append(SpawnProcess(*args, **kwargs))
        return self.begun[-1]


def _begin_worker() -> None:
    """Leave interruptions to the process that hands out tasks, and end when that process is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None  # this is a worker

    def follow() -> None:
        wait_for([parent.sentinel])
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()


def _run_on_ray(
    function: Callable[[Any], Any], arguments: Sequence[Any], executor: Executor
) -> Iterator[tuple[int, Any]]:
    try:
        import ray
    except ImportError as error:
        raise FFGymError("The executor 'ray' needs Ray; pip install 'ffgym[cluster]'.") from error
    began = not ray.is_initialized()
    if began:
        _connect(ray, executor)
    try:
        remote = ray.remote(num_cpus=1)(_call)
        limit = executor.jobs or int(ray.cluster_resources().get("CPU", 1))
        todo = list(enumerate(arguments))[::-1]
        open_ones: dict[Any, int] = {}
        while todo or open_ones:
            while todo and len(open_ones) < limit:
                i, argument = todo.pop()
                open_ones[remote.remote(function, argument)] = i
            for reference in ray.wait(list(open_ones), num_returns=1)[0]:
                yield open_ones.pop(reference), _result(ray, reference)
    finally:
        if began:
            ray.shutdown()


def _call(function: Callable[[Any], Any], argument: Any) -> Any:
    return function(argument)


def _connect(ray: Any, executor: Executor) -> None:
    """Connect to the cluster, or start a local one."""
    own = {} if executor.address else {"num_cpus": executor.jobs or None, "include_dashboard": False}
    try:
        # knock at host:port first, as Ray itself waits for minutes; words such as 'auto' it looks up itself
        host, colon, port = (executor.address or "").removeprefix("ray://").rpartition(":")
        if colon and port.isdecimal():
            socket.create_connection((host, int(port)), timeout=_KNOCK).close()
        ray.init(address=executor.address, log_to_driver=False, configure_logging=False, **own)
    except (OSError, RuntimeError, ValueError) as error:
        raise FFGymError(
            f"No Ray cluster answers at {executor.address!r}: {error}. Begin one with `ray start --head`, and give its "
            f"address, or leave the address out for one on this machine."
        ) from error


def _result(ray: Any, reference: Any) -> Any:
    """Return the result of a task, or raise the error that it ended with."""
    try:
        return ray.get(reference)
    except ray.exceptions.RayTaskError as error:
        if isinstance(error.cause, Exception):  # the function's own error, as on this machine
            raise error.cause from error
        raise
    except ray.exceptions.RayError as error:
        raise FFGymError(f"A part of the work was lost on the Ray cluster: {error}. Run the command again.") from error
