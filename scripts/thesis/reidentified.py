"""Beyond the thesis: does feed-forward with re-identified friction beat that with the old one? Left open in 6.1.3.

All joints of the workcell are identified as joint 1 in thesis 6.1, from motions of one joint at a time about home. Then
both sets of parameters are used by the same law, on circles, none of which was used.
"""

from collections.abc import Sequence

import numpy as np

from ffgym.report import ReportFigure
from ffgym.report.circles.bars import motor_error_caption, motor_error_figure
from ffgym.report.circles.comparison import percent
from ffgym.studies import CircleStudy
from scripts.thesis.claims import EVERY, MOST, Check, Claim
from scripts.thesis.comparisons import lower_motor_errors, lower_path_errors, mean_path_reduction
from scripts.thesis.items import Item, PlainTable
from scripts.thesis.laboratory import IDENTIFIED, Laboratory

OLD = "lugre_dynamic"
"""Dynamic LuGre with the parameters that the controller's model carries."""


def _path(laboratory: Laboratory) -> list[Check]:
    return lower_path_errors(laboratory.reidentified_circles, IDENTIFIED, OLD)


def _mean_path(laboratory: Laboratory) -> list[Check]:
    return [
        Check(
            where=f"{speed:g} mm/s, mean RMS path error, identified over old",
            value=1 - mean_path_reduction(study, IDENTIFIED, OLD),
            limit=1.0,
        )
        for speed, study in _by_speed(laboratory).items()
    ]


def _motors(laboratory: Laboratory) -> list[Check]:
    return lower_motor_errors(laboratory.reidentified_circles, IDENTIFIED, OLD)


def _by_speed(laboratory: Laboratory) -> dict[float, CircleStudy]:
    study = laboratory.reidentified_circles
    return {speed * 1e3: study.only(speeds=[speed]) for speed in dict.fromkeys(key[2] for key in study.recordings)}


def _table(laboratory: Laboratory) -> list[PlainTable]:
    rows = []
    for speed, study in _by_speed(laboratory).items():
        mean = {law: _mean(study, law) for law in ("none", OLD, IDENTIFIED)}
        checks = lower_path_errors(study, IDENTIFIED, OLD)
        less = percent(mean_path_reduction(study, IDENTIFIED, OLD))
        rows.append(
            (
                f"{speed:g} mm/s",
                *(f"{mean[law]:.4f}" for law in mean),
                less,
                f"{sum(check.true for check in checks)} of {len(checks)}",
            )
        )
    return [
        PlainTable(
            headings=("", "none [mm]", "old [mm]", "identified [mm]", "identified against old", "circles with less"),
            rows=tuple(rows),
            note="Mean RMS path error of dynamic LuGre over 3 radii and 4 positions, workcell.",
        )
    ]


def _mean(study: CircleStudy, law: str) -> float:
    return float(np.mean([cell.rms_mm for cell in study.select(agent=law)]))


def _parameters(laboratory: Laboratory) -> list[PlainTable]:
    found = laboratory.all_joints.found
    names = [estimate.name.removeprefix("friction.").replace("_", " ") for estimate in found.joints[0].estimates]
    rows = tuple(
        (
            joint.joint,
            *(f"{each.prior:.3g} → {each.value:.3g}{'' if each.is_identified else ' *'}" for each in joint.estimates),
        )
        for joint in found.joints
    )
    note = "Old → identified, motor side, SI units. * not identified: the data do not tell it, and it keeps its value."
    return [PlainTable(headings=("joint", *names), rows=rows, note=note)]


def _figures(laboratory: Laboratory) -> Sequence[ReportFigure]:
    study = laboratory.reidentified_circles
    return [
        ReportFigure(
            name="reidentified",
            title="RMS motor position error per joint, with old and with identified parameters",
            thesis="",
            caption=motor_error_caption(study),
            figure=motor_error_figure(study),
        )
    ]


ITEMS = (
    Item(
        name="reidentified",
        chapter="beyond",
        title="dynamic LuGre with re-identified against old parameters on a workcell, which 6.1.3 leaves open",
        numbers=lambda laboratory: [*_table(laboratory), *_parameters(laboratory)],
        figures=_figures,
        claims=(
            Claim(
                name="reidentified-mean",
                statement="Parts of the results of Chapter 4 could be improved with the identified model (6.1.3).",
                criterion="Mean RMS path error of 12 circles at each speed. None was used: to identify friction, "
                "one joint moves at a time about home, at motor speeds up to 14 rad/s; on circles up to 8 rad/s.",
                checks=_mean_path,
                share=EVERY,
            ),
            Claim(
                name="reidentified-circles",
                statement="The identified model reduces the path error on most circles.",
                criterion="RMS path error, circle by circle.",
                checks=_path,
                share=MOST,
            ),
            Claim(
                name="reidentified-motors",
                statement="It reduces the motor error on most joints.",
                criterion="RMS motor error, joint by joint and motion by motion.",
                checks=_motors,
                share=MOST,
            ),
        ),
    ),
)
