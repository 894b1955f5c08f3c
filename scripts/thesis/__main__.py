"""`python -m scripts.thesis`: chapters 4 to 6 of the thesis, simulated, beside what was published."""

import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from textwrap import shorten
from typing import TYPE_CHECKING

from ffgym.cli.main import run_command
from ffgym.cli.outputs import claim_outputs, need_extra
from ffgym.core.errors import FFGymError
from ffgym.core.files import check_writable, write_json, write_text
from ffgym.core.provenance import versions

if TYPE_CHECKING:
    from scripts.thesis import Reproduced

PICTURES = ("svg", "png")
"""Formats in the folder of figures: one to print, one to look at."""


@dataclass(frozen=True)
class Reproduce:
    """Simulate figures and tables of chapters 3 to 6 of the thesis; say of each claim whether it holds."""

    only: tuple[str, ...] = ()
    """Parts to reproduce, e.g. chapter-4, figure-5.11, table-5.2; none given is all."""
    out: Path = Path("reproduction.html")
    """Page to write."""
    figures_dir: Path | None = None
    """Also write every figure to this folder, as svg and png; it is made if there is none."""
    json: Path | None = None
    """Also write every number to this file."""
    threads: int = 0
    """Threads of the simulation, 0 for all cores; results are the same at any number."""

    def run(self) -> None:
        """Simulate, write, print."""
        need_extra("The reproduction", "matplotlib", "jinja2", "rich")
        from ffgym.cli.progress import progress_bar
        from ffgym.report import save_figure
        from scripts.thesis import ITEMS, SEED, ThesisStudies, as_json, chosen, fingerprints, render_page, reproduce

        items = chosen(ITEMS, self.only)
        # what cannot be written is refused before anything is simulated
        claim_outputs({"--out": self.out, "--json": self.json})
        if self.figures_dir is not None:
            try:
                self.figures_dir.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise FFGymError(
                    f"{self.figures_dir}: cannot be made a folder: {error.strerror}; choose another place."
                ) from error
            check_writable(self.figures_dir / "figure.svg")
        begin = time.monotonic()
        studies = ThesisStudies(n_threads=self.threads, stage=progress_bar)
        results = list(reproduce(items, studies))
        info = {
            "command": "python -m scripts.thesis",
            "config": {name: str(value) if isinstance(value, Path) else value for name, value in asdict(self).items()},
            "seed": SEED,
            "versions": versions(),
            "physics_fingerprints": fingerprints(studies),
            "seconds_to_simulate_and_draw": round(time.monotonic() - begin, 1),
        }
        write_text(self.out, render_page(results, info))
        if self.json is not None:
            write_json(self.json, as_json(results, info))
        if self.figures_dir is not None:
            for figure in (figure for result in results for figure in result.figures):
                for kind in PICTURES:
                    save_figure(figure.figure, self.figures_dir / f"{figure.name}.{kind}")
        print(summary(results))
        print(f"page: {self.out}")


def summary(results: "Sequence[Reproduced]") -> str:
    """One line per claim, and how many have each verdict."""
    from scripts.thesis import count

    lines = [
        f"{result.item.heading:<12} {judgement.verdict:<15} {shorten(judgement.claim.statement, 90, placeholder=' …')}"
        for result in results
        for judgement in result.judgements
    ]
    counts = ", ".join(f"{n} {verdict}" for verdict, n in count(results).items())
    return "\n".join([*lines, "", f"claims: {counts or 'none'}"])


def main(arguments: Sequence[str] | None = None) -> int:
    """Reproduce with these arguments; the process' if None are given."""
    return run_command(Reproduce, "python -m scripts.thesis", arguments)


if __name__ == "__main__":
    sys.exit(main())
