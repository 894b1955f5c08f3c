"""What the numbers of a recording mean: robot, sides, torque semantics, phases, provenance."""

import json
from dataclasses import MISSING, asdict, dataclass, field, fields
from typing import Any, Literal, Self, get_args

from ffgym.core.errors import FFGymError, check_choice
from ffgym.recordings.header_fields import (
    as_bits,
    as_coupling,
    as_joint_types,
    as_joints,
    as_json,
    as_payload,
    as_phases,
    as_ratios,
    as_text,
    as_texts,
    as_units,
)
from ffgym.recordings.phase import Phase

SCHEMA_VERSION = 1
"""Version of the format; a reader refuses any other."""

PositionSide = Literal["motor", "link"]
TorqueSemantics = Literal["motor_side", "link_side", "current", "command", "unspecified"]
Hold = Literal["linear", "zoh", "sampled", "unspecified"]

_CHOICES = {"position_side": PositionSide, "torque_semantics": TorqueSemantics, "hold": Hold}


@dataclass(frozen=True, kw_only=True)
class Header:
    """Everything about a recording that is not a column. Dicts are kept as JSON copies of what was passed in.

    Raises:
        FFGymError: if a field has the wrong type, an unknown choice, or the wrong number of joints.
    """

    robot: str
    """Name of the robot."""
    joints: tuple[str, ...]
    """Joint names, shape (N,), as they end the per-joint columns."""
    gear_ratio: tuple[float, ...]
    """Motor angle over joint angle, shape (N,), not zero; negative where motor and joint turn opposite ways."""
    coupling: tuple[tuple[float, ...], ...] | None = None
    """How far motor i turns with joint j, shape (N, N), beside `gear_ratio` for i = j; None if motors turn alone."""
    joint_types: tuple[str, ...] = ()
    """'hinge' or 'slide', shape (N,); link-side quantities of a slide have m and N for rad and N m. Empty is hinges."""
    schema_version: int = SCHEMA_VERSION
    """Version of the format."""
    position_side: PositionSide = "motor"
    """Side of `motor.position`, `motor.velocity` and `reference.*`: motor angles, or divided by the gear ratio."""
    torque_semantics: TorqueSemantics = "unspecified"
    """What the torque columns are; see docs/recordings.md. Methods that need torque refuse "unspecified"."""
    hold: Hold = "unspecified"
    """When the torque of row i acts; see docs/recordings.md."""
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
        checked = {
            "robot": as_text("robot", self.robot),
            "segment": as_text("segment", self.segment, empty=True),
            "joints": as_joints(self.joints),
            "filters": as_texts("filters", self.filters),
            "encoder_bits": as_bits(self.encoder_bits),
            "phases": as_phases(self.phases),
            "payload": None if self.payload is None else as_payload(self.payload),
            "units": as_units(self.units),
            "provenance": as_json("provenance", self.provenance),
            "meta": as_json("meta", self.meta),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        n = len(self.joints)
        object.__setattr__(self, "gear_ratio", as_ratios(self.gear_ratio, n))
        object.__setattr__(self, "coupling", as_coupling(self.coupling, n))
        object.__setattr__(self, "joint_types", as_joint_types(self.joint_types, n))

    def to_json(self, indent: int | None = None) -> str:
        """Return the header as ASCII JSON, from which `from_json` makes an equal header."""
        return json.dumps(asdict(self), indent=indent, allow_nan=False)

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Return the header that `to_json` wrote.

        Raises:
            FFGymError: if `text` is not JSON, or its fields are not those of a valid header.
        """
        try:
            values = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise FFGymError(f"The header is not valid JSON: {error}.") from error
        if not isinstance(values, dict):
            raise FFGymError(f"The header must be a JSON object, got {type(values).__name__}.")
        cls._check_fields(values)
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

    @classmethod
    def _check_fields(cls, values: dict[str, Any]) -> None:
        version = values.get("schema_version")
        if version != SCHEMA_VERSION:  # first, because another version may have other fields
            raise FFGymError(f"header schema_version = {version!r} is not readable, must be {SCHEMA_VERSION}.")
        missing = [name for name in cls.required() if name not in values]
        if missing:
            raise FFGymError(f"The header lacks {', '.join(missing)}. Required: {', '.join(cls.required())}.")
        known = [f.name for f in fields(cls)]
        for name in values:
            check_choice("header field", name, known)
