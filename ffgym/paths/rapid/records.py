"""Data types of RAPID: numbers, truth values, text, and records of them. A record's value is a tuple."""

from dataclasses import dataclass
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
        """What a VAR without value holds."""
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
