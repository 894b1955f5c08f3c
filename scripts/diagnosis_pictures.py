"""Pictures of docs/diagnosis.md: where the model of the example logs is wrong, before and after.

python -m scripts.diagnosis_pictures
"""

from dataclasses import dataclass
from pathlib import Path

import tyro

from ffgym.diagnosis.examples import EXAMPLE_ROBOT, example_logs
from ffgym.diagnosis.log_rows import log_rows
from ffgym.diagnosis.procedure import examine
from ffgym.diagnosis.regimes import regime_map
from ffgym.diagnosis.residual import Residual
from ffgym.report import save_figure
from ffgym.report.diagnosis.map_plot import map_figure
from ffgym.report.diagnosis.models import by_model
from ffgym.report.diagnosis.profiles_plot import profiles_figure
from ffgym.robot import load_robot

DPI = 100
"""Pixels per inch."""

JOINT = 1
"""Place of the joint whose residual is shown over what it depends on: the one that stands out most."""


@dataclass(frozen=True)
class Config:
    """Pictures of the page."""

    out: Path = Path("docs/pictures")
    """Folder for diagnosis_regimes.png and diagnosis_depends.png."""


def drawn(out: Path, before: Residual, after: Residual | None) -> list[Path]:
    """Draw both pictures of the residuals of torque."""
    models = by_model(before, after)
    regimes = map_figure([[(name, regime_map(one, "torque"))] for name, one in models.items()])
    rows = {name: log_rows(one, "torque") for name, one in models.items()}
    depends = profiles_figure(rows, "torque", JOINT, JOINT)
    assert depends is not None
    return [
        save_figure(figure, out / f"diagnosis_{name}.png", DPI)
        for name, figure in (("regimes", regimes), ("depends", depends))
    ]


def main(config: Config) -> list[Path]:
    """Diagnose the example logs and draw."""
    examined = examine(load_robot(EXAMPLE_ROBOT), example_logs())
    assert examined.before is not None
    return drawn(config.out, examined.before, examined.after)


if __name__ == "__main__":
    main(tyro.cli(Config))
