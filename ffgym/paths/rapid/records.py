"""Data types of RAPID."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, TypeAlias

Value: TypeAlias = Any
"""float for num, bool, str, a tuple of values for a record or an array, or another object."""


@dataclass(frozen=True)
class Type:
    """A type, and how messages call a value of it."""

    name: str
    fields: "tuple[tuple[str, Type], ...]" = ()
    """Components of a record in their order; none for other types."""
    dimensions: tuple[int, ...] = ()
    """Sizes of an array, 0 where any size will do; none for other types."""
    loose: bool = False
    """True if a value may be any aggregate, as components depend on the version of the controller."""

    def default(self) -> Value:
        """Value of a VAR without one."""
        if self.dimensions:
            return (self.element.default(),) * self.dimensions[0]
        if self.fields:
            return tuple(kind.default() for _, kind in self.fields)
        return {"num": 0.0, "bool": False, "string": ""}.get(self.name)

    def field(self, name: str) -> int:
        """Index of a component, whatever its case; -1 if there is none."""
        names = [field.lower() for field, _ in self.fields]
        return names.index(name.lower()) if name.lower() in names else -1

    @property
    def element(self) -> "Type":
        """Type of what the first index of an array gives: an element, or an array of one dimension less."""
        return replace(self, dimensions=self.dimensions[1:])

    def takes(self, other: "Type") -> bool:
        """Tell if a value of another type is one of this one."""
        if ANY in (self, other):
            return True
        if len(self.dimensions) != len(other.dimensions) or self.name != other.name:
            return False
        return all(size in (0, given) for size, given in zip(self.dimensions, other.dimensions, strict=True))

    @property
    def shape(self) -> str:
        """Its components as an aggregate, e.g. '[x, y, z]'."""
        return f"[{', '.join(name for name, _ in self.fields)}]" if self.fields else self.name

    def __str__(self) -> str:
        sizes = ",".join(str(size or "*") for size in self.dimensions)
        return f"{self.name}{{{sizes}}}" if sizes else self.name


NUM = Type("num")
BOOL = Type("bool")
STRING = Type("string")
SIGNAL = Type("signal")
"""Input or output of the controller; its value is its name."""
ANY = Type("any")
"""Argument of an instruction that does not move the arm, of whatever type."""


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

TRIGGDATA = Type("triggdata")
CLOCK = Type("clock")
SEAMDATA, WELDDATA, WEAVEDATA = (Type(name, loose=True) for name in ("seamdata", "welddata", "weavedata"))
STOPPOINTDATA = Type("stoppointdata", loose=True)

TYPES: Mapping[str, Type] = MappingProxyType(
    {
        kind.name: kind
        for kind in (
            *(NUM, BOOL, STRING, POS, ORIENT, POSE, CONFDATA, EXTJOINT, ROBJOINT, ROBTARGET, JOINTTARGET),
            *(SPEEDDATA, ZONEDATA, LOADDATA, TOOLDATA, WOBJDATA, TRIGGDATA, CLOCK),
            *(SEAMDATA, WELDDATA, WEAVEDATA, STOPPOINTDATA),
        )
    }
    | dict.fromkeys(("dnum", "byte", "errnum", "intnum", "dionum"), NUM)
    | {f"signal{kind}": SIGNAL for kind in ("di", "do", "gi", "go", "ai", "ao")}
)
"""Types that data can be declared with, as the RAPID reference manual (ABB 3HAC16581-1) lays them out. All numbers are
one type; seam, weld and weave data are those of Arc (ABB 3HAC16588-1)."""
