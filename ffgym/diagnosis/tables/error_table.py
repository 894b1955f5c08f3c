"""Tables of measured path errors of one robot: rows, some to fit models to and some to judge them by."""

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text
from ffgym.core.types import Array, BoolArray

Use = Literal["fitted", "held_out"]
Statistic = Literal["rms", "max"]


@dataclass(frozen=True, kw_only=True)
class MotionKey:
    """Motion that rows of a table belong to: circles at a position and speed, or a motion file."""

    position: str = ""
    speed_mm_s: float = 0.0
    file: str = ""
    """Motion file, relative to the table; empty for circles."""

    @property
    def title(self) -> str:
        """Title for people."""
        return self.file or f"{self.position}, {self.speed_mm_s:g} mm/s"


@dataclass(frozen=True, kw_only=True)
class TableRow:
    """One measured path error."""

    table: str
    """Name of the table or campaign that the row comes from."""
    use: Use
    """Use of the row: to fit the numbers of a model, or to judge it."""
    motion: MotionKey
    radius_mm: float
    """Radius of the circle [mm]; 0 for a motion file, which is scored as a whole."""
    law: str
    """Feed-forward law of the controller: 'none', 'lugre_static', 'lugre_dynamic', or the name of an agent."""
    statistic: Statistic
    """Root mean square or largest deviation from the path."""
    value_mm: float
    """Measured error [mm]."""

    @property
    def cell(self) -> str:
        """Label of motion and radius, which rows of several laws and statistics share."""
        return self.motion.title + (f", r = {self.radius_mm:g} mm" if self.radius_mm else "")


@dataclass(frozen=True, kw_only=True)
class SignQuestion:
    """Question whether a law makes the RMS error of some cells smaller or larger than no compensation does."""

    law: str
    speed_mm_s: float
    radius_mm: float


@dataclass(frozen=True, kw_only=True)
class ErrorTable:
    """Measured path errors of one robot.

    Raises:
        FFGymError: if there is no row to fit to, two rows are of one measurement, or no rows answer the question of
            the sign.
    """

    title: str
    source: str
    robot: str
    """Built-in robot, or a description (.toml)."""
    rows: tuple[TableRow, ...]
    folder: Path | None = None
    """Folder that motion files are relative to; None without a file."""
    alike: tuple[tuple[str, ...], ...] = ()
    """Groups of positions that are mirror images, of which a search simulates the first."""
    sign_of: SignQuestion | None = None

    def __post_init__(self) -> None:
        seen: set[tuple[Any, ...]] = set()
        for row in self.rows:
            key = (row.motion, row.radius_mm, row.law, row.statistic)
            if key in seen:
                raise FFGymError(
                    f"Two rows of {self.title!r} are of one measurement: {row.law}, {row.statistic}, {row.cell}. "
                    f"Keep one, or their mean."
                )
            seen.add(key)
        if not self.fitted.any():
            raise FFGymError(f"{self.title!r} has no row to fit to: write 'fitted' into the column 'use' of some.")
        if (asked := self.sign_of) is not None and not self.sign_pairs():
            raise FFGymError(
                f"{self.title!r} has no two RMS rows of one position, with law {asked.law!r} and 'none', at "
                f"{asked.speed_mm_s:g} mm/s and r = {asked.radius_mm:g} mm, as sign_of asks for. Leave sign_of out."
            )

    @cached_property
    def values(self) -> Array:
        """Measured errors [mm], shape (R,)."""
        return np.array([row.value_mm for row in self.rows])

    @cached_property
    def fitted(self) -> BoolArray:
        """Rows that models are fitted to, shape (R,)."""
        return np.array([row.use == "fitted" for row in self.rows])

    @cached_property
    def is_rms(self) -> BoolArray:
        """Rows of root mean squares, shape (R,)."""
        return np.array([row.statistic == "rms" for row in self.rows])

    @property
    def motions(self) -> tuple[MotionKey, ...]:
        """Motions in the order of the rows, each once."""
        return tuple(dict.fromkeys(row.motion for row in self.rows))

    def motion_file(self, key: MotionKey) -> Path:
        """Return the path of the file of a motion."""
        return Path(key.file) if self.folder is None else self.folder / key.file

    @property
    def motion_texts(self) -> tuple[str, ...]:
        """Texts of the motion files.

        Raises:
            FFGymError: if a file cannot be read.
        """
        return tuple(read_text(self.motion_file(key)) for key in self.motions if key.file)

    @property
    def places(self) -> tuple[str, ...]:
        """Positions, or motion files, of the fitted rows: what can be left out of a fit at a time."""
        rows = [row for row in self.rows if row.use == "fitted"]
        return tuple(dict.fromkeys(row.motion.position or row.motion.file for row in rows))

    @cached_property
    def _circles(self) -> set[tuple[MotionKey, float]]:
        """Motions and radii of all rows."""
        return {(row.motion, row.radius_mm) for row in self.rows}

    def twin(self, row: TableRow) -> TableRow:
        """Return the row at the first alike position that has its circle, which a search simulates in its place."""
        group = next((group for group in self.alike if row.motion.position in group), ())
        twins = [replace(row.motion, position=position) for position in group]
        motion = next((motion for motion in twins if (motion, row.radius_mm) in self._circles), row.motion)
        return replace(row, motion=motion)

    def sign_pairs(self) -> list[tuple[int, int]]:
        """Pairs of rows (with the law, without compensation) that the question of the sign compares."""
        asked = self.sign_of
        if asked is None:
            return []
        found: dict[MotionKey, dict[str, int]] = {}
        for i, row in enumerate(self.rows):
            if (row.motion.speed_mm_s, row.radius_mm, row.statistic) == (asked.speed_mm_s, asked.radius_mm, "rms"):
                found.setdefault(row.motion, {})[row.law] = i
        return [(laws[asked.law], laws["none"]) for laws in found.values() if {asked.law, "none"} <= set(laws)]

    def at(self, place: str) -> BoolArray:
        """Fitted rows at a place, shape (R,)."""
        return self.fitted & np.array([(row.motion.position or row.motion.file) == place for row in self.rows])
