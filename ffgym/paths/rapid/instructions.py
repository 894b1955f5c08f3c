"""The instructions that are run, and what they take; RAPID reference manual (ABB 3HAC16581-1)."""

from collections.abc import Mapping

from ffgym.paths.rapid.arguments import Parameter
from ffgym.paths.rapid.records import JOINTTARGET, NUM, ROBTARGET, SPEEDDATA, TOOLDATA, WOBJDATA, ZONEDATA

_HOW = (
    Parameter("speed", SPEEDDATA, {"v": NUM}),
    Parameter("zone", ZONEDATA, {"z": NUM}),
    Parameter("tool", TOOLDATA, {"wobj": WOBJDATA}),
)
"""What every move takes behind its targets."""

_TARGET = Parameter("target", ROBTARGET)

MOVES: Mapping[str, tuple[Parameter, ...]] = {
    "moveabsj": (Parameter("target", JOINTTARGET, {"noeoffs": None}), *_HOW),
    "movej": (_TARGET, *_HOW),
    "movel": (_TARGET, *_HOW),
    "movec": (Parameter("point on the arc", ROBTARGET), _TARGET, *_HOW),
}
"""Moves by name in lower case."""

SWITCHES: Mapping[str, tuple[str, ...]] = {
    "confj": ("on", "off"),
    "confl": ("on", "off"),
    "singarea": ("off",),
}
"""Instructions that take one switch, and the switches that are supported."""

INSTRUCTIONS = ("MoveAbsJ", "MoveC", "MoveJ", "MoveL", "WaitTime", "ConfJ", "ConfL", "SingArea", "AccSet")
"""All of them, as they are written."""
