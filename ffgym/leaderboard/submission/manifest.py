"""What a submission says of itself: `manifest.json`."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any, Literal, get_args

from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole
from ffgym.leaderboard.results import Cell
from ffgym.leaderboard.submission.refusal import Refused

FORMAT = 1
"""Version of the format; see docs/leaderboard/submissions.md."""
MANIFEST, ACTIONS = "manifest.json", "actions.npz"
"""Files of every submission, beside that of the agent."""
Track = Literal["causal", "causal, nominal parameters", "per task"]
"""Tracks of submissions; the oracle knows what no agent is told."""
TRACKS: tuple[str, ...] = get_args(Track)
"""Their names."""
AGENT_FILES = {"law": ("agent.npz", "agent.toml"), "policy": ("agent.npz",), "python": ("agent.py",)}
"""Kinds of agents, and how the file of each may be called; a law of the catalogue has none."""

_CHECK = "manifest"
_TEXTS = {"name": 60, "title": 120, "author": 120}
"""Texts, and their greatest lengths."""


@dataclass(frozen=True, kw_only=True)
class AgentSource:
    """Where an agent comes from."""

    kind: str
    """In AGENT_FILES."""
    law: str | None = None
    """Name in the catalogue, for a law that is made from the robot's description, or from a machine file."""
    file: str | None = None
    """Name of its file in the archive; None for a law that needs none."""

    def __post_init__(self) -> None:
        check_choice("kind of agent", self.kind, list(AGENT_FILES))
        if self.file is not None:
            check_choice("agent file", self.file, AGENT_FILES[self.kind])
        if self.law is not None and self.kind != "law":
            raise FFGymError(f"law = {self.law!r} is for agents of kind 'law' alone, this one is {self.kind!r}.")
        if self.file is None and self.law is None:
            raise FFGymError("The agent has neither a file nor the name of a law.")


@dataclass(frozen=True, kw_only=True)
class Claim:
    """Path errors of one circle, in the plane of the circle [mm]."""

    plant: str
    position: str
    radius_mm: float
    speed_mm_s: float
    rms_mm: float
    max_mm: float

    def __post_init__(self) -> None:
        for name in ("plant", "position"):
            if not isinstance(getattr(self, name), str):
                raise FFGymError(f"{name} = {getattr(self, name)!r} must be text.")
        for name in ("radius_mm", "speed_mm_s", "rms_mm", "max_mm"):
            check_number(name, getattr(self, name), low=0.0)

    @classmethod
    def of(cls, plant: str, cell: Cell) -> "Claim":
        """Claim of a cell that was run to its end."""
        assert cell.rms_mm is not None
        assert cell.max_mm is not None
        return cls(
            plant=plant,
            position=cell.position,
            radius_mm=cell.radius_mm,
            speed_mm_s=cell.speed_mm_s,
            rms_mm=cell.rms_mm,
            max_mm=cell.max_mm,
        )

    @property
    def circle(self) -> tuple[str, str, float, float]:
        """Which circle it is."""
        return self.plant, self.position, self.radius_mm, self.speed_mm_s


@dataclass(frozen=True, kw_only=True)
class Manifest:
    """Everything but the files."""

    name: str
    title: str
    author: str
    track: str
    agent: AgentSource
    preview: int
    """Samples of the reference that it sees ahead."""
    action_scale: float
    """Torque of an action of 1 in breakaway torques."""
    seed: int
    """Of the agent's randomness and the sensors' noise."""
    env_steps: int
    """Control steps of simulated training, as its author says."""
    robot_seconds: float
    """Time that a machine moved while it learned [s], as its author says."""
    inference_us: float | None
    """Median time of one decision for one robot [us], as its author says."""
    versions: Mapping[str, str]
    plants: Mapping[str, str]
    """Physics fingerprints by plant."""
    files: Mapping[str, str]
    """sha256 by name."""
    claims: tuple[Claim, ...]

    def __post_init__(self) -> None:
        for name, longest in _TEXTS.items():
            text = getattr(self, name)
            if not isinstance(text, str) or not text.strip() or not text.isprintable() or len(text) > longest:
                raise FFGymError(f"{name} = {text!r} must be a line of 1 to {longest} characters.")
        check_choice("track", self.track, TRACKS)
        check_number("action_scale", self.action_scale, unit="breakaway torques", low=0.0, open_low=True)
        whole = {"preview": (0, 1000), "seed": (0, 2**31 - 1), "env_steps": (0, 2**53)}
        for name, (low, high) in whole.items():
            object.__setattr__(self, name, check_whole(name, getattr(self, name), low=low, high=high))
        check_number("robot_seconds", self.robot_seconds, unit="s", low=0.0)
        if self.inference_us is not None:
            check_number("inference_us", self.inference_us, unit="us", low=0.0)
        for name in ("versions", "plants", "files"):
            entries = getattr(self, name)
            if not isinstance(entries, Mapping) or not all(isinstance(value, str) for value in entries.values()):
                raise FFGymError(f"{name} = {entries!r} must be texts by name.")

    def tree(self) -> dict[str, Any]:
        """For JSON, with format and digest."""
        tree: dict[str, Any] = {"format": FORMAT, **asdict(self)}
        return tree | {"digest": digest_of(tree)}


def digest_of(tree: Mapping[str, Any]) -> str:
    """sha256 of a manifest without its digest, in canonical JSON: sorted keys, no blanks."""
    rest = {key: value for key, value in tree.items() if key != "digest"}
    text = json.dumps(rest, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def encode_manifest(manifest: Manifest) -> bytes:
    """Bytes of manifest.json."""
    return (json.dumps(manifest.tree(), indent=1, allow_nan=False) + "\n").encode()


def decode_manifest(data: bytes) -> Manifest:
    """Manifest from the bytes of manifest.json.

    Raises:
        Refused: if it is damaged, of another format, incomplete or changed.
    """
    try:
        tree = json.loads(data.decode())
    except (ValueError, RecursionError) as error:
        raise Refused(_CHECK, f"{MANIFEST} is no JSON text ({type(error).__name__}).") from error
    found = tree.get("format") if isinstance(tree, dict) else None
    if type(found) is not int or found != FORMAT:  # true equals 1
        raise Refused(_CHECK, f"{MANIFEST} has format {found!r}, this version of ffgym reads {FORMAT}.")
    wanted = {"format", "digest", *(field.name for field in fields(Manifest))}
    if missing := sorted(wanted - set(tree)):
        raise Refused(_CHECK, f"{MANIFEST} lacks {', '.join(missing)}.")
    if unknown := sorted(set(tree) - wanted):
        raise Refused(_CHECK, f"{MANIFEST} has unknown entries: {', '.join(unknown)}.")
    try:
        if digest_of(tree) != tree["digest"]:
            raise Refused(_CHECK, f"{MANIFEST} was changed: its digest is not that of its content.")
        own = {key: value for key, value in tree.items() if key not in ("format", "digest")}
        own |= {"agent": AgentSource(**tree["agent"]), "claims": tuple(Claim(**claim) for claim in tree["claims"])}
        return Manifest(**own)
    except Refused:
        raise
    except (TypeError, ValueError) as error:
        raise Refused(_CHECK, f"{MANIFEST} is not complete: {error}") from error
