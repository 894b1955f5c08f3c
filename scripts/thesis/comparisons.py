"""The comparisons that claims are made of: errors with one law against errors with another, circle by circle."""

from collections.abc import Iterable, Sequence

import numpy as np

from ffgym.core.types import Array
from ffgym.recordings.metrics import motor_error_rms
from ffgym.report import law_styles
from ffgym.studies import Cell, CircleStudy, OneAxisStudy
from scripts.thesis.claims import CLEAR, Check


def label(law: str) -> str:
    """Words for a law."""
    return law_styles([law])[law].label


def against(law: str, than: str, by: float = 0.0) -> str:
    """Words for two laws that are compared, the other one's error less a share `by` of it."""
    return f"{label(law)} against {f'{1 - by:.0%} of ' if by else ''}{label(than)}"


def place(cell: Cell) -> str:
    """Where a circle is, for readers."""
    return f"{cell.position}, r = {cell.radius_mm:g} mm, {cell.speed_mm_s:g} mm/s"


def lower_path_errors(
    study: CircleStudy, law: str, than: str, by: float = 0.0, radii_mm: Iterable[float] | None = None
) -> list[Check]:
    """Whether the RMS path error of every circle is lower with `law` than with another, by a share `by` of it."""
    wanted = None if radii_mm is None else set(radii_mm)
    checks = []
    for cell in study.select(agent=law):
        if wanted is None or cell.radius_mm in wanted:
            other = same_circle(study, cell, than)
            where = f"{against(law, than, by)}, {place(cell)} [mm]"
            checks.append(Check(where=where, value=cell.rms_mm, limit=(1 - by) * other.rms_mm))
    return checks


def same_circle(study: CircleStudy, cell: Cell, law: str) -> Cell:
    """The circle of a cell with another law."""
    return study.select(agent=law, position=cell.position, radius_mm=cell.radius_mm, speed_mm_s=cell.speed_mm_s)[0]


def lower_motor_errors(
    study: CircleStudy, law: str, than: str, by: float = 0.0, joints: Sequence[int] | None = None
) -> list[Check]:
    """Whether the RMS motor error of every joint is lower with `law` than with another, by a share `by` of it.

    Args:
        study: the circle test.
        law: name.
        than: name of the other law.
        by: share of the other's error that must be gone.
        joints: numbers of the joints that count, from 1; None takes all.
    """
    chosen = [i for i in range(study.robot.n_joints) if joints is None or i + 1 in joints]
    checks = []
    for (name, position, speed), recording in study.recordings.items():
        if name == law:
            ours = motor_rms_mrad(study, law, position, speed)
            theirs = (1 - by) * motor_rms_mrad(study, than, position, speed)
            where = f"{against(law, than, by)}, {recording.header.segment}"
            checks += [
                Check(where=f"{where}, joint {i + 1} [mrad]", value=float(ours[i]), limit=float(theirs[i]))
                for i in chosen
            ]
    return checks


def motor_rms_mrad(study: CircleStudy, law: str, position: str, speed: float) -> Array:
    """RMS motor error over a whole motion without standstill [mrad], motor side, shape (N,); `speed` in m/s."""
    return motor_error_rms(study.recordings[law, position, speed]) * 1e3


def mean_motor_reduction(study: CircleStudy, law: str, than: str = "none") -> float:
    """Share of the RMS motor error that is gone, mean over joints and motions of the study."""
    keys = [(position, speed) for name, position, speed in study.recordings if name == law]
    shares = [1 - motor_rms_mrad(study, law, *key) / motor_rms_mrad(study, than, *key) for key in keys]
    return float(np.mean(shares))


def mean_path_reduction(study: CircleStudy, law: str, than: str = "none", radius_mm: float | None = None) -> float:
    """Share of the mean RMS path error that is gone, over all circles of the study or those of one radius."""
    cells = [cell for cell in study.select(agent=law) if radius_mm in (None, cell.radius_mm)]
    ours = np.mean([cell.rms_mm for cell in cells])
    theirs = np.mean([same_circle(study, cell, than).rms_mm for cell in cells])
    return float(1 - ours / theirs)


def clear_mean_gain(study: CircleStudy, laws: Sequence[str]) -> list[Check]:
    """Whether each law takes a clear share of the mean RMS path error away."""
    return [
        Check(
            where=f"{label(law)}, share of the mean RMS path error that is left",
            value=1 - mean_path_reduction(study, law),
            limit=1 - CLEAR,
        )
        for law in laws
    ]


def less_gained_than(study: CircleStudy, other: CircleStudy, laws: Sequence[str]) -> list[Check]:
    """Whether a smaller share of the mean RMS path error is gone in one study than in the other, law by law."""
    here, there = (f"{part.cells[0].speed_mm_s:g} mm/s" for part in (study, other))
    return [
        Check(
            where=f"{label(law)}, share of the mean RMS path error that is gone, {here} against {there}",
            value=mean_path_reduction(study, law),
            limit=mean_path_reduction(other, law),
        )
        for law in laws
    ]


def sine_rms_mrad(study: OneAxisStudy, law: str, frequency: float) -> float:
    """RMS motor error of the sine test [mrad], motor side; `frequency` in Hz."""
    [result] = [r for r in study.results if (r.agent, r.frequency_hz) == (law, frequency)]
    return result.motor_rms_rad * 1e3


def lower_sine_errors(study: OneAxisStudy, law: str, than: str, frequency: float, by: float = 0.0) -> Check:
    """Whether the RMS motor error of the sine test is lower with `law` than with another, by a share `by` of it."""
    return Check(
        where=f"{against(law, than, by)}, {frequency:g} Hz [mrad]",
        value=sine_rms_mrad(study, law, frequency),
        limit=(1 - by) * sine_rms_mrad(study, than, frequency),
    )


def less_left_than(study: OneAxisStudy, laws: Sequence[str], frequency: float, other: float) -> list[Check]:
    """Whether a smaller share of the RMS motor error is left at one frequency [Hz] than at the other."""
    left = {(result.agent, result.frequency_hz): 1 - result.reduction for result in study.results}
    return [
        Check(
            where=f"{label(law)}, share of the RMS error that is left, {frequency:g} against {other:g} Hz",
            value=left[law, frequency],
            limit=left[law, other],
        )
        for law in laws
    ]
