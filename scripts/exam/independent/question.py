"""Draw tasks of the second exam by seed."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from ffgym.core.errors import FFGymError, check_choice, check_whole
from ffgym.diagnosis.nuisance import ParameterPrior
from scripts.exam.independent.hidden import KINDS, Concealed, conceal, possible
from scripts.exam.independent.loudness import loudness
from scripts.exam.independent.machine import numbers_of
from scripts.exam.independent.sensors import Exact, record_log
from scripts.exam.independent.setup import Setup, draw_setup, simulate_machines
from scripts.exam.tasks import Row, Task

COUNTS: Mapping[Row, int] = MappingProxyType({"clean": 200, "single": 180, "outside": 30, "arm": 30, "arm_blind": 20})
"""Questions of a whole exam, by row: nothing hidden; an effect; one outside the library; friction behind the
elasticity, with a tracker and without."""

_TRACKED: Mapping[Row, bool] = MappingProxyType({"arm": True, "arm_blind": False})
"""Kinds of questions about elastic machines, whose logs have a tracker or have none."""

ROWS: tuple[Row, ...] = tuple(COUNTS)
"""Kinds of questions that the second exam asks."""

_KEY = 26
"""Begins the seeds of this exam, so that its questions share no chance with those of the first."""

_SMALLEST = 0.05
"""Least size of an effect, as a share of the largest; log-uniform between."""

_DRAWS = 20
"""Times that an effect is drawn at most until the loop is stable with it; chosen: once is mostly enough."""


@dataclass(frozen=True, kw_only=True, eq=False)
class IndependentTask(Task):
    """A question about a drawn machine."""

    setup: Setup
    """The machine, without what is hidden."""


def draw_task(row: Row, number: int, *, seed: int, **fixed: Any) -> IndependentTask:
    """Question `number` of a row, which these and the seed decide alone; `fixed` is not drawn, see `drawn_setup`.

    Raises:
        FFGymError: if there is no such row, or the machine cannot make its motions.
    """
    check_choice("row of the second exam", row, ROWS)
    key = (_KEY, check_whole("seed", seed, low=0), ROWS.index(row), check_whole("number", number, low=0))
    rng = np.random.default_rng(key)
    setup = draw_setup(rng, **({"elastic": True} if row in _TRACKED else {}) | fixed)
    hidden, heard = None, 0.0
    if row == "clean":
        (exact,) = simulate_machines(setup, [(setup.numbers, setup.view)])
    else:
        name, setup = _kind(row, number, seed, setup, rng)
        hidden, without, exact = _draw_stable(name, setup, rng)
        heard = loudness(setup, without, exact, error=hidden.size if hidden.kind.of_number else 0.0)
    log = record_log(
        setup.robot,
        exact,
        columns=setup.columns,
        noise=setup.noise,
        started=setup.started,
        current_offset=setup.current_offset,
        rng=rng,
    )
    return IndependentTask(
        row=row,
        number=number,
        robot=setup.robot,
        log=tuple(log),
        prior=ParameterPrior.of_share(setup.share),
        truth=() if hidden is None else (hidden.truth(setup.robot, heard),),
        clue=None if hidden is None else hidden.clue(setup.robot),
        conditions=setup.label,
        setup=setup,
    )


def _draw_stable(
    name: str, setup: Setup, rng: np.random.Generator, draws: int = _DRAWS
) -> tuple[Concealed, Exact, Exact]:
    """Draw the joint and the size of an effect, and simulate the machine without it and with it.

    An effect with which the loop is unstable, as with a lag as long as its own delays, is drawn anew.

    Raises:
        FFGymError: if the loop is unstable with all of so many draws.
    """
    share = float(np.exp(rng.uniform(np.log(_SMALLEST), 0.0)))
    drawn = conceal(name, setup.robot, rng, share)
    hidden = replace(drawn, beside=_beside(drawn, setup))
    plain = (setup.numbers, setup.view)
    try:
        without, exact = simulate_machines(setup, [plain, hidden.on(plain)])
    except FFGymError:
        if draws == 1:
            raise
        return _draw_stable(name, setup, rng, draws - 1)
    return hidden, without, exact


def _kind(row: Row, number: int, seed: int, setup: Setup, rng: np.random.Generator) -> tuple[str, Setup]:
    """Kinds in an order by chance, each once in as many questions; columns that it needs are logged."""
    names = [name for name, kind in KINDS.items() if row in kind.asked_in]
    turn, place = divmod(number, len(names))
    order = np.random.default_rng((_KEY, seed, ROWS.index(row), turn)).permutation(len(names))
    name = names[order[place]]
    logged_too = {need: True for need in KINDS[name].needs if need in ("tracker", "temperature")}
    if row in _TRACKED:
        logged_too["tracker"] = _TRACKED[row]
    setup = replace(setup, columns=replace(setup.columns, **logged_too))
    shown = possible(setup.robot, setup.columns)
    if name not in shown:
        name = str(rng.choice([other for other in names if other in shown]))
    return name, setup


def _beside(hidden: Concealed, setup: Setup) -> dict[str, float]:
    """Compute what errors of the description add to the numbers of an effect, by their names."""
    described, j = numbers_of(setup.robot), hidden.index
    if hidden.kind.of_number:
        off = getattr(setup.numbers, hidden.name)[0, j] / getattr(described, hidden.name)[0, j] - 1
        (name,) = (name for name, value in hidden.numbers(setup.robot).items() if value)
        return {name: float(off * (1 + hidden.size))}
    if hidden.name == "peak":  # breakaway beyond what Coulomb friction that is off brings with it
        share = setup.numbers.coulomb[0, j] / described.coulomb[0, j]
        beyond = (setup.numbers.breakaway - share * described.breakaway)[0, j] / described.coulomb[0, j]
        return {"level": float(beyond + (share - 1) * hidden.size)}
    if hidden.name == "offset":
        return {"offset": -float(setup.current_offset[hidden.index])}  # the current says so much more
    if hidden.name == "reflector":
        return {f"offset.{axis}": float(x) for axis, x in zip("xyz", setup.view.offset, strict=True)}
    return {}
