"""Every built-in protocol."""

from collections.abc import Mapping
from types import MappingProxyType

from ffgym.protocols.circles import Circles
from ffgym.protocols.diagnosis import Diagnosis
from ffgym.protocols.dwell_restart import DwellRestart
from ffgym.protocols.excitation import Excitation
from ffgym.protocols.holds import Holds
from ffgym.protocols.protocol import Protocol
from ffgym.protocols.slow_triangles import SlowTriangles
from ffgym.protocols.speed_ladder import SpeedLadder
from ffgym.protocols.table_6_1 import Table61
from ffgym.protocols.warm_up import WarmUp

PROTOCOLS: Mapping[str, type[Protocol]] = MappingProxyType(
    {
        protocol.name: protocol
        for protocol in (
            Diagnosis,
            SpeedLadder,
            Table61,
            SlowTriangles,
            DwellRestart,
            WarmUp,
            Holds,
            Excitation,
            Circles,
        )
    }
)
"""Protocols by what command lines and files call them."""
