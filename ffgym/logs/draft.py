"""A draft of a column map: what a file holds, and tables with places to fill in."""

import re
from collections import defaultdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ffgym.logs.column_map import TO_FILL_IN
from ffgym.logs.contents import NUMBERS, Contents, readable
from ffgym.logs.text_layout import TextLayout

_WANTED = ("motor.position", "motor.effort", "reference.position")
"""Columns that most methods need, which a draft has tables for."""

_CLOCK = re.compile(r"time|stamp|clock|\bt\b|^t_|_t$", re.IGNORECASE)
"""Names that clocks go by."""


def listing(contents: Contents) -> list[str]:
    """One line for each array: name, shape, type, range; and for what cannot be read."""
    described = {name: _describe_column(array) for name, array in contents.arrays.items()}
    described |= {name: f"cannot be read: {why}" for name, why in contents.skipped.items()}
    width = max((len(readable(name)) for name in described), default=0)
    return [f"{readable(name):{width}}  {text}" for name, text in described.items()]


def draft(contents: Contents, layout: TextLayout | None = None) -> str:
    """TOML text of a column map with everything that the file shows, and '?' for what only its owner knows."""
    # the table [file] says what the text needs to be read
    layout, default = layout or TextLayout(), TextLayout()
    said = {name: value for name, value in vars(layout).items() if value != getattr(default, name)}
    sources = _by_number(contents)
    proposed = f"  # one of {', '.join(map(_quote, sources[:8]))}" if sources else "  # or a list, one name per joint"
    lines = [
        f"# Column map for {contents.where}: a draft.",
        f'# Fill in every "{TO_FILL_IN}", take away tables of what the file does not have, and add others like them;',
        "# docs/column_maps.md explains all keys, docs/recordings.md all columns.",
        "#",
        "# The file holds:",
        *(f"#   {line}" for line in listing(contents)),
        "",
        "[log]",
        'robot = "?"             # built-in robot, a description (.toml) beside this file, or just a name with',
        '# joints = ["upper", "lower"]  # then their names, and motor angle over joint angle of each:',
        "# gear_ratio = [120.0, -80.0]",
        'position_side = "?"     # motor, or link: divided by the gear ratio',
        'torque_semantics = "?"  # motor_side, link_side, current, command or unspecified',
        'hold = "?"              # sampled, zoh, linear or unspecified',
        *(["", "[file]"] if said else []),
        *(f"{name} = {_quote(value) if isinstance(value, str) else value}" for name, value in said.items()),
        *_timestamp(contents),
    ]
    for family in _WANTED:
        lines += ["", f'[columns."{family}"]', f"source = {_quote(TO_FILL_IN)}{proposed}", 'unit = "?"']
    return "\n".join(lines) + "\n"


def clocks(contents: Contents) -> list[str]:
    """Arrays that can be the clock of the rows: they increase, and those that are called so come first."""
    streams = [name for kinds in contents.clocks.values() for name in kinds.values()]
    rising = [name for name, array in contents.arrays.items() if _rises(array)]
    named = [name for name in rising if _CLOCK.search(name)]
    return list(dict.fromkeys([name for name in (*streams, *named, *rising) if name in rising]))


def _timestamp(contents: Contents) -> list[str]:
    found = clocks(contents)
    if not found:
        return [
            "",
            "[columns.timestamp]  # nothing in the file increases steadily",
            "rate_hz = 0.0  # samples per second",
        ]
    others = f"  # or {', '.join(found[1:6])}" if len(found) > 1 else ""
    lines = ["", "[columns.timestamp]", f"source = {_quote(found[0])}{others}"]
    if any(found[0] in kinds.values() for kinds in contents.clocks.values()):
        return [*lines, 'unit = "ns"', "from_first = true"]
    return [*lines, 'unit = "?"']


def _by_number(contents: Contents) -> list[str]:
    """Sources for one number per joint: arrays (T, N), and series of names like q1 ... q6 or topic:position.elbow."""
    tables = [name for name, array in contents.arrays.items() if array.ndim == 2 and array.dtype.kind in NUMBERS]
    series: dict[str, list[str]] = defaultdict(list)
    for name in contents.arrays.keys() - contents.streams.keys():
        for match in re.finditer(r"\d+", name):
            series[f"{name[: match.start()]}{{number}}{name[match.end() :]}"].append(match.group())
    counted = [  # 1, 2, ... in any order
        name
        for name, numbers in series.items()
        if len(numbers) > 1 and sorted(numbers, key=int) == [str(i + 1) for i in range(len(numbers))]
    ]
    joints: dict[str, list[str]] = defaultdict(list)
    for name in contents.streams:
        stem, dot, joint = name.rpartition(".")
        joints[f"{stem}.{{joint}}"] += [joint] if dot else []
    named = [name for name, found in joints.items() if re.search(r"position|velocity|effort", name) and found]
    return [*tables, *counted, *named]


def _describe_column(array: NDArray[Any]) -> str:
    text = f"{array.shape} {array.dtype}"
    if array.dtype.kind not in NUMBERS or not array.size:
        return f"{text} {str(array.reshape(-1)[0])[:40]!r}" if array.size else text
    finite = array[np.isfinite(array)]
    missing = array.size - finite.size
    if finite.size:
        text += f", {finite.min():.6g} to {finite.max():.6g}"
    if missing:
        text += f", {missing} missing"
    return text + (f", increases by {np.median(np.diff(array)):.6g}" if _rises(array) else "")


def _rises(array: NDArray[Any]) -> bool:
    return array.ndim == 1 and array.dtype.kind in "iuf" and len(array) > 2 and bool(np.all(array[1:] > array[:-1]))


def _quote(text: str) -> str:
    """TOML text."""
    escaped = "".join(_ESCAPES.get(c, c if c.isprintable() else f"\\U{ord(c):08x}") for c in text)
    return f'"{escaped}"'


_ESCAPES = {'"': '\\"', "\\": "\\\\", "\t": "\\t"}
