"""Everything that the claims and figures need, simulated when it is first asked for, and only then."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from functools import cached_property

from ffgym.robot import RobotDescription, load_robot
from ffgym.simulation.simulate import Progress
from ffgym.studies import CircleStudy, OneAxisStudy, circle_study, one_axis_study

Stage = Callable[[str, str], AbstractContextManager[Progress]]
"""Called with a title and a unit when a piece of work begins; yields what is told of its progress."""


def silent(title: str, unit: str) -> AbstractContextManager[Progress]:
    """A stage that nobody watches."""
    return nullcontext(lambda done, total: None)


class Laboratory:
    """The nominal robot and the one-axis model of the thesis, with its tests. Nothing in it is random."""

    def __init__(self, *, n_threads: int = 0, stage: Stage = silent) -> None:
        """Make a laboratory in which nothing has been simulated.

        Args:
            n_threads: threads of the engine, 0 for all cores; results are the same at any number.
            stage: is told of what goes on.
        """
        self.n_threads = n_threads
        self.stage = stage

    @cached_property
    def robot(self) -> RobotDescription:
        """Six axes, elastic joints, LuGre friction."""
        return load_robot("irb4600_60_205")

    @cached_property
    def axis(self) -> RobotDescription:
        """One rigid axis with LuGre friction."""
        return load_robot("one_axis")

    @cached_property
    def lugre_sines(self) -> OneAxisStudy:
        """Sine test with no compensation and both LuGre laws."""
        return one_axis_study(self.axis)

    @cached_property
    def lugre_circles(self) -> CircleStudy:
        """The 36 circles with no compensation and both LuGre laws."""
        with self.stage("circles with LuGre", "s") as progress:
            return circle_study(self.robot, n_threads=self.n_threads, progress=progress)
