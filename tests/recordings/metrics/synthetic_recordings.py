"""Recordings of circles whose deviations are known, for tests of the metrics."""

from typing import Any

import numpy as np

from ffgym.recordings import Header, Phase, Recording

DT = 0.001
REST, RUN = 0.2, 1.0
"""Seconds of standstill before the circle, and on it."""
CENTRE = np.array([1.3, -0.2, 0.6])
RADIUS = 0.005
FIRST, SECOND, NORMAL = np.eye(3)


def phases() -> tuple[Phase, ...]:
    """Rest and circle."""
    return (
        Phase(label="rest 0", kind="standstill", start=0.0, end=REST),
        Phase(label="circle 5 mm", kind="circle", start=REST, end=REST + RUN),
    )


def clock() -> np.ndarray:
    return DT * np.arange(round((REST + RUN) / DT) + 1)


def on_circle(angle: np.ndarray, radius: Any = RADIUS, height: Any = 0.0) -> np.ndarray:
    """Points (T, 3) at `angle` [rad] of a circle about CENTRE."""
    radius, height = np.broadcast_to(radius, angle.shape), np.broadcast_to(height, angle.shape)
    flat = radius[:, None] * (np.cos(angle)[:, None] * FIRST + np.sin(angle)[:, None] * SECOND)
    return CENTRE + flat + height[:, None] * NORMAL


def angles(t: np.ndarray) -> np.ndarray:
    """Angle of the reference [rad]: still, then one turn in RUN."""
    return 2 * np.pi / RUN * np.maximum(t - REST, 0.0)


def circle_recording(
    outward: Any = 0.0, height: Any = 0.0, offset: Any = 0.0, lag: float = 0.0, **changes: Any
) -> Recording:
    """A tool that leaves the reference by `outward` and `height` [m] on the circle, and everywhere by `offset`.

    Args:
        outward: radial deviation [m], a number or a function of the reference angle.
        height: deviation along the normal [m], likewise.
        offset: constant offset of the tool's frame [m], shape (3,).
        lag: delay of the tool [s].
        changes: columns or header fields to replace; None removes a column.
    """
    t = clock()
    reached = angles(t - lag)
    moving = t >= REST

    def on(deviation: Any) -> np.ndarray:
        value = deviation(angles(t)) if callable(deviation) else deviation
        return np.where(moving, value, 0.0)

    tcp = on_circle(reached, RADIUS + on(outward), on(height)) + np.asarray(offset)
    reference = on_circle(angles(t))
    columns: dict[str, Any] = {"timestamp": t}
    for k, axis in enumerate("xyz"):
        columns |= {f"tcp.position.{axis}": tcp[:, k], f"tcp_reference.position.{axis}": reference[:, k]}
    values = {
        "robot": "drawn",
        "joints": ("j1",),
        "gear_ratio": (100.0,),
        "segment": "drawn circle",
        "phases": phases(),
    }
    for name, value in changes.items():
        if name in values:
            values[name] = value
    columns |= changes.get("columns", {})
    columns = {name: column for name, column in columns.items() if column is not None}
    return Recording(columns, Header(**values))
