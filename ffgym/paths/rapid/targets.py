"""Targets, speeds and zones of RAPID as moves have them: in the world, in SI units."""

import numpy as np

from ffgym.core.errors import FFGymError, check_whole
from ffgym.core.types import Array, BoolArray
from ffgym.paths.moves import Pose, Speed, Zone
from ffgym.paths.rapid.execution import Configuration
from ffgym.paths.rapid.frames import MILLIMETRE, Frame, frame
from ffgym.paths.rapid.records import EXTJOINT, Value

MAX_QUARTERS = 1000
"""Largest number of quarter turns that is believed; chosen: 250 turns, more than any axis has."""

UNUSED_AXIS = 9e9
"""Position of an external axis that is not there; RAPID reference manual (ABB 3HAC16581-1), extjoint."""


def pose(target: Value, name: str, tool: Frame, work_object: Value) -> Pose:
    """Where a robtarget puts TCP and flange.

    Args:
        target: the robtarget.
        name: its name, for messages.
        tool: the tool's frame in tool0.
        work_object: the wobjdata in which the target is given.

    Raises:
        FFGymError: if a quaternion is none, an external axis is used, or the work object moves.
    """
    check_external_axes(target[3], name)
    placed = work_frame(work_object).place(frame(target[:2], name))
    return Pose(position=placed.position, rotation=placed.rotation @ tool.rotation.T)


def work_frame(work_object: Value) -> Frame:
    """Object frame of a wobjdata in the world.

    Raises:
        FFGymError: if it moves with the robot or a mechanical unit.
    """
    robhold, ufprog, ufmec, uframe, oframe = work_object
    if robhold or not ufprog or ufmec:
        raise FFGymError(
            "the work object moves (robhold is TRUE, ufprog FALSE or ufmec not empty); only fixed ones are supported."
        )
    return frame(uframe, "uframe").place(frame(oframe, "oframe"))


def joint_positions(target: Value, sliding: BoolArray, name: str) -> Array:
    """Joint positions, link side [rad, or m where `sliding`], shape (N,), of a jointtarget.

    Raises:
        FFGymError: if it gives joints that the robot does not have, or uses an external axis.
    """
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
    """Quarter turns of axes 1, 4 and 6 that a robtarget asks for.

    Raises:
        FFGymError: if they are no whole numbers.
    """
    cf1, cf4, cf6, _ = (
        check_whole(f"robconf of {name}", value, low=-MAX_QUARTERS, high=MAX_QUARTERS) for value in target[2]
    )
    return cf1, cf4, cf6


def check_external_axes(external: Value, name: str) -> None:
    """Refuse external axes.

    Raises:
        FFGymError: if one of them is used.
    """
    used = [axis for (axis, _), value in zip(EXTJOINT.fields, external, strict=True) if value != UNUSED_AXIS]
    if used:
        raise FFGymError(f"{name} uses external axes ({', '.join(used)}), which are not supported; write 9E9 for each.")


def speed(data: Value, tcp: float | None) -> Speed:
    """Programmed speed of a speeddata; `tcp` [mm/s], if given, is used in place of its v_tcp.

    Raises:
        FFGymError: if it is not > 0.
    """
    v_tcp, v_ori, *_ = data
    return Speed(tcp=(v_tcp if tcp is None else tcp) * MILLIMETRE, turn=float(np.deg2rad(v_ori)))


def zone(data: Value, tcp: float | None) -> Zone:
    """Zone of a zonedata; `tcp` [mm], if given, is used in place of its pzone_tcp. Only the TCP's zone counts.

    Raises:
        FFGymError: if it is a fly-by point without a zone.
    """
    finep, pzone_tcp, *_ = data
    if finep:
        return Zone()
    radius = pzone_tcp if tcp is None else tcp
    if not radius > 0:
        raise FFGymError(f"a fly-by point needs a zone > 0 mm, got {radius:g}; use fine to stop.")
    return Zone(radius=radius * MILLIMETRE)
