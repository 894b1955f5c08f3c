"""An agent in a process of its own, asked from here as if it were at hand; what goes wrong there is a refusal here."""

import json
import os
import signal
import subprocess
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Self

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.core.types import Array
from ffgym.leaderboard.submission.launch import PACKAGE, launch
from ffgym.leaderboard.submission.limits import Limits
from ffgym.leaderboard.submission.manifest import AgentSource
from ffgym.leaderboard.submission.protocol import (
    ACTIONS,
    JSON,
    OBSERVATIONS,
    REFUSED,
    Channel,
    Closed,
    pack_observations,
    unpack_actions,
)
from ffgym.leaderboard.submission.refusal import Refused
from ffgym.leaderboard.submission.watchdog import Watchdog
from ffgym.robot import load_robot

_CHECK = "agent"


class AgentProcess:
    """An agent of others; `predict` is stable-baselines3's. Use it in a `with` block.

    Args:
        source: what it is made from.
        content: of its file; None if there is none.
        robot: name of what it may know of its robot.
        loaders: modules that load agents, by kind: each has load(source, folder, robot), which returns a Policy, and
            may have prepare(source, folder), which is called before the agent is watched.
        seed: of its randomness.
        limits: what it may use.

    Raises:
        Refused: if it cannot be made, or does what it must not.
    """

    def __init__(
        self,
        source: AgentSource,
        content: bytes | None,
        robot: str,
        *,
        loaders: Mapping[str, str],
        seed: int,
        limits: Limits | None = None,
    ) -> None:
        self._limits = limits or Limits()
        known = load_robot(robot)
        self._n_joints, self._control_dt = known.n_joints, known.servo.control_dt
        self._order: dict[str, Any] = {
            "source": asdict(source),
            "robot": robot,
            "loader": loaders[source.kind],
            "package": str(PACKAGE),
            "seed": seed,
            "memory_bytes": self._limits.memory_bytes,
            "cpu_seconds": self._limits.cpu_seconds,
        }
        self._start(source.file, content)
        self._spent_s = self._due_s = 0.0
        self.elapsed_ns = 0
        """Time of the last decision [ns], measured beside the agent."""

    def _start(self, file: str | None, content: bytes | None) -> None:
        """Start the process in a folder of its own, which holds the agent's file."""
        folders: TemporaryDirectory[str] | None = None
        try:
            folders = TemporaryDirectory(prefix="ffgym-agent-")
            own = Path(folders.name).resolve() / "agent"
            own.mkdir()
            if file is not None and content is not None:
                (own / file).write_bytes(content)
            self._log = own.with_name("log.txt")
            self._process = launch(own, self._log)
        except OSError as error:
            if folders is not None:
                folders.cleanup()
            raise FFGymError(
                f"No process can be started for the agent: {error}. Its folder is made where TMPDIR says, "
                "which must exist, be writable and have space left."
            ) from error
        self._folders, self._order["folder"] = folders, str(own)
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._channel = Channel(self._process.stdout.fileno(), self._process.stdin.fileno())
        self._watch = Watchdog(self._kill)

    def __enter__(self) -> Self:
        """Make the agent."""
        try:
            order = json.dumps(self._order).encode()
            told = _tree(self._ask(JSON, order, JSON, self._limits.start_s, "to be made"))
            try:
                self.preview = check_whole("PREVIEW", told.get("preview"), low=0, high=1000)
                self.action_scale = check_number("ACTION_SCALE", told.get("action_scale"), low=0.0, open_low=True)
            except FFGymError as error:
                raise Refused(_CHECK, str(error)) from error
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(self, kind: Any, error: Any, trace: Any) -> None:
        """End the process; what it tried until its end counts."""
        try:
            if kind is None:
                self._end()
        finally:
            self.close()

    def predict(
        self, observation: Array, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Array, Any]:
        """Actions (B, N) for observations (B, D), and a state that says that there is one; it stays with the agent.

        Raises:
            Refused: if the agent fails, takes too long, answers with something else, or did what it must not.
        """
        payload = pack_observations(observation, episode_start, first=state is None)
        began = time.monotonic()
        answer = self._ask(OBSERVATIONS, payload, ACTIONS, self._limits.decision_s, "for one decision")
        self._keep_pace(time.monotonic() - began, len(observation))
        try:
            action, self.elapsed_ns = unpack_actions(answer, len(observation), self._n_joints)
        except FFGymError as error:
            raise Refused(_CHECK, str(error)) from error
        if not np.all(np.isfinite(action)):
            raise Refused(_CHECK, "it answered with NaN or infinity.")
        return action, True

    def _keep_pace(self, spent_s: float, rows: int) -> None:
        """Check that all decisions together keep up with the robots, seen from here, where no agent sets the clock."""
        self._spent_s += spent_s
        self._due_s += rows * self._control_dt
        if self._spent_s > self._due_s + self._limits.late_s:
            raise Refused(
                "time",
                f"it took {self._spent_s:.1f} s for decisions that the robots had {self._due_s:.1f} s for, "
                f"must be late by at most {self._limits.late_s:g} s.",
            )

    def _ask(self, kind: bytes, payload: bytes, wanted: bytes, limit: float, what: str) -> bytes:
        """Answer to a frame."""
        try:
            with self._watch.limit(limit):
                self._channel.send(kind, payload)
                found, answer = self._channel.receive()
        except Closed:
            if self._watch.expired:
                raise Refused(_CHECK, f"it took more than {limit:g} s {what}, and was ended.") from None
            raise Refused(_CHECK, self._last_words()) from None
        except FFGymError as error:
            raise Refused(_CHECK, str(error)) from error
        if found == REFUSED:
            raise Refused(_CHECK, str(_tree(answer).get("reason")))
        if found != wanted:
            raise Refused(_CHECK, f"it answered with a message of kind {found!r}, not {wanted!r}.")
        return answer

    def _end(self) -> None:
        """Let the process end, and hear what was tried on the way."""
        with suppress(Closed), self._watch.limit(self._limits.decision_s):
            self._channel.send_json({"end": True})
            kind, answer = self._channel.receive()  # nothing is left to say but what it tried
            said = _tree(answer).get("reason") if kind == REFUSED else f"it spoke unasked, a message of kind {kind!r}."
            raise Refused(_CHECK, str(said))

    def _last_words(self) -> str:
        """How the process ended, and the last line that it wrote."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(timeout=5.0)
        code = self._process.returncode
        if hasattr(signal, "SIGXCPU") and code == -signal.SIGXCPU:
            return f"it took more than {self._limits.cpu_seconds} s of processor time, and was ended."
        lines = self._log.read_bytes()[-2000:].decode(errors="replace").strip().splitlines()
        last = f": {lines[-1][:300]}" if lines else ""
        return f"its process ended by itself with code {code}{last}."

    def _kill(self) -> None:
        """End the process and what it started."""
        with suppress(OSError):
            if hasattr(os, "killpg"):
                os.killpg(self._process.pid, signal.SIGKILL)
            else:
                self._process.kill()

    def close(self) -> None:
        """End the process and remove its files."""
        self._watch.stop()
        self._kill()  # what it started may live though it has ended
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                with suppress(OSError):
                    pipe.close()
        self._folders.cleanup()


def _tree(payload: bytes) -> dict[str, Any]:
    """JSON object of an answer; what is none says nothing."""
    try:
        tree = json.loads(payload)
    except (ValueError, RecursionError):
        return {}
    return tree if isinstance(tree, dict) else {}
