"""Measure what a perceptron forgets and B-splines do not (`ffgym.agents.learning.forgetting`), as figure and numbers.

python -m scripts.forgetting --out forgetting.png
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ffgym.agents.learning.forgetting import SEEN_FROM, compare
from ffgym.report import save_figure
from ffgym.report.learning.forgetting_plot import forgetting_figure
from ffgym.robot import load_robot


@dataclass(frozen=True)
class Forgetting:
    """Compare a B-spline network and a perceptron."""

    out: Path = Path("forgetting.png")
    """Figure to write: .png, .svg or .pdf."""
    seed: int = 0
    """Of the perceptron's first weights."""


def main(config: Forgetting) -> None:
    """Run the experiment, write the figure, print the numbers."""
    results = compare(load_robot("one_axis"), np.random.default_rng(config.seed))
    panels = {name: (curves.before, curves.after) for name, curves in results.items()}
    reference = next(iter(results.values()))
    save_figure(forgetting_figure(reference.speed, panels, seen_from=SEEN_FROM), config.out)
    for name, curves in results.items():
        print(f"{name:12s} forgotten {curves.forgotten:7.2%}   missed {curves.missed:7.2%}")
    print(f"figure: {config.out}")


if __name__ == "__main__":
    import tyro

    main(tyro.cli(Forgetting))
