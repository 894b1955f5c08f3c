"""The `ffgym` command: subcommands, one-line errors, exit codes."""

import os
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any

from ffgym.core.errors import FFGymError
from ffgym.core.provenance import installed

DESCRIPTION = "Feed-forward friction compensation on industrial robots: simulate, measure, identify, learn, compare."
"""What `ffgym --help` begins with."""

COMMANDS = {
    "demo": "Demo",
    "diagnose": "Diagnose",
    "export": "Export",
    "identify": "Identify",
    "improve": "Improve",
    "leaderboard": "Leaderboard",
    "lffc": "Lffc",
    "log": "Log",
    "record": "Record",
    "robot": "Robot",
    "simulate": "Simulate",
    "stability": "Stability",
    "submit": "Submit",
    "train": "Train",
    "verify": "Verify",
    "video": "Video",
}
"""Classes of subcommands, each in the module of its name."""

_MOVED = {"bench-diagnosis": "python -m scripts.exam", "reproduce": "python -m scripts.thesis"}
"""Commands of earlier versions, and what does their work now: commands of the repository run in its folder."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `ffgym` with the given arguments (None takes the process') and return its exit code.

    0 is success, 1 a request that cannot be met (one line on stderr), 2 arguments that do not parse, 130 Ctrl-C.
    """
    return _guarded(lambda: _run(arguments))


def run_command(command: type[Any], prog: str, arguments: Sequence[str] | None = None) -> int:
    """Run one command, named `prog` in its help, with the given arguments as `main` runs a subcommand."""
    return _guarded(lambda: _run_one(command, prog, list(sys.argv[1:] if arguments is None else arguments)))


def _guarded(run: Callable[[], int]) -> int:
    """Exit code of `run`, with its errors as one line."""
    try:
        missing = [name for name in ("tyro", "rich") if not installed(name)]
        if missing:
            raise FFGymError(f"The command line needs {' and '.join(missing)}; pip install 'ffgym[cli]'.")
        code = run()
        sys.stdout.flush()
        return code
    except FFGymError as error:
        print(f"ffgym: error: {' '.join(str(error).split())}", file=sys.stderr)
        return 1
    except BrokenPipeError:  # the reader, e.g. head, has seen enough; keep Python from complaining at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        print("ffgym: interrupted; files that were finished before stay, none is half-written", file=sys.stderr)
        return 130


def _run(arguments: Sequence[str] | None) -> int:
    import tyro

    given = list(sys.argv[1:] if arguments is None else arguments)
    if given and given[0] in _MOVED:
        now = _MOVED[given[0]]
        raise FFGymError(f"ffgym {given[0]} is a command of the repository now: run {now!r} in a clone of it.")
    if given and given[0] in COMMANDS:
        return _run_one(_command(given[0]), f"ffgym {given[0]}", given[1:])
    commands: dict[str, Any] = {name: _command(name) for name in COMMANDS}
    chosen = tyro.extras.subcommand_cli_from_dict(
        commands, prog="ffgym", description=DESCRIPTION, args=given, config=(tyro.conf.OmitSubcommandPrefixes,)
    )
    chosen.run()
    return 0


def _run_one(command: type[Any], prog: str, arguments: list[str]) -> int:
    import tyro

    tyro.cli(command, prog=prog, args=arguments, config=(tyro.conf.OmitSubcommandPrefixes,)).run()
    return 0


def _command(name: str) -> type[Any]:
    """The class of a subcommand; no other is imported, which takes a second."""
    module = import_module(f"ffgym.cli.{name.replace('-', '_')}")
    command: type[Any] = getattr(module, COMMANDS[name])
    return command
