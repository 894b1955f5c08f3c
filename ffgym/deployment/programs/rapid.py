"""Points as a RAPID module, and the path that it gives when it is read back."""

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.files import write_text
from ffgym.core.temporaries import scratch_folder
from ffgym.core.types import Array
from ffgym.deployment.plan import numbers_per_unit
from ffgym.deployment.programs.names import program_name
from ffgym.deployment.programs.points import ZONE, PathPoints
from ffgym.paths.limits import MotionLimits
from ffgym.paths.motions.composition import rapid_motion
from ffgym.paths.rapid.geometry import to_orient
from ffgym.robot import RigidArm

MOVES_IN_PROCEDURE = 500
"""Most moves of a procedure; chosen: a page that a programmer can still step through."""
_ZONE = 1e3 * ZONE
"""Zone of all points [mm]: most are closer than it, so that a corner begins halfway to its neighbours."""
_SLOWEST = 0.01
"""Least speed that is written [mm/s or deg/s]; chosen: 0 is no speed."""
_FREE = (7000.0, 500.0)
"""Speeds [mm/s] and [deg/s] that bound nothing; those of RAPID's vmax."""
_ARM = 0.1
"""Motion of the tool [m] that counts as much as a turn by 1 rad; chosen: the size of a tool."""
_CREEP = (10.0, 10.0)
"""Speeds of the tool [mm/s] and [deg/s] to the first point and to one behind a rest, which are micrometres away."""
_EXTERNAL = "[9E9,9E9,9E9,9E9,9E9,9E9]"


def write_rapid(points: PathPoints, arm: RigidArm) -> dict[str, str]:
    """Write a module of MoveAbsJ with speeds that take from point to point the time that the plan takes.

    Raises:
        FFGymError: if RAPID cannot have the robot's joints.
    """
    if len(points.joints) > 6:
        raise FFGymError(f"RAPID has jointtargets of 6 joints, {points.robot!r} has {len(points.joints)}.")
    name = program_name(points.name)
    moves = list(_moves(points))
    parts = [moves[i : i + MOVES_IN_PROCEDURE] for i in range(0, len(moves), MOVES_IN_PROCEDURE)]
    lines = [
        f"MODULE {name}",
        f"  ! Corrected program of {points.robot}: {len(points.t)} points, {points.t[-1]:.3f} s.",
        "  ! Corrections are in the points. Speeds are those of the TCP of tPath; run it at 100 %.",
        f"  PERS tooldata tPath:={_tool(arm)};",
        f"  CONST zonedata zPath:=[FALSE,{_ZONE},{_ZONE},{_ZONE},0.03,{_ZONE},0.03];",
        "",
        "  PROC main()",
        *(f"    part{i};" for i in range(1, len(parts) + 1)),
        "  ENDPROC",
    ]
    for i, part in enumerate(parts, start=1):
        lines += ["", f"  PROC part{i}()", *(f"    {line}" for line in part), "  ENDPROC"]
    return {f"{name}.mod": "\n".join([*lines, "ENDMODULE", ""])}


def _moves(points: PathPoints) -> list[str]:
    """Lines of the moves and waits."""
    numbers = points.q * numbers_per_unit(points.units)
    lines: list[str] = []
    for k, row in enumerate(numbers):
        if k > 0 and points.rests[k - 1]:
            lines.append(f"WaitTime {points.t[k] - points.t[k - 1]:.4g};")
            if np.array_equal(points.q[k], points.q[k - 1]):
                continue
        joints = ",".join(f"{np.float32(x):.9g}" for x in [*row, *(0.0,) * (6 - len(row))])
        speed, turn = _CREEP if k == 0 or points.rests[k - 1] else _speeds(points, k)
        zone = "fine" if points.stops[k] else "zPath"
        lines.append(f"MoveAbsJ [[{joints}],{_EXTERNAL}]\\NoEOffs,[{speed:.6g},{turn:.6g},5000,1000],{zone},tPath;")
    return lines


def _speeds(points: PathPoints, k: int) -> tuple[float, float]:
    """Speeds of the tool [mm/s] and [deg/s] to a point: that of the larger motion counts, the other is left free."""
    if points.lengths[k] >= _ARM * points.turns[k]:
        return max(1e3 * float(points.speeds[k]), _SLOWEST), _FREE[1]
    return _FREE[0], max(float(np.rad2deg(points.turn_speeds[k])), _SLOWEST)


def _tool(arm: RigidArm) -> str:
    """Tooldata of the robot's tool: its frame turned as tool0, its load with principal moments of inertia."""
    tool = arm.robot.tool
    assert tool is not None
    tcp, com = (_numbers(1e3 * part) for part in (tool.tcp, tool.com))
    if not tool.mass > 0:
        return f"[TRUE,[[{tcp}],[1,0,0,0]],[0.001,[{com}],[1,0,0,0],0,0,0]]"
    xx, yy, zz, xy, xz, yz = tool.inertia
    moments, axes = np.linalg.eigh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
    axes *= np.sign(np.linalg.det(axes))
    aom = _numbers(np.array(to_orient(axes)))
    load = f"[{tool.mass:.9g},[{com}],[{aom}],{_numbers(np.maximum(moments, 0.0))}]"
    return f"[TRUE,[[{tcp}],[1,0,0,0]],{load}]"


def _numbers(values: Array) -> str:
    return ",".join(f"{x:.9g}" for x in values)


def read_rapid(files: dict[str, str], arm: RigidArm) -> tuple[Array, float]:
    """Joint positions of the path that a module gives, with its corners, shape (K, N), and its duration [s].

    The limits of joint moves are those of all paths: a controller that runs points knows no slower ones.
    """
    ((name, text),) = files.items()
    limits = MotionLimits(joint_rise=12.5, joint_rise_jerk=2000.0)
    with scratch_folder() as folder:
        path = folder / name
        write_text(path, text)
        reference = rapid_motion(arm, path, limits=limits).reference
    rests = sum(phase.end - phase.start for phase in reference.phases if phase.label in ("rest 0", "rest 1"))
    return reference.q, reference.duration - rests
