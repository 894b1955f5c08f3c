"""Submission as a ZIP file: a manifest, logged actions, the agent's file; read without trust in its contents."""

import hashlib
import io
import json
import os
import stat
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from ffgym.control.observation import CHANNELS, Channel
from ffgym.core.errors import FFGymError, check_choice, check_number, check_whole
from ffgym.core.files import read_bytes
from ffgym.core.typed_json import from_json, parse_json

FORMAT = 1
"""Version of the format; see docs/leaderboard/submissions.md."""
MANIFEST, ACTIONS = "manifest.json", "actions.npz"
"""Files of every submission, beside that of the agent."""
Track = Literal["causal", "causal, nominal parameters", "per task"]
"""Tracks of submissions; the oracle has the truth, which no submission gets."""
AGENT_FILES = {"law": ("agent.npz", "agent.toml"), "policy": ("agent.npz",), "python": ("agent.py",)}
"""Kinds of agents, and the names that the file of each may have; a law of the catalogue has none."""
LARGEST = 64 * 2**20
"""Bytes of a submission, unpacked, all files together; chosen: thousand times a residual policy of this package."""
MOST = 8
"""Largest number of files that are read; a submission has three at most, and a refusal names the rest."""
LONGEST = 500
"""Largest number of letters of a reason."""


class Refused(FFGymError):
    """A submission that is not accepted, by the name of a check in `judge.CHECKS` and the reason."""

    def __init__(self, check: str, reason: str, whose: str = "") -> None:
        plain = "".join(letter if letter.isprintable() else "?" for letter in reason)  # it may be an agent's own words
        self.check, self.reason = check, plain if len(plain) <= LONGEST else plain[: LONGEST - 3] + "..."
        super().__init__(f"{whose}refused, {check}: {self.reason}")


@dataclass(frozen=True, kw_only=True)
class AgentSource:
    """Source of an agent: its kind, and the name of a law or of a file."""

    kind: str
    """Kind of the agent, in AGENT_FILES."""
    law: str | None = None
    """Name in the catalogue, for a law that is made from the robot's description, or from a machine file."""
    file: str | None = None
    """Name of its file in the archive; None for a law that needs none."""

    def __post_init__(self) -> None:
        names = AGENT_FILES[check_choice("kind of agent", self.kind, list(AGENT_FILES))]
        if self.file is not None:
            check_choice("agent file", self.file, names)
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
        for name in ("radius_mm", "speed_mm_s", "rms_mm", "max_mm"):
            check_number(name, getattr(self, name), low=0.0)

    @property
    def circle(self) -> tuple[str, str, float, float]:
        """Identity of the circle: plant, position, radius [mm], speed [mm/s]."""
        return self.plant, self.position, self.radius_mm, self.speed_mm_s


@dataclass(frozen=True, kw_only=True)
class About:
    """Statements of the author of a submission."""

    name: str
    title: str
    author: str
    track: str
    """Track, in `Track`."""
    seed: int = 0
    """Seed of the agent's randomness and the sensors' noise."""
    feedback: bool = True
    """True if it observes errors of the motors: track with feedback."""
    channel: Channel = "torque"
    """Quantity that its actions are added to."""
    env_steps: int = 0
    """Control steps of simulated training."""
    robot_seconds: float = 0.0
    """Time that a machine moved while it learned [s]."""
    inference_us: float | None = None
    """Median time of one decision for one robot [us]."""

    def __post_init__(self) -> None:
        for name, longest in {"name": 60, "title": 120, "author": 120}.items():
            text = getattr(self, name)
            if not text.strip() or not text.isprintable() or len(text) > longest:
                raise FFGymError(f"{name} = {text!r} must be a line of 1 to {longest} characters.")
        check_choice("track", self.track, get_args(Track))
        check_choice("channel", self.channel, CHANNELS)
        check_whole("seed", self.seed, low=0, high=2**31 - 1)
        check_whole("env_steps", self.env_steps, low=0, high=2**53)
        check_number("robot_seconds", self.robot_seconds, unit="s", low=0.0)
        if self.inference_us is not None:
            check_number("inference_us", self.inference_us, unit="us", low=0.0)


@dataclass(frozen=True, kw_only=True)
class Manifest(About):
    """Manifest: everything but the files."""

    agent: AgentSource
    preview: int
    """Samples of the reference that the agent observes ahead."""
    action_scale: float
    """Size of an action of 1: torque in breakaway torques f_s, position of set-points in f_s / K_p."""
    versions: dict[str, str]
    plants: dict[str, str]
    """Physics fingerprints by plant."""
    files: dict[str, str]
    """Hashes (sha256) by name."""
    claims: tuple[Claim, ...]

    def __post_init__(self) -> None:
        super().__post_init__()
        check_whole("preview", self.preview, low=0, high=1000)
        check_number("action_scale", self.action_scale, unit="breakaway torques", low=0.0, open_low=True)
        if self.channel == "setpoint" and self.agent.kind == "policy":
            raise FFGymError("A residual policy adds torque, and cannot act through set-points; leave --channel out.")

    @property
    def sees_errors(self) -> bool:
        """True if it observes errors of the motors; a law never does."""
        return self.feedback and self.agent.kind != "law"

    def tree(self) -> dict[str, Any]:
        """Convert to JSON, with format and digest."""
        tree: dict[str, Any] = {"format": FORMAT, **asdict(self)}
        if self.channel == "torque":
            del tree["channel"]  # as in older ones
        return tree | {"digest": digest_of(tree)}


