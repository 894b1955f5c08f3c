"""Points as a KRL program: motion in a .src file, points in a .dat file, and reading of them."""

import re

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.deployment.plan import numbers_per_unit
from ffgym.deployment.programs.names import program_name
from ffgym.deployment.programs.points import PathPoints

_ADVANCE = 3
"""Moves that the controller plans ahead; KUKA's default."""
_APPROXIMATION = 50
"""Approximation of PTP moves before the first block [%]; KUKA's default."""


def write_krl(points: PathPoints) -> dict[str, str]:
    """Write a PTP spline through the points for each motion between rests, with the plan's time in a time block.

    Raises:
        FFGymError: if the robot has not six axes, or another number up to six.
    """
    if len(points.joints) > 6:
        raise FFGymError(f"KRL has axes A1 to A6, {points.robot!r} has {len(points.joints)} joints.")
    name = program_name(points.name)
    numbers = points.q * numbers_per_unit(points.units)
    data = ["&ACCESS RVP", f"DEFDAT {name}", ";FOLD POINTS"]
    for k, row in enumerate(numbers, start=1):
        axes = ",".join(f"A{j} {np.float32(x):.9g}" for j, x in enumerate(row, start=1))
        data.append(f"DECL E6AXIS X{k}={{{axes}}}")
    lines = [
        "&ACCESS RVP",
        f"DEF {name}()",
        f"; Corrected program of {points.robot}: {len(points.t)} points, {points.t[-1]:.3f} s",
        "; Corrections are in the points. Time blocks need KSS 8.3 or later; run it at 100 %",
        "BAS(#INITMOV,0)",
        "; Set $TOOL and $LOAD here as the original program has them: the controller plans with the load",
        f"$ADVANCE={_ADVANCE}",
        f"$APO.CPTP={_APPROXIMATION}",
        "PTP X1",
    ]
    k = 0
    while k < len(points.t) - 1:
        if points.rests[k]:
            lines += [f"WAIT SEC {points.t[k + 1] - points.t[k]:.4g}", f"PTP X{k + 2}"]
            k += 1
            continue
        end = next((i for i in range(k + 1, len(points.t)) if points.rests[i]), len(points.t) - 1)
        lines += _spline(points.t, k, end)
        k = end
    return {f"{name}.src": "\n".join([*lines, "END", ""]), f"{name}.dat": "\n".join([*data, ";ENDFOLD", "ENDDAT", ""])}


def _spline(t: Array, first: int, last: int) -> list[str]:
    """Lines of a spline from point `first` to `last`; parts of a time block are times in ms."""
    lines = ["PTP_SPLINE", "TIME_BLOCK START"]
    for k in range(first + 1, last + 1):
        lines += [f"SPTP X{k + 1}", f"TIME_BLOCK PART={1e3 * (t[k] - t[k - 1]):.3f}"]
    return [*lines, f"TIME_BLOCK END={t[last] - t[first]:.3f}", "ENDSPLINE"]


def read_krl(files: dict[str, str], units: tuple[str, ...]) -> tuple[Array, float]:
    """Joint positions of the points of a program in the order of its moves, shape (K, N), and its duration [s]."""
    source, data = (next(text for name, text in files.items() if name.endswith(end)) for end in (".src", ".dat"))
    found = {
        int(number): [float(x) for x in re.findall(r"A\d ([-+.\deE]+)", axes)]
        for number, axes in re.findall(r"E6AXIS X(\d+)=\{(.*?)\}", data)
    }
    order = [int(number) for number in re.findall(r"^S?PTP X(\d+)", source, flags=re.M)]
    times = re.findall(r"^(?:TIME_BLOCK END=|WAIT SEC )([\d.]+)", source, flags=re.M)
    return np.array([found[k] for k in order]) / numbers_per_unit(units), sum(map(float, times))
