"""How the process that holds an agent is started: with this very package, and with nothing of its user's."""

import os
import subprocess
import sys
from pathlib import Path

import ffgym

PACKAGE = Path(os.path.realpath(ffgym.__file__ or "")).parent
"""Where this package is; the agent's process must find the same."""

_BEGIN = (
    "import sys\n"
    "root = sys.argv.pop()\n"
    "if root not in sys.path:\n"
    "    sys.path.insert(0, root)\n"
    "from ffgym.leaderboard.submission.worker import main\n"
    "main()\n"
)
_OPTIONS = ("-P", "-s", "-B")
"""Neither its folder nor the user's own packages are searched, and nothing is written beside what is imported."""
_KEPT = ("SYSTEMROOT", "TZ")
"""Variables of the environment that a process of Python may need; no others are passed on."""


def launch(own: Path, log: Path) -> subprocess.Popen[bytes]:
    """Process that waits for its order.

    Args:
        own: the agent's folder.
        log: gets what it prints.
    """
    with log.open("wb") as file:
        return subprocess.Popen(
            [sys.executable, *_OPTIONS, "-c", _BEGIN, str(PACKAGE.parent)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=file,
            cwd=own,
            env=_variables(own),
            start_new_session=True,
        )


def _variables(own: Path) -> dict[str, str]:
    variables = {"PATH": os.defpath, "HOME": str(own), "TMPDIR": str(own), "TEMP": str(own), "LC_ALL": "C.UTF-8"}
    variables |= {"PYTHONHASHSEED": "0"}  # sets of names have the same order in every process
    variables |= {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")}
    return variables | {name: os.environ[name] for name in _KEPT if name in os.environ}
