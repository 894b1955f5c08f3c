"""Tables of the thesis: path errors of the real robot (4.1, 4.2, 5.1, 5.2), and records of its friction (6.1).

Reference:
    Learning Local Models of Multi-axis Robot for Improved Feed-Forward Control, master's thesis, Chalmers University of
    Technology and ABB Robotics. The paper of the same work: V. Johansson, S. Moberg, E. Hedberg, M. Norrlöf,
    S. Gunnarsson, A Learning Approach for Feed-Forward Friction Compensation, IFAC-PapersOnLine 51-22 (2018), 412-417,
    doi 10.1016/j.ifacol.2018.11.578.
"""

import json
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

METHODS = ("none", "lugre_static", "lugre_dynamic", "bsn_static", "bsn_extended")
"""Feed-forward methods with published numbers."""


@cache
def _tables() -> dict[str, Any]:
    text = (resources.files("ffgym.published") / "thesis_tables.json").read_text(encoding="utf-8")
    tables: dict[str, Any] = json.loads(text)
    return tables


def published_mm(method: str, statistic: str, speed: float, radius: float, position: str) -> float | None:
    """Return the published path error in the plane [mm], or None where the thesis has no number (figures only).

    Args:
        method: one of METHODS.
        statistic: 'rms' or 'max'.
        speed: TCP speed [m/s]; at 0.1 m/s the thesis has figures only.
        radius: circle radius [m].
        position: 'p1' to 'p4'.
    """
    methods = _tables().get(f"speed_{speed * 1e3:g}", {})
    value = methods.get(method, {}).get(statistic, {}).get(f"r{radius * 1e3:g}", {}).get(position)
    return None if value is None else float(value)


@dataclass(frozen=True, kw_only=True)
class FrictionRecord:
    """One row of Table 6.1: motor speed A sin(2 pi f t), thesis (6.13)."""

    number: int
    """Number of the data record."""
    amplitude: float
    """A, motor side [rad/s]."""
    frequency: float
    """f [Hz]."""


FRICTION_RECORDS = tuple(
    FrictionRecord(number=5 * i + j + 1, amplitude=amplitude, frequency=frequency)
    for i, amplitude in enumerate((1.3, 5.0, 10.0))
    for j, frequency in enumerate((0.25, 0.5, 1.0, 2.0, 5.0))
)
"""Table 6.1, the sines from which the friction of joint 1 was identified. Record 11 is printed with A = 5, as record 6;
here it has A = 10, as the pattern and figure 6.5e say, which shows 10 sin(2 pi 0.25 t) among the validation records."""

ESTIMATION_RECORDS = (2, 4, 7, 9, 12, 14)
"""Records of set D of the thesis, which the parameters were estimated from; the other records validate."""
