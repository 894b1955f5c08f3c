"""A small log of a two-axis press in another tool's words, and the column map that reads it."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.logs import ColumnMap, Contents, LogFormat, parse_columns
from ffgym.logs.log_format import one_error

N_ROWS = 7
RATIOS = np.array([120.0, -80.0])

LOG = """
[log]
robot = "press"
joints = ["upper", "lower"]
gear_ratio = [120.0, -80.0]
position_side = "motor"
torque_semantics = "motor_side"
"""

CLOCK = """
[columns.timestamp]
source = "t"
unit = "s"
"""

POSITION = """
[columns."motor.position"]
source = "q"
unit = "rad"
"""


def arrays(**changes: Any) -> dict[str, Any]:
    """Arrays of the log: clock [s], motor angles [rad] and torques [N m]; None takes one away."""
    t = 0.004 * np.arange(N_ROWS)
    q = np.column_stack([np.sin(30 * t), np.cos(20 * t)])
    log = {"t": t, "q": q, "u": 10 * q - 1, **changes}
    return {name: values for name, values in log.items() if values is not None}


def column_map(*tables: str, log: str = LOG) -> ColumnMap:
    """Map of `log` and these tables."""
    return parse_columns("\n".join([log, *tables]), where="map.toml")


def write_npz(folder: Path, name: str = "run.npz", **changes: Any) -> Path:
    np.savez(folder / name, **arrays(**changes))
    return folder / name


def decoded(kind: LogFormat, data: bytes) -> Contents:
    """Arrays in the bytes of a file."""
    with one_error(kind.title):
        return kind.decode(data, "x")


def refused(*words: str) -> Any:
    """Expect an FFGymError of one line that holds these words in this order."""
    pattern = r"[^\n\r]*".join(re.escape(word) for word in words)
    return pytest.raises(FFGymError, match=rf"\A[^\n\r]*{pattern}[^\n\r]*\Z")
