"""Every kind of part that a motion file may have."""

from collections.abc import Mapping
from types import MappingProxyType

from ffgym.paths.motions.parts.joint_parts import (
    JointsPart,
    LadderPart,
    MultisinePart,
    SinePart,
    TrianglePart,
    WaitPart,
)
from ffgym.paths.motions.parts.part import Part
from ffgym.paths.motions.parts.table_part import TablePart
from ffgym.paths.motions.parts.tool_parts import ArcPart, CirclePart, CircleTestPart, LinePart, SplinePart

PARTS: Mapping[str, type[Part]] = MappingProxyType(
    {
        part.kind: part
        for part in (
            LinePart,
            ArcPart,
            CirclePart,
            SplinePart,
            CircleTestPart,
            JointsPart,
            WaitPart,
            TablePart,
            SinePart,
            MultisinePart,
            LadderPart,
            TrianglePart,
        )
    }
)
"""Parts by what a file calls them."""
