"""What an agent must not do: look at the simulator, leave its process, talk to others, write elsewhere.

This keeps honest people honest. It is no wall: who knows Python well finds a way around a hook in the same process.
Foreign code that you have reason to distrust belongs in a container of your own; see docs/leaderboard/submissions.md.
"""

import importlib.abc
import multiprocessing.util
import platform
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn

from ffgym.core.errors import FFGymError
from ffgym.leaderboard.submission.judge import HIDDEN, Judge

Refuse = Callable[[str], None]
"""Called with what the agent tried, before the agent gets an exception that it may swallow."""


def install(refuse: Refuse, folder: Path, hidden: Sequence[str] = HIDDEN) -> None:
    """Watch this process from now on, for good.

    Args:
        refuse: called with what the agent tried, before the agent gets a PermissionError that it may swallow.
        folder: the only one in which files may be written.
        hidden: modules that must not be seen, with all below them.

    Raises:
        FFGymError: if something is loaded already that an agent must not see.
    """
    judge = Judge(folder, hidden)
    if loaded := sorted(name for name in sys.modules if judge.is_secret(name)):
        raise FFGymError(f"{', '.join(loaded)} must not be loaded where an agent runs; load agents without it.")
    _ = platform.uname().processor  # asked of another program once, and remembered

    def watch(event: str, arguments: tuple[Any, ...]) -> None:
        if (tried := judge(event, arguments)) is not None:
            refuse(tried)
            raise PermissionError(f"An agent must not {tried}.")

    _start_no_process(refuse)
    sys.meta_path.insert(0, _NoImports(refuse, judge))
    sys.addaudithook(watch)


def _start_no_process(refuse: Refuse) -> None:
    """Put a refusal where the function stood that starts processes, which raises no event, in every module."""

    def refused(*arguments: Any, **options: Any) -> NoReturn:
        refuse("start a process")
        raise PermissionError("An agent must not start a process.")

    functions = [getattr(multiprocessing.util, "spawnv_passfds", None)]
    functions += [getattr(sys.modules.get("_posixsubprocess"), "fork_exec", None)]
    for module in list(sys.modules.values()):
        for name, value in list(getattr(module, "__dict__", {}).items()):
            if value is not None and any(value is each for each in functions):
                setattr(module, name, refused)


class _NoImports(importlib.abc.MetaPathFinder):
    """Finds nothing, and refuses what is hidden, however it is imported."""

    def __init__(self, refuse: Refuse, judge: Judge) -> None:
        self._refuse, self._judge = refuse, judge

    def find_spec(self, fullname: str, path: Any, target: Any = None) -> None:
        """See base class."""
        if self._judge.hides(fullname):
            self._refuse(f"import {fullname}")
            raise ImportError(f"An agent must not import {fullname}: it is handed observations only.")
