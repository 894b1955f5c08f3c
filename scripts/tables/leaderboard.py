"""Tables of the pages about the leaderboard, from the results that are stored beside them; seconds of statistics."""

import json
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from ffgym.agents.adapters import ADAPTERS
from ffgym.agents.artefacts import TRAINED
from ffgym.agents.entrants import ENTRANTS, REGISTRY
from ffgym.core.files import read_text
from ffgym.leaderboard.adaptation.results import AdaptationRun, read_results
from ffgym.leaderboard.board import Board
from ffgym.leaderboard.comparison.samples import DRAWS, GROUPS, WORKCELLS
from ffgym.leaderboard.comparison.standings import AgainstBase, Standing, Standings, standings
from ffgym.leaderboard.plants import NOMINAL, THESIS_WORKCELL
from ffgym.leaderboard.presentation.figures import share
from ffgym.leaderboard.presentation.table import format_standings
from ffgym.leaderboard.presentation.words import group_title
from ffgym.leaderboard.results import Row
from scripts.adaptation import NOMINAL as NOMINAL_ADAPTED
from scripts.adaptation import format_table
from scripts.adaptation_bounds import format_bounds
from scripts.claims.records import numbers_of
from scripts.tables.page import DOCS, Contents, markdown

RESULTS = DOCS / "leaderboard" / "results"
ADAPTATION = DOCS / "leaderboard" / "adaptation.json"

SETPOINTS = ("elastic", "elastic_setpoints", "elastic_setpoints_late")
"""Rows of one law through both channels."""
GAINS = {"servo_gains": ", unstable", "servo_gains_drives": ", unstable", "servo_gains_stable": ""}
"""Rows of servo gains, and what stands behind their names."""
RESIDUALS = (
    "servo_gains",
    "ppo_elastic",
    "sac_elastic",
    "recurrent_ppo_elastic",
    "ppo_elastic_memory",
    "ppo_lugre",
    "ppo_none",
)
"""Rows of the table of residual policies."""
SEARCHED = {"ppo": "PPO", "recurrent_ppo": "recurrent PPO", "sac": "SAC", "tqc": "TQC"}
"""Algorithms whose search for hyper-parameters is stored."""
_SEARCHED_NUMBERS = {
    "learning_rate": ("learning rate", ".4f"),
    "first_std": ("first std", ".2f"),
    "bound": ("bound", ".2f"),
    "gamma": ("gamma", ".2f"),
    "gae_lambda": ("GAE lambda", ".2f"),
    "clip_range": ("clip range", ".2f"),
    "first_ent_coef": ("first entropy weight", ".2g"),
    "entropy_per_motor": ("entropy per motor", ".2f"),
}
"""Headings and formats of the numbers that are searched."""


@cache
def stored_rows() -> Mapping[str, Row]:
    """Read the rows in docs/leaderboard/results in the order of the entrants."""
    rows = Board(registry=REGISTRY, folder=RESULTS).rows
    return {name: rows[name] for name in ENTRANTS if name in rows}


@cache
def held_out(group: str) -> Standings:
    """Compare all stored rows on held-out circles of a group of plants."""
    return standings(list(stored_rows().values()), group, "held_out")


def row_of(group: str, name: str) -> Standing:
    """Find a row on a group of plants, where it must have been run."""
    line = held_out(group).line(name)
    assert line is not None, (group, name)
    return line


@cache
def adapted() -> tuple[AdaptationRun, ...]:
    """Read the runs of the curve of adaptation."""
    return read_results(ADAPTATION).runs


def leaderboard() -> Contents:
    """Standings on drawn workcells and on the thesis' one, and one law through both channels."""
    channels = []
    for group in GROUPS:
        scores = [row_of(group, name).score for name in SETPOINTS]
        channels.append((group_title(group), *(share(each.left, each.left_interval).plain for each in scores)))
    return Contents(
        parts={
            "drawn workcells": f"```\n{format_standings(held_out(WORKCELLS))}\n```",
            "workcell thesis": f"```\n{format_standings(held_out(THESIS_WORKCELL))}\n```",
            "channels": markdown(("plants", *(f"`{name}`" for name in SETPOINTS)), channels),
        }
    )


