"""Data that every program can use without declaring them."""

import math
from collections.abc import Mapping
from types import MappingProxyType

from ffgym.paths.rapid.records import (
    LOADDATA,
    NUM,
    SPEEDDATA,
    STOPPOINTDATA,
    STRING,
    TOOLDATA,
    WOBJDATA,
    ZONEDATA,
    Type,
    Value,
)

_SPEEDS = (
    *(5, 10, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 600, 800),
    *(1000, 1500, 2000, 2500, 3000, 4000, 5000, 6000, 7000),
)
"""TCP speeds [mm/s] of v5 to v7000; RAPID reference manual (ABB 3HAC16581-1), speeddata."""

_LARGEST_SPEED = 7000
"""TCP speed [mm/s] of vmax; chosen: there it is the robot's own, which its joints' limits set here anyway."""

_ORIENT_SPEED, _LINEAR_AXES_SPEED, _ROTATING_AXES_SPEED = 500, 5000, 1000
"""[deg/s], [mm/s], [deg/s] of every predefined speed; same table."""

_ZONES = {
    **{0: (0.3, 0.3, 0.3, 0.03, 0.3, 0.03), 1: (1, 1, 1, 0.1, 1, 0.1), 5: (5, 8, 8, 0.8, 8, 0.8)},
    **{10: (10, 15, 15, 1.5, 15, 1.5), 15: (15, 23, 23, 2.3, 23, 2.3), 20: (20, 30, 30, 3.0, 30, 3.0)},
    **{30: (30, 45, 45, 4.5, 45, 4.5), 40: (40, 60, 60, 6.0, 60, 6.0), 50: (50, 75, 75, 7.5, 75, 7.5)},
    **{60: (60, 90, 90, 9.0, 90, 9.0), 80: (80, 120, 120, 12, 120, 12), 100: (100, 150, 150, 15, 150, 15)},
    **{150: (150, 225, 225, 23, 225, 23), 200: (200, 300, 300, 30, 300, 30)},
}
"""Zones z0 to z200: TCP, orientation and external axes [mm], orientation [deg], linear [mm], rotating axes [deg];
RAPID reference manual (ABB 3HAC16581-1), zonedata."""

_NOWHERE = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))
"""Pose without displacement and turn."""

TOOL0: Value = (True, _NOWHERE, (0.001, (0.0, 0.0, 0.001), (1.0, 0.0, 0.0, 0.0), 0.0, 0.0, 0.0))
"""The flange itself, with the load of a gram that the manual gives it."""

WOBJ0: Value = (False, True, "", _NOWHERE, _NOWHERE)
"""The world."""

DESCRIBED_TOOL: Value = (True, _NOWHERE, (0.0, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), 0.0, 0.0, 0.0))
"""tRobot, the tool of the robot's description, which RAPID does not have: its frame is turned as tool0. That it weighs
nothing tells it from tools that a program may declare."""


def _speed(tcp: float) -> Value:
    return tuple(float(v) for v in (tcp, _ORIENT_SPEED, _LINEAR_AXES_SPEED, _ROTATING_AXES_SPEED))


PREDEFINED: Mapping[str, tuple[Type, Value]] = MappingProxyType(
    {
        **{f"v{v}": (SPEEDDATA, _speed(v)) for v in _SPEEDS},
        "vmax": (SPEEDDATA, _speed(_LARGEST_SPEED)),
        "fine": (ZONEDATA, (True, *(0.0,) * 6)),
        **{f"z{z}": (ZONEDATA, (False, *(float(v) for v in sizes))) for z, sizes in _ZONES.items()},
        "tool0": (TOOLDATA, TOOL0),
        "trobot": (TOOLDATA, DESCRIBED_TOOL),
        "load0": (LOADDATA, TOOL0[2]),
        "wobj0": (WOBJDATA, WOBJ0),
        **{f"inpos{size}": (STOPPOINTDATA, None) for size in (20, 50, 100)},
        "pi": (NUM, math.pi),
        **{"low": (NUM, 0.0), "high": (NUM, 1.0), "edge": (NUM, 2.0), "stempty": (STRING, "")},
    }
)
"""Type and value by name in lower case."""
