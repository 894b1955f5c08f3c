"""Frames, targets, tools, speeds and zones of RAPID as moves have them: in the world, in SI units."""

from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np

from ffgym.core.errors import FFGymError, check_whole
from ffgym.core.types import Array, BoolArray
from ffgym.paths.moves import Pose, Speed, Zone
from ffgym.paths.rapid.predefined import DESCRIBED_TOOL, TOOL0
from ffgym.paths.rapid.records import EXTJOINT, Value
from ffgym.robot import RobotDescription
from ffgym.robot.parts import Tool, point_mass_inertia

Configuration = tuple[int, int, int]
"""Quarter turns of axes 1, 4 and 6: k for angles in [90 k, 90 (k + 1)) deg; RAPID's cf1, cf4 and cf6."""

MILLIMETRE = 1e-3
"""RAPID's unit of length [m]."""

LARGEST_NORM_ERROR = 1e-3
"""Tolerance of the norm of a quaternion; chosen: quaternions that are printed with three digits pass."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Frame:
    """Frame: pose of a coordinate system in another."""

    position: Array
    """Its origin [m], shape (3,)."""
    rotation: Array
    """Its orientation, shape (3, 3)."""

    def place(self, inner: "Frame") -> "Frame":
        """A frame that is given in this one, in the system in which this one is given."""
        return Frame(position=self.position + self.rotation @ inner.position, rotation=self.rotation @ inner.rotation)

    def inverse(self) -> "Frame":
        """The other system in this frame."""
        return Frame(position=-self.rotation.T @ self.position, rotation=self.rotation.T)


def point(pos: Value) -> Array:
    """Position [m], shape (3,), of a pos [mm]."""
    return np.array(pos) * MILLIMETRE


def turn(orient: Value, name: str) -> Array:
    """Rotation matrix, shape (3, 3), of an orient: a quaternion, scalar first."""
    norm = float(np.linalg.norm(orient))
    if not abs(norm - 1) <= LARGEST_NORM_ERROR:
        raise FFGymError(f"{name} = {list(orient)} has norm {norm:.6g}, must be a quaternion of norm 1.")
    matrix = np.zeros((3, 3))
    mujoco.mju_quat2Mat(matrix.reshape(-1), np.array(orient) / norm)
    return matrix


def frame(pose: Value, name: str) -> Frame:
    """Frame of a pose [mm]; `name` says whose it is."""
    position, orient = pose
    return Frame(position=point(position), rotation=turn(orient, f"{name}.rot"))


MAX_QUARTERS = 1000
"""Largest number of quarter turns that is believed; chosen: 250 turns, more than any axis has."""

UNUSED_AXIS = 9e9
"""Position of an external axis that is not there; RAPID reference manual (ABB 3HAC16581-1), extjoint."""


def pose(target: Value, name: str, tool: Frame, work_object: Value) -> Pose:
    """Compute the poses of TCP and flange of a robtarget in a work object; `tool` is the tool's frame in tool0."""
    check_external_axes(target[3], name)
    placed = object_frame(work_object).place(frame(target[:2], name))
    return Pose(position=placed.position, rotation=placed.rotation @ tool.rotation.T)


def object_frame(work_object: Value) -> Frame:
    """Frame of the object in a wobjdata, which must not move, in the world."""
    robhold, ufprog, ufmec, uframe, oframe = work_object
    if robhold or not ufprog or ufmec:
        raise FFGymError(
            "the work object moves (robhold is TRUE, ufprog FALSE or ufmec not empty); only fixed ones are supported."
        )
    return frame(uframe, "uframe").place(frame(oframe, "oframe"))


def joint_positions(target: Value, sliding: BoolArray, name: str) -> Array:
    """Joint positions, link side [rad, or m where `sliding`], shape (N,), of a jointtarget."""
    joints, external = target
    check_external_axes(external, name)
    if len(sliding) > len(joints):
        raise FFGymError(f"a jointtarget has {len(joints)} joints, the robot {len(sliding)}.")
    extra = [value for value in joints[len(sliding) :] if value not in (0.0, UNUSED_AXIS)]
    if extra:
        raise FFGymError(
            f"{name} moves {len(joints)} joints, the robot has {len(sliding)}; write 0 or 9E9 for those it lacks."
        )
    used = np.array(joints[: len(sliding)])
    return np.where(sliding, used * MILLIMETRE, np.deg2rad(used))


def quarter_turns(target: Value, name: str) -> Configuration:
    """Quarter turns of axes 1, 4 and 6 that a robtarget asks for."""
    cf1, cf4, cf6, _ = (
        check_whole(f"robconf of {name}", value, low=-MAX_QUARTERS, high=MAX_QUARTERS) for value in target[2]
    )
    return cf1, cf4, cf6


