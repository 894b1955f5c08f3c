"""Files of the leaderboard: results, adaptation, rounds and submissions."""

import json
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import numpy as np

from ffgym.core.files import decode_arrays, encode_arrays
from ffgym.core.typed_json import from_json, parse_json
from ffgym.leaderboard.adaptation.results import AdaptationResults, AdaptationRun, read_results, write_results
from ffgym.leaderboard.comparison.standings import standings
from ffgym.leaderboard.plants import NOMINAL
from ffgym.leaderboard.presentation.table import format_standings
from ffgym.leaderboard.results import CircleResult, Outcome, Row, decode_row, encode_row, read_row
from ffgym.leaderboard.submission.judge import read_logged_actions
from ffgym.leaderboard.submission.manifest import (
    ACTIONS,
    MANIFEST,
    About,
    AgentSource,
    Claim,
    Manifest,
    decode_archive,
    decode_manifest,
    decode_submission,
    digest_of,
    encode_archive,
    read_archive,
    sha256_of,
)
from ffgym.leaderboard.submission.rounds import draw_round, read_commitment, read_round
from ffgym.leaderboard.tasks import SPLITS, Task
from scripts.fuzz.reader import Reader
from scripts.fuzz.readers.samples import sample_of

_CIRCLES = [(split, "p1", radius, speed) for split in SPLITS for radius in (1.0, 3.0) for speed in (10.0, 40.0)]
_TASKS = {NOMINAL: [Task("p2", 0.1, (0.001,), "positions")]}


def _row(name: str, scale: float) -> Row:
    """A row with two seeds on the nominal plant."""
    cells = tuple(
        CircleResult(
            split=split,
            position=position,
            radius_mm=radius,
            speed_mm_s=speed,
            rms_mm=scale * speed,
            max_mm=2 * scale * speed,
            rms_3d_mm=scale * speed,
            max_3d_mm=2 * scale * speed,
            motor_rms_rad=(scale,) * 6,
        )
        for split, position, radius, speed in _CIRCLES
    )
    row: Row = from_json(Row, sample_of(Row), "row")
    outcome = replace(row.outcomes[0], plant=NOMINAL, fingerprint="0123456789abcdef", cells=cells, trails=())
    outcomes: tuple[Outcome, ...] = tuple(replace(outcome, seed=seed) for seed in range(2))
    ranked = name != "none"
    return replace(
        row, name=name, base=None, ranked=ranked, outcomes=outcomes, setpoints=None, feedback=False, track="causal"
    )


def _make_rows(folder: Path) -> Path:
    """Results of zero action and of an agent."""
    for name, scale in (("none", 1e-2), ("mine", 6e-3)):
        (folder / f"{name}.json").write_text(encode_row(_row(name, scale)), encoding="utf-8")
    return folder / "mine.json"


def _compare(path: Path) -> None:
    """Read results, and rank them as the page does."""
    rows = [read_row(file) for file in sorted(path.parent.glob("*.json"))]
    if {row.name for row in rows} >= {"none"} and len(rows) == 2:
        format_standings(standings(rows, NOMINAL, "held_out"))


def _make_adaptation(folder: Path) -> Path:
    run: AdaptationRun = from_json(AdaptationRun, sample_of(AdaptationRun), "run")
    runs = tuple(replace(run, seed=seed, rms_um=(10.0, None)) for seed in range(2))
    write_results(folder / "adaptation.json", AdaptationResults(motions=("p1", "p2"), lap="p1", runs=runs))
    return folder / "adaptation.json"


def _make_round(folder: Path) -> Path:
    found = replace(draw_round(), seed=7, salt="ab" * 32)
    (folder / "round.json").write_text(json.dumps(found.list_revealed()), encoding="utf-8")
    return folder / "round.json"


def _read_round(path: Path) -> None:
    read_commitment(path)
    read_round(path)


def _make_submission(folder: Path) -> Path:
    """A submission of a law with its file, whose hashes fit."""
    actions = encode_arrays({f"{NOMINAL}_0": np.zeros((20, 6), dtype=np.float32)})
    agent = encode_arrays({"header": np.array("{}"), "weights": np.zeros(4)})
    about = About(name="mine", title="an agent", author="somebody", track="causal, nominal parameters")
    manifest = Manifest(
        **vars(about),
        agent=AgentSource(kind="law", file="agent.npz"),
        preview=1,
        action_scale=10.0,
        versions={"ffgym": "1"},
        plants={NOMINAL: "0123456789abcdef"},
        files={ACTIONS: sha256_of(actions), "agent.npz": sha256_of(agent)},
        claims=(Claim(plant=NOMINAL, position="p2", radius_mm=1.0, speed_mm_s=100.0, rms_mm=0.1, max_mm=0.2),),
    )
    files = {MANIFEST: json.dumps(manifest.tree()).encode(), ACTIONS: actions, "agent.npz": agent}
    (folder / "mine.zip").write_bytes(encode_archive(files))
    return folder / "mine.zip"


def _sign(data: bytes) -> bytes:
    """Give the manifest the hashes of the files, and its own digest, as an attacker would."""
    try:
        files = decode_archive(data)
        tree = json.loads(files[MANIFEST])
        tree["files"] = {name: sha256(files[name]).hexdigest() for name in tree["files"]}
        tree["digest"] = digest_of(tree)
        return encode_archive(files | {MANIFEST: json.dumps(tree).encode()})
    except Exception:  # damaged so far that no hash helps
        return data


def _read_submission(path: Path) -> None:
    _, files = decode_submission(read_archive(path))
    read_logged_actions(files[ACTIONS], _TASKS)


READERS = (
    Reader(
        name="results",
        use=_compare,
        makes=(_make_rows,),
        covers=(read_row, decode_row, parse_json, from_json),
        share=25,
    ),
    Reader(name="adaptation", use=read_results, makes=(_make_adaptation,), covers=(read_results,), share=15),
    Reader(name="round", use=_read_round, makes=(_make_round,), covers=(read_commitment, read_round), share=12),
    Reader(
        name="submission",
        use=_read_submission,
        makes=(_make_submission,),
        covers=(read_archive, decode_archive, decode_submission, decode_manifest, read_logged_actions, decode_arrays),
        share=15,
        repair=_sign,
    ),
)
