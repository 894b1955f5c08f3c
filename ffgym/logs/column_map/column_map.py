"""A column map: robot, header, and where each column of a recording is in a file of another tool."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, final

from ffgym.logs.column_map.column import Column
from ffgym.logs.text_layout import TextLayout
from ffgym.recordings.rewiring import Rewiring

LOG_KEYS: Mapping[str, str] = MappingProxyType(
    {
        "base": "column map that this one begins with, a built-in name or a .toml beside it: keys here are added to "
        "its tables, or count in place of its keys",
        "robot": "built-in robot, or a description (.toml) beside the map; with `joints`, just a name; absent if the "
        "caller says it",
        "joints": "joint names of a robot without description; then `gear_ratio` is needed, and `coupling` and "
        "`joint_types` may follow",
        "gear_ratio": "motor angle over joint angle, one per joint",
        "coupling": "how far motor i turns with joint j",
        "joint_types": '"hinge" or "slide", one per joint',
        "position_side": "side on which the recording keeps motor and reference positions; absent is that of the "
        "description, or `motor`",
        "torque_semantics": "what the torque is; absent is the description's, or `unspecified`",
        "hold": "when the torque of a row acts; absent is `sampled` with a description, otherwise `unspecified`",
        "encoder_bits": "resolution of the motor encoder",
        "filters": "list of the filters already applied, in words",
        "payload": "table with `mass` [kg], `com` [m] and `inertia` [kg m^2]; absent is the "
        'description\'s tool, "unknown" is null',
        "segment": "name of the motion; absent is the name of the file",
        "trim": "true: rows before and after the samples of a column with a clock of its own are dropped",
    }
)
"""What the table [log] may say; except `base`, `robot` and `trim` these are header fields (docs/recordings.md)."""

MOTION_KEYS: Mapping[str, str] = MappingProxyType(
    {
        "split": "array with one number or word per row that is the same throughout a motion, e.g. `episode_index`",
        "names": "array with the name of each motion; absent are numbers from 0",
    }
)
"""What the table [motions] may say of a file with several motions."""

TABLES: Mapping[str, str] = MappingProxyType(
    {
        "log": "whose log it is, and what its torque and positions are",
        "columns": "the columns of the recording, by family",
        "file": "layout of a text file",
        "motions": "how a file holds several motions",
        "rewire": "corrections of columns that were read, by family; a map without other tables is for recordings",
        "meta": 'what goes into `meta` of the header: values, or `{ source = "name" }` for an array of the file, '
        "which may be `optional = true`; with `since_first = true`, times of day ('20:29', or seconds) become seconds "
        "since the earliest motion of the file, as `session_start` needs them",
    }
)
"""Tables of a column map."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ColumnMap:
    """What the arrays of a file mean. Made by `load_columns` or `parse_columns`."""

    where: str
    """Name of the file or text, for messages."""
    folder: Path = Path()
    """Where the path of a robot's description starts."""
    robot: str = ""
    """Built-in robot, path, or with joints in `header` just a name; empty if the caller says which."""
    header: Mapping[str, Any] = field(default_factory=dict)
    """Fields of the recording's header that the map sets."""
    columns: Mapping[str, Column]
    """Family or column -> where its numbers are."""
    layout: TextLayout = field(default_factory=TextLayout)
    """Of a text file."""
    split: str = ""
    """Array whose value tells the motions apart; empty if there is one, or they lie along an axis."""
    names: str = ""
    """Array with the names of the motions."""
    meta: Mapping[str, Any] = field(default_factory=dict)
    """JSON values, or tables {"source": name} for arrays of the file."""
    trim: bool = False
    """Whether rows that a column with a clock of its own does not reach are dropped."""
    rewiring: Rewiring = field(default_factory=Rewiring)
    """Corrections of what is read."""

    @property
    def is_for_recordings(self) -> bool:
        """Whether the files are recordings, of which nothing but the corrections has to be said."""
        return not self.columns
