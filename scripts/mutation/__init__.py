"""Mutation testing of the rooms whose numbers others rely on: which changes of their code no test notices.

python -m scripts.mutation                               # all rooms; goes on where it was interrupted
python -m scripts.mutation --rooms statistics --sample 20
"""

import time
from dataclasses import dataclass
from pathlib import Path

from ffgym.core.errors import check_choice, check_number, check_whole
from ffgym.core.files import check_writable, write_json
from ffgym.core.provenance import versions
from scripts.mutation.mutants import draw_mutants, list_mutants
from scripts.mutation.rooms import ROOMS
from scripts.mutation.score import Score, keep_outcome, read_outcomes
from scripts.mutation.testing import Workplace


@dataclass(frozen=True)
class Config:
    """Rooms, and how many of their mutants are tested."""

    rooms: tuple[str, ...] = tuple(ROOMS)
    """Rooms whose mutants are tested."""
    sample: int = 60
    """Mutants of each room, drawn from all that there are; a larger sample of the same seed holds the smaller one."""
    seed: int = 0
    """Seed of the draw."""
    limit: float = 60.0
    """Time of the tests that a mutant meets [s], as they take without it; the fastest files that run its line."""
    again: bool = False
    """Test those that survived again, after tests were written."""
    out: Path = Path("out/mutation")
    """Folder of the copy that is changed, of what tests run which lines, and of the outcomes."""
    json: Path | None = None
    """Also write scores, outcomes and versions to this file."""


def main(config: Config) -> list[Score]:
    """Test the mutants that were not tested yet, and print the score of each room and what survived."""
    for room in config.rooms:
        check_choice("room", room, tuple(ROOMS))
    check_whole("sample", config.sample, low=1)
    check_number("limit", config.limit, unit="s", low=0.0)
    if config.json is not None:
        check_writable(config.json)
    config.out.mkdir(parents=True, exist_ok=True)
    scores = [_test_room(name, config) for name in config.rooms]
    for score in scores:
        print(score)
    if config.json is not None:
        write_json(config.json, {"versions": versions(), "rooms": [score.as_dict() for score in scores]})
    return scores


def _test_room(name: str, config: Config) -> Score:
    """Test the mutants of a room that have no outcome yet."""
    room, kept = ROOMS[name], config.out / f"{name}_seed_{config.seed}.jsonl"
    mutants = list_mutants(room)
    drawn = draw_mutants(mutants, config.sample, config.seed)
    known = {outcome.mutant.key: outcome for outcome in read_outcomes(kept)}
    outcomes = [known[mutant.key] for mutant in drawn if mutant.key in known]
    if config.again:
        outcomes = [outcome for outcome in outcomes if outcome.is_killed]
    there = {outcome.mutant.key for outcome in outcomes}
    missing = [mutant for mutant in drawn if mutant.key not in there]
    if missing:
        watched = config.out / f"{'_'.join(room.tests).replace('/', '-')}.json"
        workplace = Workplace.prepare(config.out / "copy", room, tuple(ROOMS.values()), watched)
        began = time.perf_counter()
        for done, mutant in enumerate(missing, start=1):
            outcome = workplace.test(mutant, config.limit)
            keep_outcome(kept, outcome)
            outcomes.append(outcome)
            left = (time.perf_counter() - began) / done * (len(missing) - done) / 60
            print(f"{name} {len(outcomes)} of {len(drawn)}, {left:.0f} min left: {outcome}", flush=True)
    return Score(room=name, seed=config.seed, n_mutants=len(mutants), outcomes=tuple(outcomes))
