"""Thesis 5.1 and 5.2.1, how B-spline networks are laid out and what they learn from: Figures 5.2, 5.3 and 5.5."""

import numpy as np

from ffgym.agents.splines.basis import FINE_RANGE, SplineBasis
from ffgym.core.types import Array
from ffgym.report import ReportFigure
from ffgym.report.learning.basis_plot import basis_figure
from ffgym.report.learning.feedback_plot import feedback_over_speed_figure, feedback_parts_figure
from ffgym.studies import CircleStudy
from scripts.thesis.claims import ZERO, Check, Claim
from scripts.thesis.items import Item
from scripts.thesis.laboratory import Laboratory

INPUT_RANGE = 20.0
"""Largest motor speed [rad/s] at 100 mm/s as thesis 5.1.1 reads it from Figure 5.2."""


def top_speeds(study: CircleStudy, position: str, speed: float) -> Array:
    """Largest motor speed of the reference [rad/s] of each joint at a position and TCP speed [m/s], shape (N,)."""
    recording = study.recordings["none", position, speed]
    return np.abs(recording.joint_array("reference.velocity")).max(axis=0)


def _speeds_of_the_basis(laboratory: Laboratory) -> list[Check]:
    speeds = top_speeds(laboratory.lugre_circles, "p1", 0.100)
    others = [
        Check(
            where=f"largest speed of joint {j + 1} against joint 3 [rad/s]",
            value=float(speeds[j]),
            limit=float(speeds[2]),
        )
        for j in range(len(speeds))
        if j != 2
    ]
    return [Check(where="largest speed of all joints [rad/s]", value=float(speeds.max()), limit=INPUT_RANGE), *others]


def _denser_inside(laboratory: Laboratory) -> list[Check]:
    knots = SplineBasis().knots
    fine = np.abs(knots[:-1] + np.diff(knots) / 2) < FINE_RANGE
    gaps = np.diff(knots)
    return [
        Check(
            where="widest gap between knots within ±1 rad/s against the narrowest outside [rad/s]",
            value=float(gaps[fine].max()),
            limit=float(gaps[~fine].min()),
        )
    ]


def _offset_removed(laboratory: Laboratory) -> list[Check]:
    recording = laboratory.lugre_circles.recordings["none", "p1", 0.010]
    moving = ~recording.mask(kind="standstill")
    feedback = recording.joint_array("feedback.effort")[moving, 1]
    without_integral = feedback - recording.joint_array("feedback.integral")[moving, 1]
    return [
        Check(
            where=f"mean of u_p against {ZERO:.0%} of that of u_c, joint 2, both without sign [N m]",
            value=float(abs(without_integral.mean())),
            limit=ZERO * float(abs(feedback.mean())),
        )
    ]


def _basis(laboratory: Laboratory) -> list[ReportFigure]:
    basis = SplineBasis()
    speeds = np.linspace(basis.knots[0], basis.knots[-1], 8001)
    values, splines = basis.active(speeds)
    curves = np.zeros((len(speeds), basis.n_splines))
    np.put_along_axis(curves, splines, values, axis=1)
    return [
        ReportFigure(
            name="figure-5.3",
            title="Basis functions of a network",
            thesis="",
            caption=f"{basis.n_splines} splines of order {basis.order} on {len(basis.knots)} knots; their sum is 1.",
            figure=basis_figure(speeds, curves, FINE_RANGE),
        )
    ]


def _feedback_over_speed(laboratory: Laboratory) -> list[ReportFigure]:
    recording = laboratory.lugre_circles.recordings["none", "p1", 0.100]
    speeds = ", ".join(f"{speed:.3g}" for speed in top_speeds(laboratory.lugre_circles, "p1", 0.100))
    return [
        ReportFigure(
            name="figure-5.2",
            title="Feedback over motor speed",
            thesis="",
            caption=f"No compensation, p1, 100 mm/s, without standstill. Largest speeds: {speeds} rad/s.",
            figure=feedback_over_speed_figure(recording),
        )
    ]


def _feedback_parts(laboratory: Laboratory) -> list[ReportFigure]:
    return [
        ReportFigure(
            name="figure-5.5",
            title="Feedback of joint 2 with and without its integral part",
            thesis="",
            caption="No compensation, p1, 10 mm/s. The integral part carries gravity, so that u_p has no offset.",
            figure=feedback_parts_figure(laboratory.lugre_circles.recordings["none", "p1", 0.010], joint=1),
        )
    ]


ITEMS = (
    Item(
        name="figure-5.2",
        chapter="chapter-5",
        title="feedback over speed at p1, 100 mm/s",
        figures=_feedback_over_speed,
        claims=(
            Claim(
                name="5.2-range",
                statement="The motors stay within ±20 rad/s, and joint 3 is the fastest.",
                criterion="Largest motor speed of the reference at p1, 100 mm/s; by construction, as a gear ratio and "
                "the work area were chosen for it.",
                checks=_speeds_of_the_basis,
            ),
        ),
    ),
    Item(
        name="figure-5.3",
        chapter="chapter-5",
        title="distribution of the B-splines",
        figures=_basis,
        claims=(
            Claim(
                name="5.3-density",
                statement="The splines are denser within ±1 rad/s, where friction bends.",
                criterion="Gaps between knots.",
                checks=_denser_inside,
            ),
        ),
    ),
    Item(
        name="figure-5.5",
        chapter="chapter-5",
        title="feedback of joint 2 with and without its integral part, p1, 10 mm/s",
        figures=_feedback_parts,
        claims=(
            Claim(
                name="5.5-offset",
                statement="Without its integral part the feedback has lost the offset that gravity gives it.",
                criterion="Mean over the motion without standstill.",
                checks=_offset_removed,
            ),
        ),
    ),
)
