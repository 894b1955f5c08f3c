"""A table of two short motions of the planar arm with two links, whose structures are fitted in seconds."""

from dataclasses import replace

import numpy as np

from ffgym.diagnosis.tables.error_table import ErrorTable, MotionKey, TableRow
from ffgym.diagnosis.tables.parts import find_structure
from ffgym.diagnosis.tables.simulated import TableSimulator
from ffgym.robot import load_robot

DT = 0.001

MOTION = """
start = [0.0, 0.5]

[[part]]
kind = "joints"
to = [{there}, 0.7]
speed = {speed}

[[part]]
kind = "joints"
to = [0.0, 0.5]
speed = {speed}
"""

SLOW, FAST = "slow.toml", "fast.toml"


def small_table(folder):
    """Errors of a machine whose numbers are half a spread from their typical values; motion files lie in `folder`."""
    for file, there, speed in ((SLOW, 0.1, 0.5), (FAST, 0.2, 1.0)):
        (folder / file).write_text(MOTION.format(there=there, speed=speed))
    rows = [
        TableRow(
            table="small",
            use="fitted",
            motion=MotionKey(file=file),
            radius_mm=0.0,
            law=law,
            statistic=statistic,
            value_mm=1.0,
        )
        for file in (SLOW, FAST)
        for law in ("none", "lugre_static")
        for statistic in ("rms", "max")
    ]
    empty = ErrorTable(title="small", source="", robot="two_link", rows=tuple(rows), folder=folder)
    robot, structure = load_robot(empty.robot), find_structure("numbers")
    x = 0.5 * structure.spread * np.array([1, -1, 1, -1, 1, -1, 1, -1, 1])
    values = TableSimulator(empty, robot).values([structure.candidate(robot, x)], rows, DT)[0]
    return replace(empty, rows=tuple(replace(row, value_mm=float(v)) for row, v in zip(rows, values, strict=True)))
