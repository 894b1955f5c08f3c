"""Troubles of real logs, put into simulated ones."""

from dataclasses import replace

import numpy as np

from ffgym.recordings import Recording
from tests.logs.quality.quality_logs import clean_log

ROBOT, MOTION = "two_link", "multisine"


def clean() -> Recording:
    return clean_log(ROBOT, MOTION)


def of_rows(recording: Recording, rows: np.ndarray, t: np.ndarray | None = None) -> Recording:
    """Some rows of a recording, at times of their own if given."""
    columns = {name: values[rows] for name, values in recording.columns.items()}
    if t is not None:
        columns["timestamp"] = t
    return Recording(columns, replace(recording.header, phases=()))


def jittered(recording: Recording, steps: tuple[int, ...] = (10, 10, 12)) -> Recording:
    """Rows read unevenly, with the controller's own time stamps; a step is a row of the recording."""
    at = np.cumsum(np.random.default_rng(0).choice(steps, size=len(recording)))
    return of_rows(recording, at[at < len(recording)])


def thin(recording: Recording, every: int = 10) -> Recording:
    return of_rows(recording, np.arange(0, len(recording), every))


def with_gaps(recording: Recording, gaps: tuple[tuple[int, int], ...]) -> Recording:
    """Without some rows: where each gap begins, and how many rows it has."""
    kept = np.ones(len(recording), dtype=bool)
    for first, rows in gaps:
        kept[first : first + rows] = False
    return of_rows(recording, np.flatnonzero(kept))


def doubled(recording: Recording, rows: tuple[int, ...]) -> Recording:
    """With rows that are written twice, the second time in the place of the next."""
    order = np.arange(len(recording))
    order[np.array(rows) + 1] = rows
    return of_rows(recording, order, recording.t)


def bad_row(recording: Recording, name: str, row: int) -> Recording:
    values = recording[name].copy()
    values[row] += 2 * np.ptp(values)
    return recording.with_columns({name: values})


def stopped(recording: Recording, at: float, rest: float = 2.0) -> Recording:
    """Brakes that close in the middle of the motion: speeds end within 20 ms, the motors' torques anyhow."""
    t, dt = recording.t, recording.dt
    first, braking = int(np.searchsorted(t, at)), round(0.02 / dt)
    n = first + braking + round(rest / dt)
    rows = np.minimum(np.arange(n), first)
    columns = {name: values[rows] for name, values in recording.columns.items()}
    columns["timestamp"] = t[0] + dt * np.arange(n)
    since = np.clip(np.arange(n) - first, 0, braking) * dt
    way = since - 0.5 * since**2 / (braking * dt)
    rng = np.random.default_rng(1)
    for joint in recording.header.joints:
        for family in ("motor.position", "link.position", "reference.position"):
            name = f"{family}.{joint}"
            if name in columns:
                speed = (recording[name][first] - recording[name][first - 20]) / (20 * dt)
                columns[name] = columns[name] + speed * way
        for family in ("motor.velocity", "link.velocity", "reference.velocity"):
            name = f"{family}.{joint}"
            if name in columns:
                columns[name] = columns[name] * (1 - since / (braking * dt))
        name = f"motor.effort.{joint}"
        noise = rng.normal(scale=0.05 * np.ptp(recording[name]), size=n - first)
        columns[name] = np.concatenate([columns[name][:first], 0.3 * columns[name][first] + noise])
    kept = {
        name: values
        for name, values in columns.items()
        if name.startswith(("timestamp", "motor.", "link.", "reference.position", "reference.velocity"))
    }
    return Recording(kept, replace(recording.header, phases=()))
