"""Recording of a session into a folder: complete recordings stay, so that an interrupted session can go on."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, islice
from pathlib import Path
from typing import Any, final

from ffgym.control import FeedForwardLaw, NoCompensation
from ffgym.core.errors import FFGymError, check_choice
from ffgym.core.files import check_writable, filled_folder, write_json
from ffgym.core.provenance import versions
from ffgym.recordings import read_recording, write_recording
from ffgym.recordings.io import FORMATS, INDEX, read_index
from ffgym.simulation import RECORD_DT, Rig
from ffgym.simulation.protocols.sessions import SessionMotion, record
from ffgym.simulation.run import Progress

INDEX_VERSION = 1
"""Version of the index."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RecordedSession:
    """Result of recording a session."""

    index: dict[str, Any]
    """Index of the folder."""
    made: int
    """Number of recordings that were made now."""
    kept: int
    """Number of recordings that were complete before."""


def record_into(
    folder: Path,
    motions: Sequence[SessionMotion],
    rig: Rig,
    *,
    law: FeedForwardLaw | None = None,
    seed: int = 0,
    record_dt: float = RECORD_DT,
    origin: Mapping[str, Any] | None = None,
    suffix: str = ".npz",
    force: bool = False,
    n_threads: int = 0,
    progress: Progress | None = None,
) -> RecordedSession:
    """Record a session, one file for each motion, and an index `protocol.json` that is written before them.

    Nothing in the folder is touched before the first recording is there: what cannot be run costs no old one.

    Args:
        folder: is made if there is none.
        motions: from `plan_session`.
        rig: where they are run.
        law: feed-forward law; None is none.
        seed: of the sensors' noise.
        record_dt: sample time of the recordings [s].
        origin: what else there is to say about where the recordings come from, for the index; JSON.
        suffix: format of the recordings, '.npz' or '.csv'.
        force: make recordings again that are complete, and those of another session.
        n_threads: threads of the simulation, 0 for all cores.
        progress: called now and then with the simulated seconds done and their total.

    Raises:
        FFGymError: if the folder holds another session or another process fills it, or something cannot be written or
            run.
    """
    check_choice("format of recordings", suffix, list(FORMATS))
    law = law or NoCompensation()
    index = _index(motions, rig, law, seed, record_dt, dict(origin or {}), suffix)
    with filled_folder(folder):
        _check_session(folder, index, force=force)
        # motions whose recording is missing, or all if forced
        places = [folder / f"{motion.stem}{suffix}" for motion in motions]
        todo = [i for i, place in enumerate(places) if force or not _is_complete(place, index["session"])]
        made = record(
            motions, rig, law=law, seed=seed, record_dt=record_dt, n_threads=n_threads, progress=progress, only=todo
        )
        first = list(islice(made, 1))
        for place in places if force else ():  # so that an interrupted session is not taken for a mixture of two
            try:
                place.unlink(missing_ok=True)
            except OSError as error:
                raise FFGymError(
                    f"{place}: cannot be removed: {error.strerror}; move it away, or choose another place."
                ) from error
        # index first, by which an interrupted session is known again
        write_json(folder / INDEX, index)
        for i, recording in zip(todo, chain(first, made), strict=True):
            provenance = recording.header.provenance | {"session": index["session"]}
            header = replace(recording.header, provenance=provenance)
            write_recording(recording.derive(recording.columns, header), places[i])
    return RecordedSession(index=index, made=len(todo), kept=len(motions) - len(todo))


def _index(
    motions: Sequence[SessionMotion],
    rig: Rig,
    law: FeedForwardLaw,
    seed: int,
    record_dt: float,
    origin: dict[str, Any],
    suffix: str,
) -> dict[str, Any]:
    """Build the index of the folder; `session` is a digest of everything that its recordings depend on."""
    # conditions on which recordings depend
    named = {
        "robot": rig.robot.name,
        "rig": rig.name,
        "physics_fingerprint": rig.fingerprint,
        "feedforward": law.name,
        "seed": seed,
        "record_dt": record_dt,
        "versions": versions(),
    }
    # identity of the session: conditions, law and motions
    digest = hashlib.sha256(json.dumps({**named, **origin}, sort_keys=True).encode())
    digest.update(law.torque(motions[0].reference).tobytes())  # tells laws of one name apart
    for motion in motions:
        digest.update(f"{motion.reference.name} {motion.start!r}".encode() + motion.reference.q.tobytes())
    listed = [
        {
            "name": motion.reference.name,
            "file": f"{motion.stem}{suffix}",
            "protocol": motion.protocol,
            "session_start": motion.start,
            "duration": motion.reference.duration,
        }
        for motion in motions
    ]
    return {"format": INDEX_VERSION, **origin, **named, "session": digest.hexdigest(), "motions": listed}


def _check_session(folder: Path, index: dict[str, Any], *, force: bool) -> None:
    """Check that a folder is for this session."""
    check_writable(folder / INDEX)
    if force or not any(file.suffix.lower() in FORMATS for file in folder.iterdir()):
        return
    try:
        found = read_index(folder)
    except FFGymError as error:
        raise FFGymError(
            f"{folder}: its {INDEX} is damaged, so its recordings cannot be listed. Choose another folder, or say "
            f"--force to write over them."
        ) from error
    if found is None:
        raise FFGymError(f"{folder}: holds recordings, but no {INDEX}; choose another place, or say --force.")
    if found.get("session") != index["session"]:
        raise FFGymError(
            f"{folder}: holds a session of other motions, options or versions; choose another place, or say --force "
            f"to write over its recordings."
        )


def _is_complete(place: Path, session: str) -> bool:
    """Tell if a complete recording of the session is there."""
    if not place.exists():
        return False
    try:
        found = read_recording(place).header.provenance.get("session")
    except FFGymError:  # damaged, as it was written whole: it is made again
        return False
    if found != session:
        raise FFGymError(f"{place}: is not of this session; move it away, or say --force to write over it.")
    return True
