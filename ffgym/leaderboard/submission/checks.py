"""What a submission says, compared with what is found: files, physics, logged actions, errors."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.files import decode_arrays
from ffgym.core.types import Array
from ffgym.leaderboard.plants import plant_named
from ffgym.leaderboard.submission.archive import check_arrays, sha256_of
from ffgym.leaderboard.submission.manifest import ACTIONS, MANIFEST, Claim, Manifest
from ffgym.leaderboard.submission.plan import actions_name, controller_of
from ffgym.leaderboard.submission.refusal import Refused
from ffgym.leaderboard.tasks import Task
from ffgym.robot import load_robot
from ffgym.studies import in_mm

SCORE_TOLERANCE = 1e-4
"""Relative difference of errors that is allowed. On one machine they are the same bit for bit. Another processor rounds
in the sixteenth digit; noise in the seventh digit of every observation changes errors by 1e-8, which a test repeats.
Chosen: far above that, and far below what tells agents apart."""
SCORE_FLOOR_MM = 1e-6
"""Difference of errors that is always allowed [mm], for the same reason."""
ACTION_TOLERANCE = 1e-3
"""Difference of actions that is allowed, in the largest logged one of that motor and task. The same noise changes them
by 3e-7; chosen as errors are, with room for agents of high gain."""


def check_files(manifest: Manifest, files: Mapping[str, bytes]) -> None:
    """Check that the files are those of the manifest.

    Raises:
        Refused: if one is missing, changed, not named, or unpacks to more than a submission may hold.
    """
    agent = manifest.agent.file
    wanted = {ACTIONS} | ({agent} if agent is not None else set())
    if set(manifest.files) != wanted:
        raise Refused("files", f"the manifest names {_listed(manifest.files)}, must name {_listed(wanted)}.")
    if missing := wanted - set(files):
        raise Refused("files", f"{_listed(missing)} is missing.")
    if unknown := set(files) - wanted - {MANIFEST}:
        raise Refused("files", f"{_listed(unknown)} is no file of a submission; take it out.")
    for name in sorted(wanted):
        if sha256_of(files[name]) != manifest.files[name]:
            what = "logged actions" if name == ACTIONS else "weights"
            raise Refused("files", f"{what} were changed: {name} has not the sha256 that the manifest gives.")
        if name.endswith(".npz"):
            check_arrays(name, files[name])


def check_physics(manifest: Manifest, tasks: Mapping[str, Sequence[Task]]) -> None:
    """Check that claims are about the plants here, and about all circles that are wanted.

    Raises:
        Refused: if not.
    """
    if set(manifest.plants) != set(tasks):
        raise Refused("physics", f"it was run on {_listed(manifest.plants)}, must be run on {_listed(tasks)}.")
    for name in tasks:
        here, there = plant_named(name).fingerprint, manifest.plants[name]
        if here != there:
            raise Refused(
                "physics",
                f"{name} has fingerprint {here} here, and {there} in the manifest: it was packed with other physics "
                f"({_version_text(manifest)}). Pack it again with this version.",
            )
    wanted = {
        (name, task.position, in_mm(radius), in_mm(task.speed))
        for name, each in tasks.items()
        for task in each
        for radius in task.radii
    }
    claimed = [claim.circle for claim in manifest.claims]
    if set(claimed) != wanted or len(claimed) != len(wanted):
        raise Refused("manifest", f"it claims {len(claimed)} circles that are not the {len(wanted)} which are run.")


def logged_actions(data: bytes, tasks: Mapping[str, Sequence[Task]]) -> dict[str, list[Array]]:
    """Actions by plant, one array (T, N) for each of its tasks.

    Raises:
        Refused: if they are not complete, or no finite numbers in [-1, 1] of the right shape.
    """
    try:
        arrays = decode_arrays(data)
    except FFGymError as error:
        raise Refused("files", f"{ACTIONS}: {error}") from error
    wanted = {actions_name(name, k): name for name, each in tasks.items() for k in range(len(each))}
    if set(arrays) != set(wanted):
        raise Refused("files", f"{ACTIONS} holds {_listed(arrays)}, must hold {_listed(wanted)}.")
    for key, array in arrays.items():
        n = load_robot(controller_of(wanted[key])).n_joints
        if array.dtype != np.float32 or array.ndim != 2 or array.shape[1] != n or not len(array):
            raise Refused(
                "files",
                f"{key} in {ACTIONS} is {array.dtype} of shape {array.shape}, must be float32 of shape (T, {n}).",
            )
        if not np.all(np.abs(array) <= 1.0):
            raise Refused("files", f"{key} in {ACTIONS} holds NaN, or actions beyond -1 and 1.")
    return {
        name: [arrays[actions_name(name, k)].astype(np.float64) for k in range(len(each))]
        for name, each in tasks.items()
    }


def check_claims(claimed: Sequence[Claim], found: Sequence[Claim], check: str) -> None:
    """Check that errors are the claimed ones.

    Raises:
        Refused: if one is not.
    """
    here = {claim.circle: claim for claim in found}
    for claim in claimed:
        for name in ("rms_mm", "max_mm"):
            said, is_ = getattr(claim, name), getattr(here[claim.circle], name)
            if abs(said - is_) > max(SCORE_FLOOR_MM, SCORE_TOLERANCE * is_):
                plant, position, radius, speed = claim.circle
                raise Refused(
                    check,
                    f"it claims {name} = {said:.6g} for r = {radius:g} mm at {speed:g} mm/s, {position}, on {plant}, "
                    f"and {is_:.6g} comes out.",
                )


def check_actions(logged: Array, found: Array, where: str) -> float:
    """Check that actions (T, N) are the logged ones; returns the largest difference, in the largest of each motor.

    Raises:
        Refused: if they are not.
    """
    if logged.shape != found.shape:
        raise Refused("agent", f"on {where} it acts {len(found)} times, {len(logged)} actions were logged.")
    return check_first_actions(logged, found, where)


def check_first_actions(logged: Array, found: Array, where: str) -> float:
    """As `check_actions`, for the first actions of a motion.

    Raises:
        Refused: if they are not the logged ones.
    """
    largest = np.maximum(np.abs(logged).max(axis=0), np.finfo(np.float32).tiny)
    difference = np.abs(logged[: len(found)] - found) / largest
    worst = float(difference.max())
    if worst > ACTION_TOLERANCE:
        step, motor = np.unravel_index(int(difference.argmax()), difference.shape)
        raise Refused(
            "agent",
            f"on {where} it does not decide what was logged: at step {step}, motor {motor + 1}, "
            f"{found[step, motor]:.6g}, logged {logged[step, motor]:.6g}.",
        )
    return worst


def _listed(names: Iterable[str]) -> str:
    return ", ".join(sorted(names)) or "nothing"


def _version_text(manifest: Manifest) -> str:
    return ", ".join(f"{name} {manifest.versions.get(name, 'unknown')[:20]}" for name in ("ffgym", "mujoco"))
