"""`ffgym robot`: descriptions of robots, from an arm file to what is known, what is missing, and what works."""

from dataclasses import dataclass
from typing import Annotated

import tyro

from ffgym.cli.robot_check import Check
from ffgym.cli.robot_fill import Fill
from ffgym.cli.robot_new import New


@dataclass(frozen=True)
class Robot:
    """Make a description of a robot from an arm file, fill it in, and see what it says."""

    task: (
        Annotated[New, tyro.conf.subcommand("new")]
        | Annotated[Fill, tyro.conf.subcommand("fill")]
        | Annotated[Check, tyro.conf.subcommand("check")]
    )

    def run(self) -> None:
        """Run the task."""
        self.task.run()
