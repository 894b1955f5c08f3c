"""The `ffgym` command: subcommands, one-line errors, exit codes."""

import os
import signal
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import fields
from importlib import import_module
from math import isfinite
from typing import Any, NamedTuple

from ffgym.cli.process import EndedError, ended_by_signals, lasting_output
from ffgym.core.claims import piece_of_work
from ffgym.core.effort import watched
from ffgym.core.errors import FFGymError
from ffgym.core.provenance import is_installed
from ffgym.core.temporaries import remove_own
from ffgym.core.version import __version__

DESCRIPTION = "Feed-forward friction compensation on industrial robots: simulate, measure, identify, learn, compare."
"""First line of `ffgym --help`."""


class Command(NamedTuple):
    """A subcommand."""

    options: str
    """Module below ffgym.cli and class of its options, from which its help is made."""
    work: str
    """Module below ffgym.cli and function that does its work; loaded when it runs."""
    summary: str
    """Line in lists of commands."""
    example: str
    """Arguments of an example."""


COMMANDS = {
    "demo": Command("motion_options:Demo", "demo:run", "circle test of the thesis, and a diagnosis", "--positions p1"),
    "robot new": Command(
        "log_options:NewRobot", "robot:new", "describe the robot of an arm file", "arm.urdf --out mine.toml"
    ),
    "robot fill": Command("log_options:FillRobot", "robot:fill", "fill in what a description lacks", "mine.toml"),
    "robot check": Command(
        "log_options:CheckRobot", "robot:check", "what a description says, lacks and allows", "mine.toml"
    ),
    "simulate": Command("motion_options:Simulate", "simulate:run", "any robot on any motion", "irb4600_60_205 circles"),
    "play": Command(
        "motion_options:Play", "play:run", "an episode as a video, one agent or two", "lugre_dynamic ppo_elastic"
    ),
    "export": Command(
        "motion_options:Export", "export:run", "a motion in files for plain MuJoCo", "irb4600_60_205 circles"
    ),
    "export code": Command(
        "code_options:ExportCode",
        "export_code:run",
        "a feed-forward law as C99, compared and timed",
        "irb4600_60_205 circles --feedforward elastic --out law",
    ),
    "export table": Command(
        "code_options:ExportTable",
        "export_table:run",
        "torque and correction along a motion as tables",
        "irb4600_60_205 circles --feedforward elastic --out table",
    ),
    "export fmu": Command(
        "code_options:ExportFmu",
        "export_fmu:run",
        "a robot and a program as FMUs, compared",
        "irb4600_60_205 circles --feedforward elastic --out fmu",
    ),
    "export program": Command(
        "code_options:ExportProgram",
        "export_program:run",
        "a plan as a corrected program, compared",
        "plan.npz --format rapid --out corrected",
    ),
    "export policy": Command(
        "code_options:ExportPolicy",
        "export_policy:run",
        "a residual policy as ONNX, compared",
        "ppo_elastic --out policy.onnx",
    ),
    "record": Command(
        "motion_options:Record", "record:run", "measure by protocols", "one_axis speed_ladder --out logs"
    ),
    "log columns": Command(
        "log_options:ListColumns", "log:columns", "what a file of another tool holds", "trace.csv --out map.toml"
    ),
    "log convert": Command(
        "log_options:ConvertLog",
        "log:convert",
        "recordings of a file of another tool",
        "trace.csv --columns map.toml --out recording.npz",
    ),
    "log check": Command("log_options:CheckLogs", "log:check", "what logs are good for", "logs/*.npz --robot one_axis"),
    "identify": Command("log_options:Identify", "identify:run", "from logs to parameters", "logs --robot one_axis"),
    "identify controller": Command(
        "stream_options:IdentifyController",
        "identify_controller:run",
        "delay and filter of a controller",
        "probe_log.npz --robot irb4600_60_205 --out controller.toml",
    ),
    "diagnose": Command(
        "log_options:Diagnose", "diagnose:run", "what a simulation gets wrong, and why", "logs --robot one_axis"
    ),
    "plan": Command(
        "stream_options:PlanSetpoints",
        "plan_setpoints:run",
        "set-points of a motion under a law",
        "irb4600_60_205 circles --out plan.npz",
    ),
    "stream": Command(
        "stream_options:Stream", "stream:run", "a plan to a robot controller, in real time", "plan.npz --out log.npz"
    ),
    "emulate": Command(
        "stream_options:Emulate", "emulate:run", "a robot controller to try a stream on", "egm --delay-ms 9.3"
    ),
    "improve": Command("log_options:Improve", "improve:run", "what a diagnosed model gains in control", "machine.toml"),
    "trial plan": Command(
        "trial_options:PlanTrial",
        "trial:plan",
        "an on/off experiment on a machine, in random order",
        "irb4600_60_205 circles --runs 16 --seed 7 --out trial",
    ),
    "trial rehearse": Command(
        "trial_options:RehearseTrial",
        "trial:rehearse_plan",
        "the planned experiment on a simulated machine",
        "trial --machine workcell:thesis --feedforward elastic",
    ),
    "trial read": Command(
        "trial_options:ReadTrial",
        "trial:read",
        "the gain that the logs show, and how sure it is",
        "trial trial/logs --report gain.html",
    ),
    "train policy": Command(
        "learning_options:PolicyTraining",
        "train_policy:run",
        "a residual policy on a law",
        "--algorithm ppo --out mine",
    ),
    "train bspline": Command(
        "learning_options:BSpline", "train_bspline:bspline", "a B-spline network, trial by trial", "--out network.npz"
    ),
    "train stability": Command(
        "learning_options:Stability", "train_bspline:stability", "how fast a network may learn", "--robot one_axis"
    ),
    "leaderboard": Command(
        "learning_options:Leaderboard", "leaderboard:run", "all agents, compared", "--agents none elastic"
    ),
    "leaderboard submit": Command(
        "learning_options:Submit",
        "submission:submit",
        "make a submission of an agent",
        "mine.py --name mine --author me --track causal",
    ),
    "leaderboard verify": Command("learning_options:Verify", "submission:verify", "run a submission again", "mine.zip"),
    "leaderboard round": Command(
        "learning_options:NewRound",
        "submission:new_round",
        "commit to a seed of drawn machines and motions",
        "--out round.json",
    ),
}
"""Subcommands by name, in the order of `ffgym --help`."""