def digest_of(tree: Mapping[str, Any]) -> str:
    """Hash a manifest without its digest, in canonical JSON: sorted keys, no blanks."""
    rest = {key: value for key, value in tree.items() if key != "digest"}
    return sha256_of(json.dumps(rest, sort_keys=True, separators=(",", ":"), allow_nan=False).encode())


def sha256_of(data: bytes) -> str:
    """Hash the bytes of a file; return hexadecimal text."""
    return hashlib.sha256(data).hexdigest()


def decode_submission(data: bytes) -> tuple[Manifest, dict[str, bytes]]:
    """Decode manifest and files of a submission; Refused unless names and hashes are those of the manifest."""
    files = decode_archive(data)
    if MANIFEST not in files:
        raise Refused("archive", f"it has no {MANIFEST}.")
    manifest = decode_manifest(files[MANIFEST])
    wanted = {ACTIONS, manifest.agent.file} - {None}
    if set(manifest.files) != wanted:
        raise Refused("files", f"the manifest names {join_names(manifest.files)}, must name {join_names(wanted)}.")
    if missing := wanted - set(files):
        raise Refused("files", f"{join_names(missing)} is missing.")
    if unknown := set(files) - wanted - {MANIFEST}:
        raise Refused("files", f"{join_names(unknown)} is no file of a submission; take it out.")
    for name, known in sorted(manifest.files.items()):
        if sha256_of(files[name]) != known:
            what = "logged actions" if name == ACTIONS else "weights"
            raise Refused("files", f"{what} were changed: {name} has not the sha256 that the manifest gives.")
        if name.endswith(".npz"):
            decode_archive(files[name], name, LARGEST)  # it might unpack to too much
    return manifest, files


def decode_manifest(data: bytes) -> Manifest:
    """Decode the bytes of manifest.json; Refused if it is damaged, of another format, incomplete or changed."""
    try:
        tree = parse_json(data, MANIFEST)
    except FFGymError as error:
        raise Refused("manifest", str(error)) from error
    found = tree.pop("format", None) if isinstance(tree, dict) else None
    if type(found) is not int or found != FORMAT:  # true equals 1
        raise Refused("manifest", f"{MANIFEST} has format {found!r}, this version of ffgym reads {FORMAT}.")
    try:
        digest = tree.pop("digest", None)
        absent = {"feedback": True, "channel": "torque"}  # in older ones
        manifest: Manifest = from_json(Manifest, absent | tree, "manifest")
        changed = digest_of(tree | {"format": found}) != digest
    except (ValueError, OverflowError) as error:
        raise Refused("manifest", f"{MANIFEST} is not complete or not valid: {error}") from error
    if changed:
        raise Refused("manifest", f"{MANIFEST} was changed: its digest is not that of its content.")
    return manifest


def read_archive(path: str | os.PathLike[str]) -> bytes:
    """Read a submission's file; one that is too large, or no ordinary file, is refused."""
    try:
        found = Path(path).stat()
    except FileNotFoundError:
        return read_bytes(path)  # which raises the error
    except OSError as error:
        raise FFGymError(f"{path}: cannot be read: {error.strerror}.") from error
    if not stat.S_ISREG(found.st_mode):
        raise FFGymError(f"{path}: is a folder or a device, must be a file.")
    _check_size("it has", found.st_size)
    return read_bytes(path)


def encode_archive(files: Mapping[str, bytes]) -> bytes:
    """Encode files as a ZIP file; equal files in the same order give equal bytes."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, data in files.items():
            entry = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
            entry.create_system = 3  # the same on every system
            entry.external_attr = (stat.S_IFREG | 0o644) << 16
            archive.writestr(entry, data, zipfile.ZIP_DEFLATED)
    return buffer.getvalue()


def decode_archive(data: bytes, what: str = "it", most: int = MOST) -> dict[str, bytes]:
    """Decode the files of a ZIP file, by name; Refused if it is damaged, too large, or holds a name twice."""
    _check_size(f"{what} has", len(data))
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            entries = archive.infolist()
            _check_size(f"{what} would unpack to", sum(entry.file_size for entry in entries))
            if len(entries) > most:
                raise Refused("archive", f"{what} holds {len(entries)} files, must hold at most {most}.")
            if twice := {entry.filename for entry in entries if archive.getinfo(entry.filename) is not entry}:
                raise Refused("archive", f"{what} holds {join_names(twice)} more than once.")
            files = {entry.filename: archive.read(entry) for entry in entries}
            if any(len(files[entry.filename]) != entry.file_size for entry in entries):
                raise zipfile.BadZipFile
    except Refused:
        raise
    except Exception as error:  # zipfile and zlib raise a dozen types for damaged bytes
        raise Refused("archive", f"{what} is damaged or cut short, no ZIP file ({type(error).__name__}).") from error
    return files


def _check_size(what: str, size: int) -> None:
    if size > LARGEST:
        raise Refused("archive", f"{what} {size} bytes, must be at most {LARGEST}.")


def join_names(names: Iterable[Any]) -> str:
    """Join names in their order, for messages."""
    return ", ".join(sorted(names)) or "nothing"
