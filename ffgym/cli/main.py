"""The `ffgym` command: subcommands, one-line errors, exit codes."""

import os
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any, NamedTuple

from ffgym.core.errors import FFGymError
from ffgym.core.provenance import installed
from ffgym.core.version import __version__

DESCRIPTION = "Feed-forward friction compensation on industrial robots: simulate, measure, identify, learn, compare."
"""First line of `ffgym --help`."""


class Command(NamedTuple):
    """A subcommand: its class, its first line in lists, and an example."""

    place: str
    """Module below ffgym.cli, and class."""
    summary: str
    example: str


COMMANDS = {
    "demo": Command("demo:Demo", "circle test of the thesis, and a diagnosis", "ffgym demo --positions p1"),
    "robot": Command("robot:Robot", "describe a robot: new, fill, check", "ffgym robot new arm.urdf --out mine.toml"),
    "simulate": Command("simulate:Simulate", "any robot on any motion", "ffgym simulate irb4600_60_205 circles"),
    "play": Command("play:Play", "an episode as a video", "ffgym play --law lugre_dynamic --out episode.mp4"),
    "export": Command("export:Export", "a motion in files for plain MuJoCo", "ffgym export irb4600_60_205 circles"),
    "record": Command("record:Record", "measure by protocols", "ffgym record one_axis speed_ladder --out logs"),
    "log": Command(
        "log:Log", "logs of other tools: columns, convert, check", "ffgym log check logs/*.npz --robot one_axis"
    ),
    "identify": Command("identify:Identify", "from logs to parameters", "ffgym identify logs --robot one_axis"),
    "diagnose": Command(
        "diagnose:Diagnose", "what a simulation gets wrong, and why", "ffgym diagnose logs --robot one_axis"
    ),
    "improve": Command("improve:Improve", "what a diagnosed model gains in control", "ffgym improve machine.toml"),
    "train policy": Command(
        "train_policy:Policy", "a residual policy on a law", "ffgym train policy --algorithm ppo --out mine"
    ),
    "train bspline": Command(
        "train_bspline:BSpline", "a B-spline network, trial by trial", "ffgym train bspline --out network.npz"
    ),
    "train stability": Command(
        "train_bspline:Stability", "how fast a network may learn", "ffgym train stability --robot one_axis"
    ),
    "leaderboard": Command(
        "leaderboard:Leaderboard", "all agents, compared", "ffgym leaderboard --agents none elastic"
    ),
    "leaderboard submit": Command(
        "submission:Submit",
        "make a submission of an agent",
        "ffgym leaderboard submit mine.py --name mine --author me --track causal",
    ),
    "leaderboard verify": Command("submission:Verify", "run a submission again", "ffgym leaderboard verify mine.zip"),
}
"""Subcommands by name, in the order of `ffgym --help`."""

_MOVED = {
    "bench-diagnosis": "python -m scripts.exam, in a clone of the repository",
    "lffc": "ffgym train bspline",
    "stability": "ffgym train stability",
    "reproduce": "python -m scripts.thesis, in a clone of the repository",
    "submit": "ffgym leaderboard submit",
    "verify": "ffgym leaderboard verify",
    "train": "ffgym train policy, ffgym train bspline or ffgym train stability",
    "video": "ffgym play",
}
"""Commands of earlier versions, and what does their work now."""


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
    given = list(sys.argv[1:] if arguments is None else arguments)
    if given in (["--version"], ["-V"]):
        print(f"ffgym {__version__}")
        return 0
    if given in (["--help"], ["-h"]):
        print(_overview())
        return 0
    name = next((name for name in (" ".join(given[:2]), *given[:1]) if name in COMMANDS), None)
    if name is None:
        word = given[0] if given else ""
        if given[1:] in (["--help"], ["-h"]) and any(known.startswith(f"{word} ") for known in COMMANDS):
            print(_overview(f"{word} "))
            return 0
        if word in _MOVED:
            raise FFGymError(f"ffgym {word} has another name now: {_MOVED[word]}.")
        print(f"ffgym: error: unknown command {word!r}\n\n{_overview()}", file=sys.stderr)
        raise SystemExit(2)
    options = given[len(name.split()) :]
    if {"--help", "-h"} & set(options):
        print(f"example: {COMMANDS[name].example}\n")
    return _run_one(_command(name), f"ffgym {name}", options)


def _overview(group: str = "") -> str:
    """Commands that begin with some words, with a line each."""
    shown = {name: command for name, command in COMMANDS.items() if name.startswith(group)}
    width = max(map(len, shown))
    lines = [f"  {name:<{width}}  {command.summary}" for name, command in shown.items()]
    examples = [f"  {shown[name].example}" for name in ("demo", "simulate", "diagnose", *shown) if name in shown][:3]
    head = [f"usage: ffgym {group}COMMAND ...    {DESCRIPTION}", "", "examples:", *examples, "", "commands:"]
    return "\n".join(
        [*head, *lines, "", "ffgym COMMAND --help tells the options of a command, ffgym --version the version."]
    )


def _run_one(command: type[Any], prog: str, arguments: list[str]) -> int:
    import tyro

    tyro.cli(command, prog=prog, args=arguments, config=(tyro.conf.OmitSubcommandPrefixes,)).run()
    return 0


def _command(name: str) -> type[Any]:
    """Import the class of a subcommand, and no other."""
    module, _, name = COMMANDS[name].place.partition(":")
    command: type[Any] = getattr(import_module(f"ffgym.cli.{module}"), name)
    return command
