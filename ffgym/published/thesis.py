"""Tables 4.1, 4.2, 5.1 and 5.2 of the thesis: path error of the real robot."""

import json
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
    """Published path error in the plane [mm], or None where nothing was published (100 mm/s has figures only).

    Args:
        method: one of METHODS.
        statistic: 'rms' or 'max'.
        speed: TCP speed [m/s].
        radius: circle radius [m].
        position: 'p1' to 'p4'.
    """
    methods = _tables().get(f"speed_{speed * 1e3:g}", {})
    value = methods.get(method, {}).get(statistic, {}).get(f"r{radius * 1e3:g}", {}).get(position)
    return None if value is None else float(value)
