"""Valid programs that nobody wrote: targets, speeds and zones around a point of the built-in robot's work area."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

CENTRE = np.array([1500.0, 0.0, 700.0])
"""Middle of the targets [mm]."""
HALF = 80.0
"""Half the side of the cube in which they lie [mm]."""
LEAN = 10.0
"""Largest angle about each axis by which the tool is turned from straight down [deg]."""

SPEEDS = {"v10": 10, "v50": 50, "v200": 200, "vOwn": 33}
ZONES = {"fine": 0, "z0": 0.3, "z5": 5, "z20": 20, "zOwn": 2}

HEAD = """MODULE generated
CONST speeddata vOwn := [33, 60, 5000, 1000];
CONST zonedata zOwn := [FALSE, 2, 3, 3, 0.3, 3, 0.3];
"""


@dataclass(frozen=True)
class Target:
    """Where a generated move ends."""

    kind: str
    position: tuple[float, ...]
    """[mm]"""
    speed: str
    zone: str


@dataclass(frozen=True)
class Generated:
    """A program and what it asks for; target i is called p<i>."""

    text: str
    targets: tuple[Target, ...]


@st.composite
def positions(draw: Any) -> tuple[float, ...]:
    return tuple(float(c + round(draw(st.floats(-HALF, HALF)), 2)) for c in CENTRE)


@st.composite
def orients(draw: Any) -> list[float]:
    lean = [draw(st.floats(-LEAN, LEAN)) for _ in range(3)]
    down = Rotation.from_quat([0.0, 1.0, 0.0, 0.0])
    x, y, z, w = (down * Rotation.from_euler("XYZ", lean, degrees=True)).as_quat().round(9).tolist()
    return [w, x, y, z]


def robtarget(position: Any, orient: list[float]) -> str:
    return f"[{list(position)}, {orient}, [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]]"


def beside(start: tuple[float, ...], end: tuple[float, ...], bulge: float) -> list[float]:
    """A point on an arc between two points, `bulge` times their distance off their middle."""
    a, b = np.array(start), np.array(end)
    across = np.cross(b - a, [0.3, -0.5, 0.8])
    return ((a + b) / 2 + across / np.linalg.norm(across) * np.linalg.norm(b - a) * bulge).round(4).tolist()


@st.composite
def programs(draw: Any) -> Generated:
    """Two to seven moves and some rests; arcs span less than half a circle or a little more."""
    lines = ["ConfJ \\Off;"]
    data, targets = [], []
    for i in range(draw(st.integers(2, 7))):
        position = draw(
            positions().filter(lambda p: all(np.linalg.norm(np.subtract(p, t.position)) > 1 for t in targets))
        )
        kind = "MoveJ" if i == 0 else draw(st.sampled_from(["MoveL", "MoveL", "MoveC", "MoveJ"]))
        target = Target(kind, position, draw(st.sampled_from(list(SPEEDS))), draw(st.sampled_from(list(ZONES))))
        orient = draw(orients())
        data.append(f"CONST robtarget p{i} := {robtarget(position, orient)};")
        via = ""
        if kind == "MoveC":
            via = robtarget(beside(targets[-1].position, position, draw(st.floats(0.1, 0.6))), orient) + ", "
        lines.append(f"{kind} {via}p{i}, {target.speed}, {target.zone}, tRobot;")
        if target.zone == "fine" and draw(st.booleans()):
            lines.append("WaitTime 0.1;")
        targets.append(target)
    body = "\n".join(lines)
    text = f"{HEAD}{chr(10).join(data)}\nPROC main()\n{body}\nENDPROC\nENDMODULE\n"
    return Generated(text, tuple(targets))