def margins() -> Contents:
    """Stability margins of all rows with feedback by seed, and what servo gains leave of their base."""
    rows = []
    for name, row in stored_rows().items():
        gains = ", ".join(f"{each.gain:.2f}" for each in row.margins)
        delays = ", ".join("none" if each.delay_ms is None else f"{each.delay_ms:g}" for each in row.margins)
        rows += [(f"`{name}`", gains, delays)] if row.margins else []
    left, groups = [], (WORKCELLS, THESIS_WORKCELL, DRAWS)
    for name, words in GAINS.items():
        each = [of_base(row_of(group, name).against_base) for group in groups]
        left.append((f"`{name}`{words}", _validation(name), *each))
    machines = ("validation", "ten drawn workcells", "workcell `thesis`", "20 drawn robots")
    head = ("error left of that of `elastic`", *machines)
    return Contents(
        parts={
            "margins": markdown(("agent", "gain margin, by seed", "delay margin [ms], by seed"), rows),
            "gains": markdown(head, left),
        }
    )


def header_of(name: str) -> dict[str, Any]:
    """Read the header of the servo gains of a row: their search, and ln(error / that of the base) on the validation."""
    with np.load(TRAINED / name / "any" / "seed_0.npz") as file:
        header: dict[str, Any] = json.loads(str(file["header"]))
    return header


def _validation(name: str) -> str:
    """Error left of that of the base on the validation on machines with drives; empty for gains of another one."""
    return "" if name == "servo_gains" else f"{np.exp(header_of(name)['meta']['log_ratio']):.2f}"


def of_base(found: AgainstBase | None) -> str:
    """Format the error left of that of the base, with its interval."""
    assert found is not None
    assert found.difference is not None
    spread = found.difference.interval
    return f"{found.difference.ratio:.2f}" + ("" if spread is None else f" [{spread.low:.2f}, {spread.high:.2f}]")


def adaptation() -> Contents:
    """Error left over motion of the robot, on drawn workcells and on the nominal robot, and what true numbers leave."""
    cells = list(dict.fromkeys(run.machine for run in adapted() if run.machine != NOMINAL_ADAPTED))
    bounds = {
        f"bounds of {title}": format_bounds(title, {name: np.array(values) for name, values in left.items()})
        for title, left in numbers_of("adaptation_bounds").items()
    }
    return Contents(
        parts={
            "drawn workcells": format_table(adapted(), ADAPTERS, cells),
            "nominal robot": format_table(adapted(), ADAPTERS, [NOMINAL_ADAPTED]),
            **bounds,
        }
    )


def residual() -> Contents:
    """Searches for hyper-parameters, every trial of each, and what residual policies leave of their base."""
    rows = []
    for name in RESIDUALS:
        row = stored_rows()[name]
        each = [of_base(row_of(group, name).against_base) for group in (THESIS_WORKCELL, DRAWS, NOMINAL)]
        own, base = (_errors(which) for which in (name, str(row.base)))
        learned = "" if row.seeded else ", not learned"
        rows.append((f"`{name}`{learned}", f"`{row.base}`", *each, f"{own} ({base})"))
    head = ("row", "base", "workcell", "20 drawn robots", "nominal robot", "workcell [um]")
    searches = {f"search of {title}": _search(algorithm) for algorithm, title in SEARCHED.items()}
    return Contents(parts={**searches, "results": markdown(head, rows)})


def _errors(name: str, speeds: Sequence[float] = (10, 40, 100)) -> str:
    """RMS path errors on the workcell at some speeds [um]."""
    scores = {each.speed_mm_s: each.rms_um for each in row_of(THESIS_WORKCELL, name).score.speeds}
    return ", ".join(f"{scores[speed]:.3g}" for speed in speeds)


def search_of(algorithm: str) -> dict[str, Any]:
    """Read the record of a search for hyper-parameters."""
    found: dict[str, Any] = json.loads(read_text(DOCS / "agents" / f"tuned_{algorithm}_drives.json"))
    return found


def _search(algorithm: str) -> str:
    """Table of the trials of a search, the best first."""
    trials = sorted(search_of(algorithm)["trials"], key=lambda trial: trial["value"])
    names = [name for name in _SEARCHED_NUMBERS if name in trials[0]["parameters"]]
    rows = [
        (f"{trial['value']:+.3f}", *(format(trial["parameters"][name], _SEARCHED_NUMBERS[name][1]) for name in names))
        for trial in trials
    ]
    return markdown(("value", *(_SEARCHED_NUMBERS[name][0] for name in names)), rows)
