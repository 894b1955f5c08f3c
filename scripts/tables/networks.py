"""Tables of pages about laws, from the stored record of the demo: errors on circles of the nominal robot."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from scripts.claims.records import numbers_of
from scripts.tables.page import Contents, markdown
from scripts.tables.thesis import items

LAWS = {
    "none": "no compensation",
    "lugre_dynamic": "dynamic LuGre",
    "bsn_static": "static B-spline network",
    "bsn_extended": "extended B-spline network",
    "bsn_extended_prior": "extended B-spline network with prior",
}
"""Laws of the table, and their titles in the record of the thesis, which counts trials and robot time."""
SPEEDS = (10.0, 40.0, 100.0)


def select(agent: str, speed: float | None = None, positions: str = "p1 p2 p3 p4") -> list[dict[str, Any]]:
    """Rows of the record of a law, at a speed [mm/s] and at some positions."""
    rows: list[dict[str, Any]] = numbers_of("networks")["rows"]
    return [
        row
        for row in rows
        if row["agent"] == agent and speed in (None, row["speed_mm_s"]) and row["position"] in positions.split()
    ]


def path_mm(agent: str, speed: float, positions: str = "p1 p2 p3 p4") -> float:
    """Mean RMS path error over circles [mm]."""
    return float(np.mean([row["rms_mm"] for row in select(agent, speed, positions)]))


def motor_mrad(agent: str, speed: float, positions: str = "p1 p2 p3 p4") -> float:
    """Mean RMS motor error over circles and joints [mrad]."""
    return 1e3 * float(np.mean([row["motor_rms_rad"] for row in select(agent, speed, positions)]))


def bspline() -> Contents:
    """Errors of the motors and of the tool, where networks were trained and elsewhere."""
    rows: list[Sequence[str]] = []
    agents = {row[0]: row for row in items()["agents"]["numbers"][0]["rows"]}
    for title, measure, form in (("motor", motor_mrad, ".2f"), ("path", path_mm, ".3f")):
        for agent, known in LAWS.items():
            *_, trials, seconds = agents[known][:4]
            taken = f"{trials} ({seconds} s)" if title == "motor" and trials != "0" else ""
            name = agent if agent == "none" else f"`{agent}`"
            cells = [measure(agent, speed, where) for speed in SPEEDS for where in ("p1", "p2 p3 p4")]
            rows.append((f"{name}, {title}", taken, *(format(x, form) for x in cells)))
    head = [f"{speed:g} mm/s {where}" for speed in SPEEDS for where in ("p1", "p2-p4")]
    return Contents(parts={"results": markdown(("", "trials (robot time)", *head), rows)})


def compare(*agents: str) -> Contents:
    """Errors of laws where networks were trained and elsewhere, a column for each law."""
    rows = []
    for title, measure, form in (
        ("motor RMS [mrad]", motor_mrad, ".2f"),
        ("path RMS [mm]", path_mm, ".3f"),
    ):
        for where in ("p1", "p2 p3 p4"):
            for speed in SPEEDS:
                cells = [format(measure(agent, speed, where), form) for agent in agents]
                rows.append((f"{title}, {where.replace(' p3 ', '-')}", f"{speed:g} mm/s", *cells))
    names = ["none" if agent == "none" else f"`{agent}`" for agent in agents]
    return Contents(parts={"results": markdown(("", "", *names), rows)})


def lugre() -> Contents:
    """Path errors of both LuGre laws over all circles [mm]."""
    agents = ("none", "lugre_static", "lugre_dynamic")
    rows = [(f"{speed:g} mm/s", *(f"{path_mm(agent, speed):.3f}" for agent in agents)) for speed in SPEEDS]
    return Contents(parts={"results": markdown(("", "none", "static", "dynamic"), rows)})
