"""Functions of RAPID that return a target."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ffgym.paths.rapid.arguments import Parameter
from ffgym.paths.rapid.frames import turn
from ffgym.paths.rapid.records import NUM, ROBTARGET, Type, Value

Options = Mapping[str, Value]
"""Values of optional arguments by name in lower case."""


@dataclass(frozen=True)
class Function:
    """A function: what it takes, what it gives."""

    parameters: tuple[Parameter, ...]
    result: Type
    compute: Callable[[Sequence[Value], Options], Value]


def _offs(values: Sequence[Value], options: Options) -> Value:
    """Target displaced in the axes of the work object."""
    (position, *rest), *offset = values
    return (tuple(a + b for a, b in zip(position, offset, strict=True)), *rest)


def _rel_tool(values: Sequence[Value], options: Options) -> Value:
    """Target displaced in the axes of the tool, then turned about its x, its new y and its new z."""
    (position, orient, *rest), *offset = values
    tool = turn(orient, "the target's rot")
    angles = [options.get(name, 0.0) for name in ("rx", "ry", "rz")]
    turned = Rotation.from_matrix(tool) * Rotation.from_euler("XYZ", angles, degrees=True)
    moved = np.array(position) + tool @ np.array(offset)
    q2, q3, q4, q1 = turned.as_quat().tolist()
    return (tuple(moved.tolist()), (q1, q2, q3, q4), *rest)


_TARGET = Parameter("target", ROBTARGET)

FUNCTIONS: Mapping[str, Function] = {
    "offs": Function(
        (_TARGET, Parameter("XOffset", NUM), Parameter("YOffset", NUM), Parameter("ZOffset", NUM)), ROBTARGET, _offs
    ),
    "reltool": Function(
        (
            _TARGET,
            Parameter("Dx", NUM),
            Parameter("Dy", NUM),
            Parameter("Dz", NUM, {"rx": NUM, "ry": NUM, "rz": NUM}),
        ),
        ROBTARGET,
        _rel_tool,
    ),
}
"""By name in lower case; RAPID reference manual (ABB 3HAC16581-1), functions Offs and RelTool."""
