"""Header of a recording: robot, sides, torque semantics, phases, provenance; the meaning of its numbers."""

import json
import re
from collections.abc import Iterable
from dataclasses import MISSING, asdict, dataclass, field, fields, replace
from itertools import pairwise
from typing import Any, Literal, Self, get_args

import numpy as np

from ffgym.core.errors import FFGymError, check_choice, check_number, check_shape
from ffgym.core.typed_json import parse_json
from ffgym.core.types import Array
from ffgym.recordings.schema import USER_PREFIX

SCHEMA_VERSION = 1
"""Version of the format; a reader refuses any other."""

PositionSide = Literal["motor", "link"]
TorqueSemantics = Literal["motor_side", "link_side", "current", "command", "unspecified"]
Hold = Literal["linear", "zoh", "sampled", "unspecified"]

_CHOICES = {"position_side": PositionSide, "torque_semantics": TorqueSemantics, "hold": Hold}

JOINT_NAME = re.compile(r"[A-Za-z0-9_/-]+")
"""Valid names of joints, which can end the names of columns."""

PhaseKind = Literal["standstill", "lead_in", "circle", "lead_out", "motion"]
PHASE_KINDS: tuple[PhaseKind, ...] = get_args(PhaseKind)
"""Every kind of phase."""


@dataclass(frozen=True, kw_only=True)
class Phase:
    """The rows with start <= t < end.

    The interval is half open, so that touching phases share no row and cutting a recording moves no row to another
    phase. To include the last row, end the phase one sample period after it.
    """

    label: str
    """Name, for example `circle_2`; need not be unique."""
    kind: PhaseKind
    """Kind of motion, or standstill."""
    start: float
    """First instant [s], on the clock of `timestamp`."""
    end: float
    """First instant after the phase [s], > start."""

    def __post_init__(self) -> None:
        if not isinstance(self.label, str) or not self.label:
            raise FFGymError(f"Phase label must be non-empty text, got {self.label!r}.")
        check_choice(f"kind of phase {self.label!r}:", self.kind, PHASE_KINDS)
        for name in ("start", "end"):
            value = check_number(f"Phase {self.label!r} {name}", getattr(self, name), unit="s")
            object.__setattr__(self, name, value)
        if self.end <= self.start:
            raise FFGymError(f"Phase {self.label!r} ends at {self.end} s, must be after its start at {self.start} s.")

    @classmethod
    def from_dict(cls, values: Any) -> Self:
        """Return the phase with exactly the fields `values`."""
        names = {"label", "kind", "start", "end"}
        if not isinstance(values, dict) or set(values) != names:
            raise FFGymError(f"A phase must be an object with {', '.join(sorted(names))}, got {values!r}.")
        return cls(**values)


def clip_phases(phases: Iterable[Phase], first: float, last: float) -> tuple[Phase, ...]:
    """Clip phases to [first, last] s; phases outside are dropped."""
    cut = ((phase, max(phase.start, first), min(phase.end, last)) for phase in phases)
    return tuple(replace(phase, start=start, end=end) for phase, start, end in cut if start < end)


