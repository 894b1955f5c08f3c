"""Tables and pictures of documentation pages that are made, not written: one registry, one command.

`python -m scripts.tables` renews the pages that follow from the code or stored results, in seconds, which a
test compares.
`python -m scripts.tables --page physics.md narx.md` renews others, which are simulated or fitted, in minutes.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from ffgym.core.errors import check_choice
from ffgym.core.files import check_writable, write_json
from ffgym.core.provenance import versions
from ffgym.effects import EFFECTS
from ffgym.report import save_figure
from ffgym.robot import builtin_robots
from scripts.tables import (
    claims,
    definitions,
    friction,
    laws,
    leaderboard,
    learning,
    mutation,
    networks,
    package_pages,
    physics,
    published_robot,
    recorded,
    recorded_friction,
    robustness,
    setpoints,
    speed,
    thesis,
    trial,
    validation,
)
from scripts.tables.page import DOCS, DPI, Contents

DEFINED: Mapping[str, Callable[[], Contents]] = {
    "api.md": package_pages.names,
    "architecture.md": package_pages.architecture,
    "claims.md": claims.made_again,
    "column_maps.md": definitions.column_maps,
    "deployment/trial.md": trial.coverage,
    "motion_files.md": definitions.motion_files,
    "mutation.md": mutation.scores,
    "protocols.md": definitions.protocols,
    "quality.md": definitions.quality,
    "recordings.md": definitions.recordings,
    "robot_description.md": definitions.robot_description,
    "robustness.md": robustness.inputs,
    **{f"robots/{name}.md": partial(definitions.robot, name) for name in builtin_robots()},
    "effects/README.md": package_pages.effects,
    **{f"effects/{name}.md": partial(package_pages.effect_page, effect) for name, effect in EFFECTS.items()},
}
"""Pages that follow from the code, by their place in docs/."""

COMPUTED: Mapping[str, Callable[[], Contents]] = {
    "agents/elastic.md": laws.elastic,
    "agents/learning_stability.md": learning.stability,
    "agents/model.md": laws.model,
    "deployment/setpoints.md": setpoints.channels,
    "diagnosis.md": recorded.diagnosis,
    "identification.md": friction.coverage,
    "narx.md": recorded_friction.narx,
    "physics.md": physics.convergence,
    "published_robot.md": published_robot.published_robot,
    "rigid_body_identification.md": recorded.rigid_bodies,
    "torque_prediction.md": recorded.torques,
}
"""Pages with results, which take minutes; functions of the same names take smaller budgets and other robots."""

STORED: Mapping[str, Callable[[], Contents]] = {
    "agents/bspline.md": networks.bspline,
    "agents/feedback_error.md": partial(networks.compare, "none", "lugre_dynamic", "mlp_fel"),
    "agents/lugre.md": networks.lugre,
    "agents/narx.md": partial(networks.compare, "none", "lugre_dynamic", "narx"),
    "agents/residual_torque.md": partial(networks.compare, "none", "lugre_dynamic", "bsn_extended", "residual_gp"),
    "agents/residual.md": leaderboard.residual,
    "leaderboard/README.md": leaderboard.leaderboard,
    "leaderboard/adaptation.md": leaderboard.adaptation,
    "leaderboard/margins.md": leaderboard.margins,
    "performance.md": speed.speed,
    "reproduction.md": thesis.reproduction,
    "validation.md": validation.validation,
}
"""Pages that follow from results that are stored beside them."""

PAGES = {**DEFINED, **STORED, **COMPUTED}


@dataclass(frozen=True)
class Config:
    """Pages to renew, and their place."""

    page: tuple[str, ...] = (*DEFINED, *STORED)
    """Pages to renew, by their place in docs/; none given is all that follow from the code and from stored results."""
    docs: Path = DOCS
    """Folder of the pages."""
    json: Path | None = None
    """Also write the numbers behind the tables to this file."""
    pictures: Path | None = None
    """Also write every picture to this folder, those that no page shows too."""


def main(config: Config) -> dict[str, Contents]:
    """Make the pages; returns what stands on them."""
    for name in config.page:
        check_choice("page", name, list(PAGES))
    if config.json is not None:
        check_writable(config.json)
    made = {}
    for name in config.page:
        made[name] = PAGES[name]()
        made[name].write(config.docs / name)
        print(f"renewed {name}")
    if config.json is not None:
        write_json(config.json, {"versions": versions(), **{name: each.numbers for name, each in made.items()}})
    if config.pictures is not None:
        for contents in made.values():
            for name, figure in contents.pictures.items():
                save_figure(figure, config.pictures / f"{name}.png", DPI)
    return made
