"""Set-points as URScript and as CSV: every sample of the plan, and reading of them."""

import csv
import io
import re

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.deployment.plan import SetpointPlan, numbers_per_unit
from ffgym.deployment.programs.names import program_name
from ffgym.deployment.programs.points import round_numbers
from ffgym.deployment.streams import ServoProgram


def write_servo_script(plan: SetpointPlan, servo: ServoProgram) -> dict[str, str]:
    """Write a URScript program that moves to the first set-point and sends all others by servoj.

    Raises:
        FFGymError: if the robot has not six hinges.
    """
    if plan.units != ("rad",) * 6:
        raise FFGymError(
            f"URScript moves six hinges, {plan.robot!r} has {len(plan.units)} joints in {', '.join(plan.units)}."
        )
    name = program_name(plan.name)
    setpoints = ("[" + ",".join(f"{x:.7f}" for x in row) + "]" for row in plan.setpoints)
    first, *others = setpoints
    how = f"t={plan.dt:g}, lookahead_time={servo.lookahead_time:g}, gain={servo.gain:g}"
    lines = [
        f"def {name}():",
        f"  # Corrected program of {plan.robot}: {len(plan.program)} set-points every {1e3 * plan.dt:g} ms.",
        f"  movej({first}, a=0.5, v=0.2)",
        *(f"  servoj({row}, {how})" for row in others),
        "  stopj(2.0)",
        "end",
        f"{name}()",
        "",
    ]
    return {f"{name}.script": "\n".join(lines)}


def read_servo_script(files: dict[str, str]) -> tuple[Array, float]:
    """Joint positions of a program in the order of its moves, shape (K, N), and its duration [s]."""
    ((_, text),) = files.items()
    rows = re.findall(r"(?:movej|servoj)\(\[([^\]]*)\]", text)
    times = re.findall(r", t=([\d.e-]+),", text)
    return np.array([[float(x) for x in row.split(",")] for row in rows]), sum(map(float, times))


def write_csv(plan: SetpointPlan, digits: int) -> dict[str, str]:
    """Write times and set-points with their correction, in degrees and millimetres, as tables of motions have them."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    units = ["deg" if unit == "rad" else "mm" for unit in plan.units]
    rows.writerow(["t_s", *(f"{joint}_{unit}" for joint, unit in zip(plan.joints, units, strict=True))])
    numbers = round_numbers(plan.setpoints, plan.units, digits) * numbers_per_unit(plan.units)
    for t, row in zip(plan.t, numbers, strict=True):
        rows.writerow([f"{t:.6g}", *(f"{x:.{digits}f}" for x in row)])
    return {f"{program_name(plan.name)}.csv": text.getvalue()}


def read_csv(files: dict[str, str], units: tuple[str, ...]) -> tuple[Array, float]:
    """Joint positions of a table, shape (K, N), and its duration [s]."""
    ((_, text),) = files.items()
    numbers = np.array([[float(x) for x in row] for row in list(csv.reader(io.StringIO(text)))[1:]])
    return numbers[:, 1:] / numbers_per_unit(units), float(numbers[-1, 0] - numbers[0, 0])
