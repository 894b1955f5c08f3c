"""Functions of RAPID on positions, orientations, poses and targets."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import scipy

from ffgym.core.errors import FFGymError
from ffgym.paths.rapid import records
from ffgym.paths.rapid.functions import ArgumentRule, BuiltinFunction, CallRule, Options, takes
from ffgym.paths.rapid.predefined import WOBJ0
from ffgym.paths.rapid.records import JOINTTARGET, NUM, ORIENT, POS, POSE, ROBTARGET, TOOLDATA, WOBJDATA, Value
from ffgym.paths.rapid.targets import turn

if TYPE_CHECKING:
    from ffgym.paths.rapid.controller import RapidController

_Rotation = scipy.spatial.transform.Rotation


def to_orient(matrix: "np.typing.NDArray[np.float64]") -> Value:
    """Quaternion, scalar first and >= 0, of a rotation matrix (3, 3)."""
    q2, q3, q4, q1 = _Rotation.from_matrix(matrix).as_quat(canonical=True).tolist()
    return (q1, q2, q3, q4)


def _offs(controller: "RapidController", values: Sequence[Value], options: Options) -> Value:
    """Target displaced in the axes of the work object."""
    (position, *rest), *offset = values
    return (tuple(a + b for a, b in zip(position, offset, strict=True)), *rest)


def _rel_tool(controller: "RapidController", values: Sequence[Value], options: Options) -> Value:
    """Target displaced in the axes of the tool, then turned about its x, its new y and its new z."""
    (position, orient, *rest), *offset = values
    tool = turn(orient, "the target's rot")
    angles = [options.get(name, 0.0) for name in ("rx", "ry", "rz")]
    turned = tool @ _Rotation.from_euler("XYZ", angles, degrees=True).as_matrix()
    moved = np.array(position) + tool @ np.array(offset)
    return (tuple(moved.tolist()), to_orient(turned), *rest)


def _pose_mult(controller: "RapidController", values: Sequence[Value], options: Options) -> Value:
    (p1, r1), (p2, r2) = values
    first, second = turn(r1, "rot of the first pose"), turn(r2, "rot of the second pose")
    return (tuple((np.array(p1) + first @ np.array(p2)).tolist()), to_orient(first @ second))


def _pose_inv(controller: "RapidController", values: Sequence[Value], options: Options) -> Value:
    position, orient = values[0]
    back = turn(orient, "rot of the pose").T
    return (tuple((-back @ np.array(position)).tolist()), to_orient(back))


def _pose_vect(controller: "RapidController", values: Sequence[Value], options: Options) -> Value:
    (position, orient), vector = values
    return tuple((np.array(position) + turn(orient, "rot of the pose") @ np.array(vector)).tolist())


def _orient_zyx(controller: "RapidController", values: Sequence[Value], options: Options) -> Value:
    return to_orient(_Rotation.from_euler("ZYX", values, degrees=True).as_matrix())


def _euler_zyx(controller: "RapidController", values: Sequence[Value], options: Options) -> Value:
    z, y, x = _Rotation.from_matrix(turn(values[0], "the orientation")).as_euler("ZYX", degrees=True).tolist()
    if len(options) != 1:
        raise FFGymError(r"EulerZYX wants one of \X, \Y and \Z.")
    (axis,) = options
    return {"x": x, "y": y, "z": z}[axis]


def _norient(controller: "RapidController", values: Sequence[Value], options: Options) -> Value:
    norm = float(np.linalg.norm(values[0]))
    if norm == 0:
        raise FFGymError("an orientation of norm 0 cannot be normalised.")
    return tuple(x / norm for x in values[0])


def _frame_of_points(controller: "RapidController", values: Sequence[Value], options: Options) -> Value:
    """DefFrame: x from the first target to the second, y on the side of the third, origin at the first."""
    origin, on_x, on_xy = (np.array(target[0]) for target in values)
    x = on_x - origin
    z = np.cross(x, on_xy - origin)
    if not np.linalg.norm(z) > 0:
        raise FFGymError("the three targets of DefFrame lie on a line.")
    x, z = x / np.linalg.norm(x), z / np.linalg.norm(z)
    return (tuple(origin.tolist()), to_orient(np.column_stack([x, np.cross(z, x), z])))


def _here(controller: "RapidController", values: Sequence[Value], options: Options) -> Value:
    return controller.place.target(options.get("tool"), options.get("wobj"))


_OFFSETS = tuple(ArgumentRule(f"{axis}Offset", NUM) for axis in "XYZ")
_STEPS = tuple(ArgumentRule(f"D{axis}", NUM) for axis in "xyz")
_TARGET = ArgumentRule("target", ROBTARGET)
_FRAMES: Mapping[str, records.Type | None] = {"tool": TOOLDATA, "wobj": WOBJDATA}

GEOMETRY: Mapping[str, BuiltinFunction] = {
    "Offs": BuiltinFunction(CallRule((_TARGET, *_OFFSETS)), ROBTARGET, _offs),
    "RelTool": BuiltinFunction(
        CallRule((_TARGET, *_STEPS), dict.fromkeys(("rx", "ry", "rz"), NUM)), ROBTARGET, _rel_tool
    ),
    "PoseMult": BuiltinFunction(takes(POSE, POSE), POSE, _pose_mult),
    "PoseInv": BuiltinFunction(takes(POSE), POSE, _pose_inv),
    "PoseVect": BuiltinFunction(takes(POSE, POS), POS, _pose_vect),
    "OrientZYX": BuiltinFunction(takes(NUM, NUM, NUM), ORIENT, _orient_zyx),
    "EulerZYX": BuiltinFunction(
        CallRule((ArgumentRule("orientation", ORIENT),), dict.fromkeys("xyz")), NUM, _euler_zyx
    ),
    "NOrient": BuiltinFunction(takes(ORIENT), ORIENT, _norient),
    "DefFrame": BuiltinFunction(takes(ROBTARGET, ROBTARGET, ROBTARGET), POSE, _frame_of_points),
    "CRobT": BuiltinFunction(CallRule((), _FRAMES), ROBTARGET, _here, fixed=False),
    "CPos": BuiltinFunction(CallRule((), _FRAMES), POS, lambda *asked: _here(*asked)[0], fixed=False),
    "CJointT": BuiltinFunction(
        CallRule(), JOINTTARGET, lambda controller, *_: controller.place.joint_target(), fixed=False
    ),
    "CalcRobT": BuiltinFunction(
        CallRule((ArgumentRule("joint target", JOINTTARGET), ArgumentRule("tool", TOOLDATA)), {"wobj": WOBJDATA}),
        ROBTARGET,
        lambda controller, values, options: controller.place.calculate_target(
            values[0], values[1], work_object=options.get("wobj", WOBJ0)
        ),
    ),
    "CalcJointT": BuiltinFunction(
        CallRule((_TARGET, ArgumentRule("tool", TOOLDATA)), {"wobj": WOBJDATA}),
        JOINTTARGET,
        lambda controller, values, options: controller.place.calculate_joints(
            values[0], values[1], work_object=options.get("wobj", WOBJ0)
        ),
    ),
}
"""Functions by name; RAPID reference manual (ABB 3HAC16581-1). Here is the last target: corners are not rounded yet."""
