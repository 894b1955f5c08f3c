"""NARX networks beside one another: fits in free run and one step ahead, over random starts.

python -m scripts.narx_table --write docs/narx.md

fits all candidates of `ffgym.studies.narx_study` to data of the LuGre model, as thesis 6.2, and renews the tables of
the page. Takes about two minutes, of which the fit in free run is one.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import tyro

from ffgym.core.files import check_writable, write_json, write_text
from ffgym.core.provenance import versions
from ffgym.core.types import Array
from ffgym.robot import load_robot
from ffgym.studies.narx_study import (
    ESTIMATION,
    EXTENDED,
    N_STARTS,
    OTHERS,
    PUBLISHED,
    VALIDATION,
    NarxFit,
    fit_narx,
    narx_records,
    reach_records,
    record_name,
    static_misfit,
)
from scripts.convergence_table import renewed
from scripts.thesis.tables import VALIDATING, spread

CANDIDATES = {each.name: each for each in (*PUBLISHED, *OTHERS, *EXTENDED)}


@dataclass(frozen=True)
class Config:
    """Tables of NARX networks."""

    candidates: tuple[str, ...] = tuple(CANDIDATES)
    """Names of those to fit."""
    n_starts: int = N_STARTS
    """Random starts of each."""
    seed: int = 0
    """Of their first weights."""
    json: Path | None = None
    """Numbers as JSON."""
    write: Path | None = None
    """Markdown file whose tables are renewed, docs/narx.md."""


def main(config: Config) -> list[NarxFit]:
    """Fit, print the tables; write what is asked for."""
    for path in (config.json, config.write):
        if path is not None:
            check_writable(path)
    friction = load_robot("one_axis").friction
    records, reach = narx_records(friction), reach_records(friction)
    floors = {name: static_misfit(friction, each).fit for name, each in (records | reach).items()}
    fits = [
        fit_narx(CANDIDATES[name], records | reach, n_starts=config.n_starts, seed=config.seed)
        for name in config.candidates
    ]
    tables = {"fits": _fits(fits, floors), "reach": _reach(fits, floors, list(reach))}
    print("\n\n".join(tables.values()))
    if config.json is not None:
        write_json(
            config.json, {"config": _plain(config), "versions": versions(), "fits": [_numbers(fit) for fit in fits]}
        )
    if config.write is not None:
        write_text(config.write, renewed(config.write.read_text(encoding="utf-8"), tables))
    return fits


def _fits(fits: Sequence[NarxFit], floors: dict[str, Array]) -> str:
    """Estimation, validation, one step ahead, and set V."""
    v = np.stack([floors[record_name(n)] for n in VALIDATING])
    floor = [floors[ESTIMATION], floors[VALIDATION], None, np.median(v, axis=0), v.min(axis=0)]
    rows = [("static curve", ["" if each is None else f"{each[0]:.1f}" for each in floor])]
    for fit in fits:
        v = np.stack([fit.errors[record_name(n)].simulation.fit for n in VALIDATING])
        columns = [fit.errors[name].simulation.fit for name in (ESTIMATION, VALIDATION)]
        columns += [fit.errors[VALIDATION].prediction.fit, np.median(v, axis=0), v.min(axis=0)]
        rows.append((fit.candidate.label, [spread(each) for each in columns]))
    return _markdown(["f = 1", "f = 0.5", "f = 0.5, one step", "set V, median record", "set V, worst record"], rows)


def _reach(fits: Sequence[NarxFit], floors: dict[str, Array], names: Sequence[str]) -> str:
    """Motions unlike Table 6.1."""
    rows = [("static curve", [f"{floors[name][0]:.1f}" for name in names])]
    rows += [(fit.candidate.label, [spread(fit.errors[name].simulation.fit) for name in names]) for fit in fits]
    return _markdown(names, rows)


def _markdown(headings: Sequence[str], rows: Sequence[tuple[str, Sequence[str]]]) -> str:
    lines = ["| | " + " | ".join(headings) + " |", "|---" * (len(headings) + 1) + "|"]
    return "\n".join([*lines, *(f"| {label} | " + " | ".join(cells) + " |" for label, cells in rows)])


def _numbers(fit: NarxFit) -> dict[str, object]:
    errors = {
        name: {"prediction_rms_nm": each.prediction.rms.tolist(), "simulation_rms_nm": each.simulation.rms.tolist()}
        for name, each in fit.errors.items()
    }
    return {"candidate": asdict(fit.candidate), "errors": errors}


def _plain(config: Config) -> dict[str, object]:
    return {name: str(value) if isinstance(value, Path) else value for name, value in asdict(config).items()}


if __name__ == "__main__":
    main(tyro.cli(Config))
