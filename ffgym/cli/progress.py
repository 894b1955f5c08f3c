"""A progress bar on stderr that stays silent where no terminal shows it."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ffgym.core.effort import announce
from ffgym.simulation.run import Progress

MOTION = "s"
"""Unit of bars that count seconds of motion, which are announced before they are simulated."""


@contextmanager
def progress_bar(title: str, unit: str) -> Iterator[Progress]:
    """Yield a function of (done, total) that draws a bar while the block runs, if stderr is a terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    columns = (TextColumn(title), BarColumn(), TextColumn("{task.fields[done]}"))
    console, told = Console(file=sys.stderr), False
    with Bar(*columns, TimeRemainingColumn(), console=console, disable=not console.is_terminal) as bar:
        task = bar.add_task(title, total=None, done="")  # the bar is drawn before the first numbers come

        def tell(done: float, total: float) -> None:
            nonlocal told
            if unit == MOTION and not told:
                told = True
                bar.stop()  # there may be a question
                announce(total, "run")
                bar.start()
            bar.update(task, completed=done, total=total, done=f"{done:.0f}/{total:.0f} {unit}")

        yield tell


@contextmanager
def stages_bar(title: str) -> Iterator[Callable[[str, float], None]]:
    """Yield a function of (what is being done, share that is done) that draws a bar, if stderr is a terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    console = Console(file=sys.stderr)
    columns = (BarColumn(), TimeElapsedColumn(), TextColumn("{task.description}"))
    with Bar(*columns, console=console, disable=not console.is_terminal) as bar:
        task, most = bar.add_task(title, total=1.0), 0.0

        def tell(what: str, share: float) -> None:
            nonlocal most
            most = max(most, share)  # a search that looks again does not take back what is done
            bar.update(task, completed=most, description=what)

        yield tell
