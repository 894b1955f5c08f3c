"""From an agent to its submission: run it as it will be run when it is checked, and pack what came out."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

from ffgym.core.files import encode_arrays
from ffgym.core.provenance import versions
from ffgym.core.types import Array
from ffgym.leaderboard.plants import plant_named
from ffgym.leaderboard.submission import plan as plans
from ffgym.leaderboard.submission.alone import check_alone
from ffgym.leaderboard.submission.archive import decode_archive, encode_archive, sha256_of
from ffgym.leaderboard.submission.checks import check_files
from ffgym.leaderboard.submission.limits import Limits
from ffgym.leaderboard.submission.manifest import ACTIONS, MANIFEST, AgentSource, Claim, Manifest, encode_manifest
from ffgym.leaderboard.submission.plan import Plan, actions_name, controller_of
from ffgym.leaderboard.submission.process import AgentProcess
from ffgym.leaderboard.submission.runs import (
    Contract,
    Stage,
    Watched,
    claims_of,
    run,
    silent,
)
from ffgym.robot import load_robot

_NO_ACTIONS = encode_arrays({})


@dataclass(frozen=True, kw_only=True)
class About:
    """What the author says; see `Manifest`."""

    name: str
    title: str
    author: str
    track: str
    seed: int = 0
    env_steps: int = 0
    robot_seconds: float = 0.0
    inference_us: float | None = None


@dataclass(frozen=True, kw_only=True)
class Packed:
    """A submission, and what was seen while it was made."""

    data: bytes
    """The ZIP file."""
    manifest: Manifest
    inference_us: float
    """Median time of one decision for one robot on the first plant [us], on this machine; not in the file, whose
    bytes are the same on every run."""


def pack(
    about: About,
    source: AgentSource,
    content: bytes | None,
    *,
    loaders: Mapping[str, str],
    plan: Plan | None = None,
    limits: Limits | None = None,
    n_threads: int = 0,
    stage: Stage = silent,
) -> Packed:
    """Run an agent in a process of its own on every plant of the plan, and pack it.

    Args:
        about: what its author says.
        source: what it is made from.
        content: of its file; None if there is none.
        loaders: modules that load agents, by kind.
        plan: what it is run on; None is the standard.
        limits: what it may use.
        n_threads: of the simulation, 0 for all cores.
        stage: shows how far the work is.

    Raises:
        FFGymError: if something that the author says is not valid.
        Refused: if the agent cannot be made, fails, is too slow or too large, decides otherwise when it is alone, or
            does what it must not.
    """
    chosen = plan or plans.STANDARD
    arrays: dict[str, Array] = {}
    claims: list[Claim] = []
    contracts: list[Contract] = []
    times_us: list[float] = []
    draft = _manifest(about, source, content, Contract(1, 1.0), _NO_ACTIONS, chosen, ())
    _archive(draft, content, _NO_ACTIONS)  # complain now, not after minutes
    for name, tasks in chosen.tasks.items():
        robot = controller_of(name)
        start = partial(AgentProcess, source, content, robot, loaders=loaders, seed=about.seed, limits=limits)
        with start() as agent:
            contract, watched = Contract(agent.preview, agent.action_scale), Watched(agent)
            flights = run(
                name, tasks, contract, watched, seed=about.seed, n_threads=n_threads, stage=stage, title="running"
            )
        contracts.append(contract)
        if not times_us:  # once, as when it is checked
            logged, control_dt = [each.actions for each in flights], load_robot(robot).servo.control_dt
            times_us.append(check_alone(start, contract, control_dt, logged, watched.seen, name))
        claims += claims_of(name, tasks, flights, "replay")
        arrays |= {actions_name(name, k): each.actions.astype("<f4") for k, each in enumerate(flights)}
    actions = encode_arrays(arrays)
    manifest = _manifest(about, source, content, contracts[0], actions, chosen, tuple(claims))
    return Packed(data=_archive(manifest, content, actions), manifest=manifest, inference_us=times_us[0])


def _archive(manifest: Manifest, content: bytes | None, actions: bytes) -> bytes:
    """ZIP file of a submission.

    Raises:
        Refused: if it would not be taken where it is checked.
    """
    files = {MANIFEST: encode_manifest(manifest), ACTIONS: actions}
    if manifest.agent.file is not None and content is not None:
        files[manifest.agent.file] = content
    data = encode_archive(files)
    check_files(manifest, decode_archive(data))
    return data


def _manifest(
    about: About,
    source: AgentSource,
    content: bytes | None,
    contract: Contract,
    actions: bytes,
    plan: Plan,
    claims: tuple[Claim, ...],
) -> Manifest:
    files = {ACTIONS: sha256_of(actions)}
    if source.file is not None and content is not None:
        files[source.file] = sha256_of(content)
    said: dict[str, Any] = asdict(about)
    return Manifest(
        **said,
        agent=source,
        preview=contract.preview,
        action_scale=contract.action_scale,
        versions=versions(),
        plants={name: plant_named(name).fingerprint for name in plan.tasks},
        files=files,
        claims=claims,
    )
