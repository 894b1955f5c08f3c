"""Agent in a process of its own, which behaves as one in this process; its failures become refusals.

Bubblewrap isolates it where that is installed: no network, no other processes, and of the files only libraries and this
package, without the truth of the workcells.
"""

import json
import os
import shutil
import signal
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import ExitStack, suppress
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import IO, Any, Self
from weakref import finalize

import numpy as np

import ffgym
from ffgym.control.observation import Channel
from ffgym.core.errors import FFGymError, check_number
from ffgym.core.temporaries import scratch_folder
from ffgym.core.typed_json import parse_json
from ffgym.core.types import Array
from ffgym.leaderboard.submission.manifest import AgentSource, Refused
from ffgym.robot import load_robot

DECLARED = "FFGYM_ISOLATED"
"""Environment variable that declares another isolation, as of a container."""
_PACKAGE = Path(os.path.realpath(ffgym.__file__ or "")).parent
_SYSTEM = ("/usr", "/bin", "/lib", "/lib64", "/etc/alternatives", "/etc/ld.so.cache", "/etc/localtime", "/nix")
"""Folders of programs and libraries."""
_BUBBLE = (
    *("--unshare-all", "--die-with-parent", "--cap-drop", "ALL"),  # root would otherwise keep the right to unmount
    *("--proc", "/proc", "--dev", "/dev", "--tmpfs", "/tmp"),
)
_PYTHON = (sys.executable, "-P", "-s", "-B")
"""Command of Python, which searches neither its folder nor the user's own packages, and writes no byte code."""
_HEAD = struct.Struct("<II")
_LONGEST = 2**26
"""Largest number of bytes of one part of a message."""


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Limits of an agent; chosen so that honest ones never meet them."""

    start_s: float = 120.0
    """Time to load it, with libraries [s]."""
    decision_s: float = 20.0
    """Time of one decision, for all robots of a run [s]; usual times are measured apart."""
    late_s: float = 10.0
    """Time that all decisions of a run may take beyond one control step for each decision of each robot [s]: the first
    ones of libraries take long, and computers do other things. It bounds how long a run may take."""
    memory_bytes: int = 32 * 2**30
    """Address space: libraries reserve much more than they use."""
    cpu_seconds: int = 1800
    """Processor time of one process, all threads together [s]."""


class AgentProcess:
    """Agent of a submission; `predict` is stable-baselines3's. It ends with `close`, a `with` block, or this object.

    Args:
        source: source of the agent.
        content: bytes of its file; None if there is none.
        robot: name of the robot's nominal description.
        loaders: modules that load agents, by kind: each has load(source, folder, robot), which returns a Policy.
        seed: seed of its randomness.
        feedback: False leaves out errors of the motors in its observations.
        channel: quantity that its actions are added to.
        limits: limits of time and memory.
        whose: first words of a refusal.

    Raises:
        FFGymError: if no process can be started.
        Refused: if the agent cannot be made.
    """

    def __init__(
        self,
        source: AgentSource,
        content: bytes | None,
        robot: str,
        *,
        loaders: Mapping[str, str],
        seed: int,
        feedback: bool = True,
        channel: Channel = "torque",
        limits: Limits | None = None,
        whose: str = "",
    ) -> None:
        self._limits, self._whose = limits or Limits(), whose
        known = load_robot(robot)
        self._n_joints, self._control_dt = known.n_joints, known.servo.control_dt
        self._spent_s = self._due_s = 0.0
        self.elapsed_us = 0.0
        """Time of the last decision [us], measured beside the agent; the sum of all is measured in this process."""
        # folder with the agent's file, and the process
        try:
            files = ExitStack()
            own = files.enter_context(scratch_folder()).resolve() / "agent"
            self._log = own.with_name("log.txt")
            try:
                own.mkdir()
                if source.file is not None and content is not None:
                    (own / source.file).write_bytes(content)
                self._process = launch(own, self._log)
            except OSError:
                files.close()
                raise
        except OSError as error:
            raise FFGymError(
                f"No process can be started for the agent: {error}. Its folder is made where TMPDIR says, "
                "which must exist, be writable and have space left."
            ) from error
        # order to make the agent, and its answer
        self.close = finalize(self, _end, self._process, files)
        order = {"source": asdict(source), "robot": robot, "loader": loaders[source.kind], "seed": seed}
        try:
            order |= {"feedback": feedback, "channel": channel, "folder": str(own), "limits": asdict(self._limits)}
            told, _ = self._ask(order, b"", self._limits.start_s, "to be made")
            self.preview = int(self._number("preview", told, 1000))
            self.action_scale = self._number("action_scale", told)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def predict(
        self, observation: Array, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Array, Any]:
        """Compute actions (B, N) for observations (B, D); the state is True, as the real one stays with the agent.

        Refused if the agent fails, takes too long, or answers with something else.
        """
        began, rows = time.perf_counter(), len(observation)
        starts = np.zeros(rows) if episode_start is None else np.asarray(episode_start)
        message = {"shape": observation.shape, "starts": starts.astype(bool).tolist(), "first": state is None}
        numbers = np.ascontiguousarray(observation, dtype="<f8").tobytes()
        told, answer = self._ask(message, numbers, self._limits.decision_s, "for one decision")
        self.elapsed_us = self._number("elapsed_us", told)
        self._spent_s, self._due_s = self._spent_s + time.perf_counter() - began, self._due_s + rows * self._control_dt
        if self._spent_s > self._due_s + self._limits.late_s:
            times = f"{self._spent_s:.1f} s for decisions that the robots had {self._due_s:.1f} s for"
            raise Refused("time", f"it took {times}, must be late by at most {self._limits.late_s:g} s.", self._whose)
        if len(answer) != 4 * rows * self._n_joints:
            raise Refused(
                "agent", f"it answered with {len(answer)} bytes, not with actions of {rows} robots.", self._whose
            )
        action = np.frombuffer(answer, dtype="<f4").reshape(rows, self._n_joints).astype(np.float64)
        if not np.all(np.isfinite(action)):
            raise Refused("agent", "it answered with NaN or infinity.", self._whose)
        return action, True

    def _ask(self, message: Mapping[str, Any], numbers: bytes, limit: float, what: str) -> tuple[dict[str, Any], bytes]:
        """Send a message and return the answer; end the process when it takes longer than the limit [s]."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        deadline, timer = time.monotonic() + limit, threading.Timer(limit, _kill, [self._process])
        timer.start()
        try:
            send(self._process.stdin, message, numbers)
            answer, data = receive(self._process.stdout)
        except (EOFError, OSError):
            late = time.monotonic() >= deadline
            reason = f"it took more than {limit:g} s {what}, and was ended." if late else self._last_words()
            raise Refused("agent", reason, self._whose) from None
        except (ValueError, RecursionError) as error:
            raise Refused("agent", f"it sent no message: {error}", self._whose) from None
        finally:
            timer.cancel()
        if "refused" in answer:
            raise Refused("agent", str(answer["refused"]), self._whose)
        return answer, data

    def _number(self, name: str, told: Mapping[str, Any], high: float = np.inf) -> float:
        try:
            return check_number(name, told.get(name), low=0.0, high=high)
        except FFGymError as error:
            raise Refused("agent", str(error), self._whose) from error

    def _last_words(self) -> str:
        """Describe the end of the process, with the last line that it wrote."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(timeout=5.0)
        code = self._process.returncode
        if hasattr(signal, "SIGXCPU") and code in (-signal.SIGXCPU, 128 + signal.SIGXCPU):  # the latter from bubblewrap
            return f"it took more than {self._limits.cpu_seconds} s of processor time, and was ended."
        lines = self._log.read_bytes()[-2000:].decode(errors="replace").strip().splitlines()
        last = f": {lines[-1][:300]}" if lines else ""
        return f"its process ended by itself with code {code}{last}."


def send(pipe: IO[bytes], message: Mapping[str, Any], numbers: bytes = b"") -> None:
    """Send JSON and numbers, each after its length; a message holds no program."""
    text = json.dumps(message).encode()
    pipe.write(_HEAD.pack(len(text), len(numbers)) + text + numbers)
    pipe.flush()


def receive(pipe: IO[bytes]) -> tuple[dict[str, Any], bytes]:
    """Receive the next message; EOFError if the other side has gone, FFGymError if it is no message."""

    def read(length: int) -> bytes:
        data = pipe.read(length)
        if len(data) < length:
            raise EOFError
        return data

    lengths = _HEAD.unpack(read(_HEAD.size))
    if max(lengths) > _LONGEST:
        raise FFGymError(f"{max(lengths)} bytes are more than any has.")
    message, numbers = parse_json(read(lengths[0]), "it"), read(lengths[1])
    if not isinstance(message, dict):
        raise FFGymError("it is no JSON object.")
    return message, numbers


def launch(own: Path, log: Path) -> subprocess.Popen[bytes]:
    """Launch the process that waits for its order in the agent's own folder; its output goes to `log`."""
    variables = {"PATH": os.defpath, "HOME": str(own), "TMPDIR": str(own), "TEMP": str(own), "LC_ALL": "C.UTF-8"}
    variables |= {"PYTHONHASHSEED": "0"}  # sets of names have the same order in every process
    variables |= {"PYTHONPATH": str(_PACKAGE.parent)}  # the package that asks: another version may decide otherwise
    variables |= {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")}
    variables |= {name: os.environ[name] for name in ("SYSTEMROOT", "TZ") if name in os.environ}
    with log.open("wb") as file:
        return subprocess.Popen(
            [*(_bubble(own) if _exposed() is None else []), *_PYTHON, "-m", "ffgym.leaderboard.submission.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=file,
            cwd=own,
            env=variables,
            start_new_session=True,
        )


def describe_isolation() -> str:
    """Describe what isolates agents, for the record of a verdict: bubblewrap, a declared container, or nothing."""
    why, declared = _exposed(), os.environ.get(DECLARED)
    return "bubblewrap" if why is None else f"declared: {declared}" if declared else f"none: {why}"


def isolation_note() -> str | None:
    """Return a warning for the screen if agents are not isolated, else None."""
    why = None if os.environ.get(DECLARED) else _exposed()
    return why and (
        f"Nothing isolates agents here ({why}): their code runs as you and can read your files. For one that you have "
        "reason to distrust, install bubblewrap, or use the container of docs/leaderboard/submissions.md."
    )


@cache
def _exposed() -> str | None:
    """Return the reason why bubblewrap does not isolate; None if it does."""
    if shutil.which("bwrap") is None:
        return "no program bwrap"
    with scratch_folder() as own:
        tried = subprocess.run([*_bubble(own), *_PYTHON, "-c", ""], capture_output=True, text=True, check=False)
    return None if tried.returncode == 0 else f"bwrap fails: {' '.join(tried.stderr.split())[-200:]}"


def _bubble(own: Path) -> list[str]:
    """Make the command that gives another one access to libraries, this package and the agent's folder alone."""
    libraries = (*_SYSTEM, sys.prefix, sys.base_prefix, str(_PACKAGE), os.path.realpath(_PACKAGE / "agents"))
    command = [shutil.which("bwrap") or "bwrap", *_BUBBLE]
    for place in dict.fromkeys(libraries):
        command += ["--ro-bind-try", place, place]
    # the truth of the workcells is covered, in every copy of this package that Python finds
    copies = [_PACKAGE, *(Path(os.path.realpath(place)) / "ffgym" for place in sys.path)]
    for secret in dict.fromkeys(str(copy / "workcell") for copy in copies if (copy / "workcell").is_dir()):
        command += ["--tmpfs", secret]
    return [*command, "--bind", str(own), str(own), "--chdir", str(own)]


def _end(process: subprocess.Popen[bytes], files: ExitStack) -> None:
    """End a process and remove its files."""
    _kill(process)  # its children may outlive it
    process.wait()
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            with suppress(OSError):
                pipe.close()
    files.close()


def _kill(process: subprocess.Popen[bytes]) -> None:
    """End a process and its children."""
    with suppress(OSError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
