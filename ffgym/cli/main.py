"""The `ffgym` command: subcommands, one-line errors, exit codes."""

import os
import sys
from collections.abc import Sequence
from typing import Annotated

from ffgym.errors import FFGymError
from ffgym.provenance import installed

DESCRIPTION = "Feed-forward friction compensation on industrial robots: simulate, measure, identify, learn, compare."
"""What `ffgym --help` begins with."""


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

    from ffgym.cli.bench_diagnosis import BenchDiagnosis
    from ffgym.cli.demo import Demo
    from ffgym.cli.diagnose import Diagnose
    from ffgym.cli.export import Export
    from ffgym.cli.identify import Identify
    from ffgym.cli.improve import Improve
    from ffgym.cli.lffc import Lffc
    from ffgym.cli.log import Log
    from ffgym.cli.record import Record
    from ffgym.cli.reproduce import Reproduce
    from ffgym.cli.robot import Robot
    from ffgym.cli.simulate import Simulate
    from ffgym.cli.stability import Stability
    from ffgym.cli.video import Video

    command = Annotated[
        Annotated[BenchDiagnosis, tyro.conf.subcommand("bench-diagnosis")]
        | Annotated[Demo, tyro.conf.subcommand("demo")]
        | Annotated[Diagnose, tyro.conf.subcommand("diagnose")]
        | Annotated[Export, tyro.conf.subcommand("export")]
        | Annotated[Identify, tyro.conf.subcommand("identify")]
        | Annotated[Improve, tyro.conf.subcommand("improve")]
        | Annotated[Lffc, tyro.conf.subcommand("lffc")]
        | Annotated[Log, tyro.conf.subcommand("log")]
        | Annotated[Record, tyro.conf.subcommand("record")]
        | Annotated[Reproduce, tyro.conf.subcommand("reproduce")]
        | Annotated[Robot, tyro.conf.subcommand("robot")]
        | Annotated[Simulate, tyro.conf.subcommand("simulate")]
        | Annotated[Stability, tyro.conf.subcommand("stability")]
        | Annotated[Video, tyro.conf.subcommand("video")],
        tyro.conf.OmitSubcommandPrefixes,
    ]
    chosen: (
        BenchDiagnosis
        | Demo
        | Diagnose
        | Export
        | Identify
        | Improve
        | Lffc
        | Log
        | Record
        | Reproduce
        | Robot
        | Simulate
        | Stability
        | Video
    )
    chosen = tyro.cli(command, prog="ffgym", args=arguments, description=DESCRIPTION)
    chosen.run()
    return 0
