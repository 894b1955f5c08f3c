"""Data types of RAPID, and the data that every program can use without declaring them."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, TypeAlias

Value: TypeAlias = Any
"""float for num, bool, str, or a tuple of values for a record."""


@dataclass(frozen=True)
class Type:
    """A type, and how messages call a value of it."""

    name: str
    fields: "tuple[tuple[str, Type], ...]" = ()
    """Components in their order; none for num, bool and string."""

    def default(self) -> Value:
        """Value of a VAR without one."""
        if self.fields:
            return tuple(kind.default() for _, kind in self.fields)
        return {"num": 0.0, "bool": False, "string": ""}[self.name]

    def field(self, name: str) -> int:
        """Index of a component, whatever its case; -1 if there is none."""
        names = [field for field, _ in self.fields]
        return names.index(name.lower()) if name.lower() in names else -1

    @property
    def shape(self) -> str:
        """Its components as an aggregate, e.g. '[x, y, z]'."""
        return f"[{', '.join(name for name, _ in self.fields)}]" if self.fields else self.name


NUM = Type("num")
BOOL = Type("bool")
STRING = Type("string")


def _of(kind: Type, names: str) -> "tuple[tuple[str, Type], ...]":
    return tuple((name, kind) for name in names.split())


POS = Type("pos", _of(NUM, "x y z"))
ORIENT = Type("orient", _of(NUM, "q1 q2 q3 q4"))
POSE = Type("pose", (("trans", POS), ("rot", ORIENT)))
CONFDATA = Type("confdata", _of(NUM, "cf1 cf4 cf6 cfx"))
EXTJOINT = Type("extjoint", _of(NUM, "eax_a eax_b eax_c eax_d eax_e eax_f"))
ROBJOINT = Type("robjoint", _of(NUM, "rax_1 rax_2 rax_3 rax_4 rax_5 rax_6"))
ROBTARGET = Type("robtarget", (("trans", POS), ("rot", ORIENT), ("robconf", CONFDATA), ("extax", EXTJOINT)))
JOINTTARGET = Type("jointtarget", (("robax", ROBJOINT), ("extax", EXTJOINT)))
SPEEDDATA = Type("speeddata", _of(NUM, "v_tcp v_ori v_leax v_reax"))
ZONEDATA = Type("zonedata", (("finep", BOOL), *_of(NUM, "pzone_tcp pzone_ori pzone_eax zone_ori zone_leax zone_reax")))
LOADDATA = Type("loaddata", (("mass", NUM), ("cog", POS), ("aom", ORIENT), *_of(NUM, "ix iy iz")))
TOOLDATA = Type("tooldata", (("robhold", BOOL), ("tframe", POSE), ("tload", LOADDATA)))
WOBJDATA = Type(
    "wobjdata", (("robhold", BOOL), ("ufprog", BOOL), ("ufmec", STRING), ("uframe", POSE), ("oframe", POSE))
)

TYPES = {
    kind.name: kind
    for kind in (
        *(NUM, BOOL, STRING, POS, ORIENT, POSE, CONFDATA, EXTJOINT, ROBJOINT, ROBTARGET, JOINTTARGET),
        *(SPEEDDATA, ZONEDATA, LOADDATA, TOOLDATA, WOBJDATA),
    )
}
"""Types that data can be declared with, as the RAPID reference manual (ABB 3HAC16581-1) lays them out."""


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
        "wobj0": (WOBJDATA, WOBJ0),
    }
)
"""Type and value by name in lower case."""
