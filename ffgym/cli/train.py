"""`ffgym train`: agents that learn, and how fast they may."""

from dataclasses import dataclass
from typing import Annotated

import tyro

from ffgym.cli.train_bspline import BSpline, Stability
from ffgym.cli.train_policy import Policy


@dataclass(frozen=True)
class Train:
    """Train a residual policy or a B-spline network, or predict how fast a network may learn."""

    task: (
        Annotated[Policy, tyro.conf.subcommand("policy")]
        | Annotated[BSpline, tyro.conf.subcommand("bspline")]
        | Annotated[Stability, tyro.conf.subcommand("stability")]
    )

    def run(self) -> None:
        """Run the task."""
        self.task.run()
