"""The tool of a program, as frame of its targets and as part of the robot."""

from dataclasses import replace

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.paths.rapid.frames import Frame, frame, point, turn
from ffgym.paths.rapid.predefined import DESCRIBED_TOOL, TOOL0
from ffgym.paths.rapid.records import Value
from ffgym.robot import RobotDescription
from ffgym.robot.parts import Tool, point_mass_inertia
from ffgym.robot.reading.quantity import Quantity

_ROUNDING = 1e-6
"""Relative difference up to which a program's tool is the described one; programs are written with fewer digits."""


def tool_frame(tool: Value) -> Frame:
    """Frame of a tooldata in tool0.

    Raises:
        FFGymError: if the robot does not hold it, or its quaternion is none.
    """
    robhold, tframe, _ = tool
    if not robhold:
        raise FFGymError("the tool stands still (robhold is FALSE); only tools that the robot holds are supported.")
    return frame(tframe, "tframe")


def with_tool(robot: RobotDescription, tool: Value, source: str) -> RobotDescription:
    """Robot that holds a program's tool; the same object if it does already.

    Args:
        robot: the robot.
        tool: tooldata.
        source: where the program says so.

    Raises:
        FFGymError: if the robot has no flange, or the tool's load is none.
    """
    if robot.tool is None and tool in (TOOL0, DESCRIBED_TOOL):
        return robot  # which moves in joint space only
    if robot.tool is None:
        raise FFGymError(
            f"robot {robot.name!r} has no flange to hold a tool; add flange.rotation and tool.tcp to its description."
        )
    if tool == DESCRIBED_TOOL:
        return robot
    held = _held(robot.tool, tool)
    if _same(held, robot.tool):
        return robot
    own = {f"tool.{name}": getattr(held, name) for name in ("tcp", "mass", "com", "inertia")}
    quantities = {
        path: _from_program(quantity, own[path], source) if path in own else quantity
        for path, quantity in robot.quantities.items()
    }
    geoms = tuple(geom for geom in robot.geoms if geom.body != "tool")  # they show the tool that is taken off
    return replace(robot, tool=held, geoms=geoms, quantities=quantities)


def _held(flange: Tool, tool: Value) -> Tool:
    """Tool on the flange of another; tool0 weighs nothing, whatever load the manual gives it."""
    tcp = tool_frame(tool).position
    mass, cog, aom, *moments = tool[2]
    if tool == TOOL0:
        return Tool(rotation=flange.rotation, position=flange.position, tcp=tcp)
    if not mass > 0 or min(moments) < 0:
        raise FFGymError(f"tload has mass {mass:g} kg and moments {moments} kg m^2; mass must be > 0, moments >= 0.")
    inertia = _inertia(turn(aom, "aom"), moments) if any(moments) else point_mass_inertia(mass)
    return replace(flange, tcp=tcp, mass=mass, com=point(cog), inertia=inertia)


def _inertia(axes: Array, moments: list[float]) -> Array:
    """Inertia [kg m^2] in tool0 axes, order xx, yy, zz, xy, xz, yz, of moments about axes that are turned in tool0."""
    matrix = axes @ np.diag(moments) @ axes.T
    inertia: Array = matrix[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    return inertia


def _same(a: Tool, b: Tool) -> bool:
    """Whether two tools are one but for rounding."""
    pairs = [(a.tcp, b.tcp), (np.array(a.mass), np.array(b.mass)), (a.com, b.com), (a.inertia, b.inertia)]
    return all(np.allclose(x, y, rtol=0, atol=_ROUNDING * np.abs(y).max()) for x, y in pairs)


def _from_program(quantity: Quantity, value: Array | float, source: str) -> Quantity:
    """Quantity of the robot's description with a program's number in it."""
    return replace(quantity, value=np.asarray(value), origin=("sourced",), source=source, prior=None, prior_source=None)