@dataclass(frozen=True, kw_only=True)
class Header:
    """Data of a recording beside its columns. Dicts are kept as JSON copies.

    Raises:
        FFGymError: if a field has the wrong type, an unknown choice, or the wrong number of joints.
    """

    robot: str
    """Name of the robot."""
    joints: tuple[str, ...]
    """Joint names, shape (N,), which end the names of per-joint columns."""
    gear_ratio: tuple[float, ...]
    """Motor angle over joint angle, shape (N,), not zero; negative where motor and joint turn opposite ways."""
    coupling: tuple[tuple[float, ...], ...] | None = None
    """Turn of motor i with joint j, shape (N, N), beside `gear_ratio` for i = j; None if motors turn alone."""
    joint_types: tuple[str, ...] = ()
    """'hinge' or 'slide', shape (N,); link-side quantities of a slide have m and N for rad and N m. Empty is hinges."""
    schema_version: int = SCHEMA_VERSION
    """Version of the format."""
    position_side: PositionSide = "motor"
    """Side of `motor.position`, `motor.velocity` and `reference.*`: motor angles, or divided by the gear ratio."""
    torque_semantics: TorqueSemantics = "unspecified"
    """Meaning of the torque columns, see docs/recordings.md. Methods that need torque refuse "unspecified"."""
    hold: Hold = "unspecified"
    """Time at which the torque of row i acts, see docs/recordings.md."""
    encoder_bits: int | None = None
    """Resolution of the motor encoder [bit per revolution], None if unknown or not quantised."""
    filters: tuple[str, ...] = ()
    """Filters already applied, in words."""
    payload: dict[str, Any] | None = None
    """`mass` [kg]; if known `com` [m] (3,) and `inertia` about it [kg m^2] (3, 3), flange frame. None if unknown."""
    segment: str = ""
    """Name of the motion; the unit of cross-validation."""
    phases: tuple[Phase, ...] = ()
    """Parts of the motion, in order, without overlap."""
    provenance: dict[str, Any] = field(default_factory=dict)
    """Free JSON: seed, versions, physics fingerprint, calibration date."""
    units: dict[str, str] = field(default_factory=dict)
    """Unit of every `user.` column."""
    meta: dict[str, Any] = field(default_factory=dict)
    """Free JSON."""

    def __post_init__(self) -> None:
        if type(self.schema_version) is not int or self.schema_version != SCHEMA_VERSION:
            raise FFGymError(
                f"header schema_version = {self.schema_version!r} is not readable, must be {SCHEMA_VERSION}. "
                "Use the version of ffgym that wrote it, or write it again."
            )
        for name, choices in _CHOICES.items():
            check_choice(f"header {name}", getattr(self, name), get_args(choices))
        for name, empty in (("robot", False), ("segment", True)):
            value = getattr(self, name)
            if not isinstance(value, str) or not (value or empty):
                raise FFGymError(f"header {name} must be {'text' if empty else 'non-empty text'}, got {value!r}.")
        bits = self.encoder_bits
        if bits is not None and (isinstance(bits, bool) or not isinstance(bits, int) or not 1 <= bits <= 64):
            raise FFGymError(f"header encoder_bits = {bits!r} must be an integer in [1, 64], or None.")
        # immutable forms, as recordings share headers
        checked = _as_axes(self) | {
            "filters": _as_texts("filters", self.filters),
            "phases": _as_phases(self.phases),
            "payload": None if self.payload is None else _as_payload(self.payload),
            "units": _as_units(self.units),
            "provenance": _as_json("provenance", self.provenance),
            "meta": _as_json("meta", self.meta),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    def motor_side(self, values: Array) -> Array:
        """Bring positions, speeds or accelerations (T, N) that are written as `motor.position` is to the motor side."""
        if self.position_side == "motor":
            return values
        motor = values * np.asarray(self.gear_ratio)
        if self.coupling is not None:
            motor += (values[:, None, :] * np.asarray(self.coupling)).sum(axis=2)
        return motor

    def joint_side(self, values: Array) -> Array:
        """Bring such values (T, N), written as `motor.position` is, behind the gearbox."""
        if self.position_side == "link":
            return values
        if self.coupling is None:
            joint: Array = values / np.asarray(self.gear_ratio)
            return joint
        return values @ np.linalg.pinv(np.diag(self.gear_ratio) + np.asarray(self.coupling)).T

    def to_json(self, indent: int | None = None) -> str:
        """Return the header as ASCII JSON, from which `from_json` makes an equal header."""
        return json.dumps(asdict(self), indent=indent, allow_nan=False)

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Return the header that `to_json` wrote; text that is no valid header is an error."""
        values = parse_json(text, "The header")
        if not isinstance(values, dict):
            raise FFGymError(f"The header must be a JSON object, got {type(values).__name__}.")
        version = values.get("schema_version")
        if version != SCHEMA_VERSION:  # first, because another version may have other fields
            raise FFGymError(f"header schema_version = {version!r} is not readable, must be {SCHEMA_VERSION}.")
        missing = [name for name in cls.required() if name not in values]
        if missing:
            raise FFGymError(f"The header lacks {', '.join(missing)}. Required: {', '.join(cls.required())}.")
        known = [f.name for f in fields(cls)]
        for name in values:
            check_choice("header field", name, known)
        phases = values.get("phases", [])
        if not isinstance(phases, list):
            raise FFGymError(f"header phases must be a list, got {phases!r}.")
        return cls(**{**values, "phases": tuple(Phase.from_dict(phase) for phase in phases)})

    @classmethod
    def required(cls) -> tuple[str, ...]:
        """Names of the fields without a default."""
        return tuple(f.name for f in fields(cls) if f.default is MISSING and f.default_factory is MISSING)

    @classmethod
    def how_to_pass(cls, problem: str) -> str:
        """Return a message for a file without a header: the `problem` and the way out."""
        optional = [f.name for f in fields(cls) if f.name not in (*cls.required(), "schema_version")]
        return (
            f"{problem}, so it is not known what its numbers mean. Pass read_recording(path, header=Header(...)) "
            f"with {', '.join(cls.required())}, and as far as known {', '.join(optional)}. Other names or units take a "
            "column map: ffgym.logs.read_log, `ffgym log columns`."
        )


def _as_texts(name: str, value: Any) -> tuple[str, ...]:
    """Check a tuple of text."""
    if not isinstance(value, tuple | list) or not all(isinstance(item, str) for item in value):
        raise FFGymError(f"header {name} must be a tuple of text, got {value!r}.")
    return tuple(str(item) for item in value)


def _as_axes(header: "Header") -> dict[str, Any]:
    """Check joint names, distinct and safe in column names, and one gear ratio, coupling and type per joint."""
    joints = _as_texts("joints", header.joints)
    if not joints or len(set(joints)) < len(joints):
        raise FFGymError(f"header joints = {joints} must be at least one name, each once.")
    for joint in joints:
        if not JOINT_NAME.fullmatch(joint):
            raise FFGymError(f"header joints: {joint!r} must be letters, digits or any of _ / -")
    n, coupling = len(joints), None
    ratios = tuple(check_shape("header gear_ratio", header.gear_ratio, (n,)).tolist())
    if 0 in ratios:
        raise FFGymError(f"header gear_ratio = {ratios} must not be zero; write 1 for a direct drive.")
    if header.coupling is not None:
        matrix = check_shape("header coupling", header.coupling, (n, n))
        if np.any(np.diag(matrix)):
            raise FFGymError(f"header coupling has {np.diag(matrix)} on its diagonal, must be 0; see gear_ratio.")
        coupling = tuple(tuple(row) for row in matrix.tolist())
    types = _as_texts("joint_types", header.joint_types) or ("hinge",) * n
    for kind in types:
        check_choice("header joint_types entry", kind, ("hinge", "slide"))
    if len(types) != n:
        raise FFGymError(f"header joint_types = {types} must be one for each of {n} joints.")
    return {"joints": joints, "gear_ratio": ratios, "coupling": coupling, "joint_types": types}


def _as_phases(value: Any) -> tuple[Phase, ...]:
    """Check that phases are in order, without overlap."""
    if not isinstance(value, tuple | list) or not all(isinstance(phase, Phase) for phase in value):
        raise FFGymError(f"header phases must be a tuple of Phase, got {value!r}.")
    for before, after in pairwise(value):
        if after.start < before.end:
            raise FFGymError(
                f"Phase {after.label!r} starts at {after.start} s, before {before.label!r} ends at {before.end} s. "
                "Phases must be in order and must not overlap."
            )
    return tuple(value)


def _as_payload(value: Any) -> dict[str, Any]:
    """Check a payload with its mass [kg] and, where known, `com` [m] and `inertia` [kg m^2]."""
    known = ("mass", "com", "inertia")
    payload = _as_json("payload", value)
    for name in payload:
        check_choice("header payload entry", name, known)
    if "mass" not in payload:
        raise FFGymError("header payload has no mass [kg]. Give 0 for none, or payload=None if unknown.")
    payload["mass"] = check_number("header payload mass", payload["mass"], unit="kg", low=0.0)
    for name, shape in (("com", (3,)), ("inertia", (3, 3))):
        if name in payload:
            payload[name] = check_shape(f"header payload {name}", payload[name], shape).tolist()
    return payload


def _as_units(value: Any) -> dict[str, str]:
    """Check units of user columns."""
    units = _as_json("units", value)
    for name, unit in units.items():
        if not name.startswith(USER_PREFIX) or not isinstance(unit, str) or not unit:
            raise FFGymError(f"header units: {name!r} = {unit!r} must be a user.<name> column with its unit as text.")
    return units


def _as_json(name: str, value: Any) -> dict[str, Any]:
    """Send `value` through JSON and back; NumPy numbers and arrays become lists."""
    if not isinstance(value, dict):
        raise FFGymError(f"header {name} must be a dict, got {value!r}.")

    def plain(other: Any) -> Any:
        if isinstance(other, np.generic | np.ndarray):
            return other.tolist()
        raise TypeError(f"{other!r} is not JSON")

    try:
        text = json.dumps(value, allow_nan=False, default=plain)
    except (TypeError, ValueError, RecursionError) as error:
        raise FFGymError(f"header {name} must be JSON (no NaN, no objects): {error}.") from error
    copy: dict[str, Any] = json.loads(text)
    return copy
