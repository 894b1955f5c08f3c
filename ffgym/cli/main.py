"""The `ffgym` command: subcommands, one-line errors, exit codes."""

import os
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Any

from ffgym.errors import FFGymError
from ffgym.provenance import installed

DESCRIPTION = "Feed-forward friction compensation on industrial robots: simulate, measure, identify, learn, compare."
"""What `ffgym --help` begins with."""

COMMANDS = {
    "bench-diagnosis": "BenchDiagnosis",
    "demo": "Demo",
    "diagnose": "Diagnose",
    "export": "Export",
    "identify": "Identify",
    "improve": "Improve",
    "leaderboard": "Leaderboard",
    "lffc": "Lffc",
    "log": "Log",
    "record": "Record",
    "reproduce": "Reproduce",
    "robot": "Robot",
    "simulate": "Simulate",
    "stability": "Stability",
    "submit": "Submit",
    "train": "Train",
    "verify": "Verify",
    "video": "Video",
}
"""Classes of subcommands, each in the module of its name."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `ffgym` with the given arguments (None takes the process') and return its exit code.

    0 is success, 1 a request that cannot be met (one line on stderr), 2 arguments that do not parse, 130 Ctrl-C.
    """
    try:
        missing = [name for name in ("tyro", "rich") if not installed(name)]
        if missing:
            raise FFGymError(f"The command line needs {' and '.join(missing)}; pip install 'ffgym[cli]'.")
        code = _run(arguments)
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
    config = (tyro.conf.OmitSubcommandPrefixes,)
    if given and given[0] in COMMANDS:
        chosen = tyro.cli(_command(given[0]), prog=f"ffgym {given[0]}", args=given[1:], config=config)
    else:
        commands: dict[str, Any] = {name: _command(name) for name in COMMANDS}
        chosen = tyro.extras.subcommand_cli_from_dict(
            commands, prog="ffgym", description=DESCRIPTION, args=given, config=config
        )
    chosen.run()
    return 0


def _command(name: str) -> type[Any]:
    """The class of a subcommand; no other is imported, which takes a second."""
    module = import_module(f"ffgym.cli.{name.replace('-', '_')}")
    command: type[Any] = getattr(module, COMMANDS[name])
    return command
