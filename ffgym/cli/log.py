"""`ffgym log`: logs of real machines, from the file of another tool to a recording."""

from dataclasses import dataclass
from typing import Annotated

import tyro

from ffgym.cli.log_check import Check
from ffgym.cli.log_columns import Columns
from ffgym.cli.log_convert import Convert


@dataclass(frozen=True)
class Log:
    """See what a log of another tool holds, make a recording of it, and judge what it is good for."""

    task: (
        Annotated[Check, tyro.conf.subcommand("check")]
        | Annotated[Columns, tyro.conf.subcommand("columns")]
        | Annotated[Convert, tyro.conf.subcommand("convert")]
    )

    def run(self) -> None:
        """Run the task."""
        self.task.run()