_KEPT = "files that were finished before stay, none is half-written"

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

    0 is success, 1 a request that cannot be met (one line on stderr), 2 arguments that do not parse, 130 Ctrl-C, 143
    SIGTERM, 129 SIGHUP.
    """
    return _guard(lambda: _run(list(sys.argv[1:] if arguments is None else arguments)))


def run_command(command: type[Any], prog: str, arguments: Sequence[str] | None = None) -> int:
    """Run a command of the repository, named `prog` in its help, as `main` runs a subcommand; `run` does its work."""
    given = sys.argv[1:] if arguments is None else arguments
    return _guard(lambda: _work(command, lambda options: options.run(), prog, given))


def _guard(run: Callable[[], int]) -> int:
    """Exit code of `run`, with its errors as one line; what it claims it holds until it ends."""
    try:
        missing = [name for name in ("tyro", "rich") if not is_installed(name)]
        if missing:
            raise FFGymError(f"The command line needs {' and '.join(missing)}; pip install 'ffgym[cli]'.")
        with ended_by_signals(), lasting_output(), piece_of_work():
            return run()
    except FFGymError as error:
        _tell(f"error: {' '.join(str(error).split())}")
        return 1
    except OSError as error:
        if error.filename is not None:
            _tell(
                f"error: {os.fsdecode(error.filename)}: {error.strerror}. Choose another place, or allow access to it."
            )
        elif not _has_folder():
            _tell("error: The working directory is gone: it was removed or moved. Change to one that is there.")
        else:  # no file is to blame, but this program
            raise
        return 1
    except MemoryError as error:
        _tell(f"error: The memory of this computer is too small for it: {error or 'it is full'}. Ask for less at once.")
        return 1
    except EndedError as ended:
        remove_own()
        name = signal.Signals(ended.number).name
        _tell(f"{'interrupted' if name == 'SIGINT' else f'ended by {name}'}; {_KEPT}")
        return 128 + ended.number


def _has_folder() -> bool:
    """Tell if the working directory is there, from which the paths of files begin."""
    try:
        os.getcwd()
    except OSError:
        return False
    return True


def _tell(words: str) -> None:
    """Write a line to standard error, if there is a place for it."""
    with suppress(OSError):
        print(f"ffgym: {words}", file=sys.stderr, flush=True)


def _run(given: list[str]) -> int:
    """Run the command that words begin with, or say which there are."""
    if given in (["--version"], ["-V"]):
        print(f"ffgym {__version__}")
        return 0
    if given in (["--help"], ["-h"]):
        print(_overview())
        return 0
    name = next((name for name in (" ".join(given[:2]), *given[:1]) if name in COMMANDS), None)
    if name is None:
        word = given[0] if given else ""
        group = f"{word} " if any(known.startswith(f"{word} ") for known in COMMANDS) else ""
        if group and given[1:] in (["--help"], ["-h"]):
            print(_overview(group))
            return 0
        if word in _MOVED:
            raise FFGymError(f"ffgym {word} has another name now: {_MOVED[word]}.")
        print(f"ffgym: error: unknown command {' '.join(given[:2] if group else [word])!r}", file=sys.stderr)
        print(f"\n{_overview(group)}", file=sys.stderr)
        raise SystemExit(2)
    command, options = COMMANDS[name], given[len(name.split()) :]
    if {"--help", "-h"} & set(options):
        print(f"example: ffgym {name} {command.example}\n")
    return _work(
        load_object(command.options), lambda chosen: load_object(command.work)(chosen), f"ffgym {name}", options
    )


def _overview(group: str = "") -> str:
    """Commands that begin with some words, with a line each."""
    shown = {name: command for name, command in COMMANDS.items() if name.startswith(group)}
    width = max(map(len, shown))
    lines = [f"  {name:<{width}}  {command.summary}" for name, command in shown.items()]
    examples = [
        f"  ffgym {name} {shown[name].example}" for name in ("demo", "simulate", "diagnose", *shown) if name in shown
    ][:3]
    head = [f"usage: ffgym {group}COMMAND ...    {DESCRIPTION}", "", "examples:", *examples, "", "commands:"]
    return "\n".join(
        [*head, *lines, "", "ffgym COMMAND --help tells the options of a command, ffgym --version the version."]
    )


def _work(options: type[Any], work: Callable[[Any], None], prog: str, arguments: Sequence[str]) -> int:
    """Read options, and do what they ask for."""
    import tyro

    chosen = tyro.cli(options, prog=prog, args=list(arguments))
    _check_finite(chosen)
    if not hasattr(chosen, "yes"):  # it never asks
        work(chosen)
        return 0
    from ffgym.cli.long_work import watch_over

    with watched(watch_over(chosen)):
        work(chosen)
    return 0


def _check_finite(options: Any) -> None:
    """Check that all numbers are finite: others have no form in the files that say where results come from.

    Raises:
        FFGymError: if one is not.
    """
    for field in fields(options):
        value = getattr(options, field.name)
        for number in value if isinstance(value, tuple) else (value,):
            if isinstance(number, float) and not isfinite(number):
                raise FFGymError(f"--{field.name.replace('_', '-')} = {number} must be a finite number.")


def load_object(place: str) -> Any:
    """A class or function of a module below ffgym.cli, imported when it is asked for."""
    module, _, name = place.partition(":")
    return getattr(import_module(f"ffgym.cli.{module}"), name)
