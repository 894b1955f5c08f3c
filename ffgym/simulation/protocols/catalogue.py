"""Every built-in protocol."""

from collections.abc import Mapping
from types import MappingProxyType

from ffgym.simulation.protocols.circles import Circles
from ffgym.simulation.protocols.diagnosis import Diagnosis
from ffgym.simulation.protocols.dwell_restart import DwellRestart
from ffgym.simulation.protocols.excitation import Excitation
from ffgym.simulation.protocols.holds import Holds
from ffgym.simulation.protocols.protocol import Protocol
from ffgym.simulation.protocols.slow_triangles import SlowTriangles
from ffgym.simulation.protocols.speed_ladder import SpeedLadder
from ffgym.simulation.protocols.table_6_1 import Table61
from ffgym.simulation.protocols.warm_up import WarmUp

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