def check_external_axes(external: Value, name: str) -> None:
    """Refuse external axes that move; 0 is what programs write for axes that are not there, beside 9E9."""
    used = [axis for (axis, _), value in zip(EXTJOINT.fields, external, strict=True) if value not in (0.0, UNUSED_AXIS)]
    if used:
        raise FFGymError(f"{name} uses external axes ({', '.join(used)}), which are not supported; write 9E9 for each.")


@dataclass(frozen=True)
class MotionSettings:
    """Settings by VelSet and AccSet for the moves that follow."""

    override: float = 1.0
    """Share of the programmed speeds."""
    fastest: float = np.inf
    """Largest speed of the TCP [m/s]."""
    acceleration: float = 1.0
    """Share of the ordinary acceleration."""
    ramp: float = 1.0
    """Share of the ordinary jerk."""


def speed(data: Value, tcp: float | None, settings: MotionSettings) -> Speed:
    """Programmed speed of a speeddata under settings; `tcp` [mm/s], if given, is used in place of its v_tcp."""
    v_tcp, v_ori, *_ = data
    return Speed(
        tcp=min((v_tcp if tcp is None else tcp) * MILLIMETRE * settings.override, settings.fastest),
        turn=float(np.deg2rad(v_ori)) * settings.override,
        acceleration=settings.acceleration,
        jerk=settings.acceleration * settings.ramp,
    )


def zone(data: Value, tcp: float | None) -> Zone:
    """Zone of a zonedata; `tcp` [mm], if given, is used in place of its pzone_tcp. Only the TCP's zone counts."""
    finep, pzone_tcp, *_ = data
    if finep:
        return Zone()
    radius = pzone_tcp if tcp is None else tcp
    if not radius > 0:
        raise FFGymError(f"a fly-by point needs a zone > 0 mm, got {radius:g}; use fine to stop.")
    return Zone(radius=radius * MILLIMETRE)


_ROUNDING = 1e-6
"""Relative difference up to which a program's tool is the described one; programs are written with fewer digits."""


def tool_frame(tool: Value) -> Frame:
    """Frame of a tooldata in tool0."""
    robhold, tframe, _ = tool
    if not robhold:
        raise FFGymError("the tool stands still (robhold is FALSE); only tools that the robot holds are supported.")
    return frame(tframe, "tframe")


def with_tool(robot: RobotDescription, tool: Value, source: str) -> RobotDescription:
    """Robot that holds a program's tool, which stands at `source`; the same object if it holds it already."""
    if robot.tool is None and tool in (TOOL0, DESCRIBED_TOOL):
        return robot  # which moves in joint space only
    if robot.tool is None:
        raise FFGymError(
            f"robot {robot.name!r} has no flange to hold a tool; add flange.rotation and tool.tcp to its description."
        )
    if tool == DESCRIBED_TOOL:
        return robot
    held = _hold(robot.tool, tool)
    own = {f"tool.{name}": np.asarray(getattr(held, name)) for name in ("tcp", "mass", "com", "inertia")}
    described = {path: np.asarray(getattr(robot.tool, path.removeprefix("tool."))) for path in own}
    if all(np.allclose(own[path], x, rtol=0, atol=_ROUNDING * np.abs(x).max()) for path, x in described.items()):
        return robot
    fields: dict[str, Any] = {"origin": ("sourced",), "source": source, "prior": None, "prior_source": None}
    quantities = {
        path: replace(quantity, value=own[path], **fields) if path in own else quantity
        for path, quantity in robot.quantities.items()
    }
    geoms = tuple(geom for geom in robot.geoms if geom.body != "tool")  # they show the tool that is taken off
    return replace(robot, tool=held, geoms=geoms, quantities=quantities)


def _hold(flange: Tool, tool: Value) -> Tool:
    """Tool on the flange of another; tool0 weighs nothing, whatever load the manual gives it."""
    tcp = tool_frame(tool).position
    mass, cog, aom, *moments = tool[2]
    if tool == TOOL0:
        return Tool(rotation=flange.rotation, position=flange.position, tcp=tcp)
    if not mass > 0 or min(moments) < 0:
        raise FFGymError(f"tload has mass {mass:g} kg and moments {moments} kg m^2; mass must be > 0, moments >= 0.")
    inertia = point_mass_inertia(mass)
    if any(moments):  # about axes that are turned in tool0
        axes = turn(aom, "aom")
        inertia = (axes @ np.diag(moments) @ axes.T)[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    return replace(flange, tcp=tcp, mass=mass, com=point(cog), inertia=inertia)
