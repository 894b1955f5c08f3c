"""Thesis 4.3.2, LuGre feed-forward on the simulated robot: Figures 4.6 to 4.9."""

from collections.abc import Sequence

from ffgym.studies import CircleStudy
from scripts.thesis.claims import CLEAR, MOST, SIMILAR, Check, Claim
from scripts.thesis.comparisons import (
    label,
    lower_motor_errors,
    lower_path_errors,
    mean_motor_reduction,
    mean_path_reduction,
)
from scripts.thesis.items import Item
from scripts.thesis.laboratory import Laboratory
from scripts.thesis.pictures import paths_and_errors

STATIC, DYNAMIC = LAWS = ("lugre_static", "lugre_dynamic")


def at(laboratory: Laboratory, position: str, speed: float) -> CircleStudy:
    """The circles at one position and speed [m/s]."""
    return laboratory.lugre_circles.only(positions=[position], speeds=[speed])


def larger_circles_are_better(study: CircleStudy, laws: Sequence[str]) -> list[Check]:
    """Whether the RMS path error is smaller on the larger of two circles, for every pair and law."""
    return [
        Check(
            where=f"{label(law)}, {large.position}, r = {large.radius_mm:g} against {small.radius_mm:g} mm [mm]",
            value=large.rms_mm,
            limit=small.rms_mm,
        )
        for law in laws
        for large in study.select(agent=law)
        for small in study.select(agent=law, position=large.position, speed_mm_s=large.speed_mm_s)
        if small.radius_mm < large.radius_mm
    ]


def _rounder(study: CircleStudy) -> list[Check]:
    return [check for law in LAWS for check in lower_path_errors(study, law, "none")]


def _lower_errors(study: CircleStudy, by: float = 0.0) -> list[Check]:
    return [check for law in LAWS for check in lower_motor_errors(study, law, "none", by=by)]


def _dynamic_better_but_on_joint_3(study: CircleStudy) -> list[Check]:
    others = [joint for joint in range(1, study.robot.n_joints + 1) if joint != 3]
    return [
        *lower_motor_errors(study, DYNAMIC, STATIC, joints=others),
        *lower_motor_errors(study, STATIC, DYNAMIC, joints=[3]),
    ]


def _as_at_p1(laboratory: Laboratory) -> list[Check]:
    first, third = (at(laboratory, position, 0.010) for position in ("p1", "p3"))
    return [
        Check(
            where=f"{label(law)}, share of the {what} that is gone, p1 minus p3",
            value=abs(reduction(first, law) - reduction(third, law)),
            limit=SIMILAR,
        )
        for what, reduction in (("RMS path error", mean_path_reduction), ("RMS motor error", mean_motor_reduction))
        for law in LAWS
    ]


def trouble_inside(study: CircleStudy) -> list[Check]:
    """Whether less of the RMS path error is gone on the smallest circle than on the others, with every law."""
    return [
        Check(
            where=f"{label(law)}, share of the RMS path error that is gone, r = 1 mm against {radius:g} mm",
            value=mean_path_reduction(study, law, radius_mm=1.0),
            limit=mean_path_reduction(study, law, radius_mm=radius),
        )
        for law in LAWS
        for radius in (3.0, 5.0)
    ]


def _trouble_everywhere(laboratory: Laboratory) -> list[Check]:
    slow, fast = (at(laboratory, "p1", speed) for speed in (0.010, 0.100))
    before = {cell.radius_mm: cell.rms_mm for cell in slow.select(agent="none")}
    return [
        Check(
            where=f"r = {cell.radius_mm:g} mm, 10 mm/s without against 100 mm/s with {label(law)} [mm]",
            value=before[cell.radius_mm],
            limit=cell.rms_mm,
        )
        for law in LAWS
        for cell in fast.select(agent=law)
    ]


def _item(name: str, position: str, speed: float, *claims: Claim) -> Item:
    return Item(
        name=name,
        chapter="chapter-4",
        title=f"LuGre on the circles at {position}, {speed * 1e3:g} mm/s",
        figures=lambda laboratory: paths_and_errors(name, at(laboratory, position, speed)),
        claims=claims,
    )


ITEMS = (
    _item(
        "figure-4.6",
        "p1",
        0.010,
        Claim(
            name="4.6-round",
            statement="Both laws make the circles rounder.",
            criterion="RMS path error lower than without, on every circle.",
            checks=lambda laboratory: _rounder(at(laboratory, "p1", 0.010)),
        ),
        Claim(
            name="4.6-radius",
            statement="Errors are generally smaller on larger circles.",
            criterion="RMS path error of pairs of circles, with every law.",
            checks=lambda laboratory: larger_circles_are_better(at(laboratory, "p1", 0.010), ("none", *LAWS)),
            share=MOST,
        ),
        Claim(
            name="4.6-smallest",
            statement="On the smallest circle the motion is smoother with the dynamic law than with the static one.",
            criterion="RMS path error at r = 1 mm; the thesis goes by sight.",
            checks=lambda laboratory: lower_path_errors(at(laboratory, "p1", 0.010), DYNAMIC, STATIC, radii_mm=[1.0]),
        ),
        Claim(
            name="4.6-motors",
            statement="The motor errors are smaller with both laws.",
            criterion="RMS motor error of every joint, standstill excluded.",
            checks=lambda laboratory: _lower_errors(at(laboratory, "p1", 0.010)),
        ),
        Claim(
            name="4.6-joints",
            statement="The dynamic law is better than the static one on every joint but joint 3.",
            criterion="RMS motor error; on joint 3 the static law must be the better one.",
            checks=lambda laboratory: _dynamic_better_but_on_joint_3(at(laboratory, "p1", 0.010)),
        ),
    ),
    _item(
        "figure-4.7",
        "p3",
        0.010,
        Claim(
            name="4.7-round",
            statement="As at p1, the circles are rounder and the motor errors smaller with both laws.",
            criterion="RMS path error of every circle and RMS motor error of every joint, against none.",
            checks=lambda laboratory: (
                _rounder(at(laboratory, "p3", 0.010)) + _lower_errors(at(laboratory, "p3", 0.010))
            ),
        ),
        Claim(
            name="4.7-joint-3",
            statement="The dynamic law is worse than the static one on joint 3.",
            criterion="RMS motor error of joint 3.",
            checks=lambda laboratory: lower_motor_errors(at(laboratory, "p3", 0.010), STATIC, DYNAMIC, joints=[3]),
        ),
        Claim(
            name="4.7-alike",
            statement="The laws do as much at p3 as at p1.",
            criterion=f"Shares of mean RMS errors that are gone differ by less than {SIMILAR:g}.",
            checks=_as_at_p1,
        ),
    ),
    _item(
        "figure-4.8",
        "p1",
        0.040,
        Claim(
            name="4.8-inner",
            statement="Both laws have problems with the inner circle.",
            criterion="A smaller share of its RMS path error is gone than of that of the other circles.",
            checks=lambda laboratory: trouble_inside(at(laboratory, "p1", 0.040)),
        ),
        Claim(
            name="4.8-others",
            statement="The path error still improves on the other circles.",
            criterion="RMS path error lower than without at r = 3 and 5 mm.",
            checks=lambda laboratory: [
                check
                for law in LAWS
                for check in lower_path_errors(at(laboratory, "p1", 0.040), law, "none", radii_mm=[3.0, 5.0])
            ],
        ),
        Claim(
            name="4.8-motors",
            statement="The motor errors are significantly smaller.",
            criterion=f"RMS motor error of every joint at least {CLEAR:.0%} lower than without.",
            checks=lambda laboratory: _lower_errors(at(laboratory, "p1", 0.040), by=CLEAR),
        ),
    ),
    _item(
        "figure-4.9",
        "p1",
        0.100,
        Claim(
            name="4.9-trouble",
            statement="With every law the tool has trouble following any of the circles.",
            criterion="RMS path error larger than without compensation at 10 mm/s.",
            checks=_trouble_everywhere,
        ),
        Claim(
            name="4.9-path",
            statement="The path error still decreases somewhat.",
            criterion="RMS path error lower than without, on every circle.",
            checks=lambda laboratory: _rounder(at(laboratory, "p1", 0.100)),
        ),
        Claim(
            name="4.9-motors",
            statement="The motor errors are smaller.",
            criterion="RMS motor error of every joint, against none.",
            checks=lambda laboratory: _lower_errors(at(laboratory, "p1", 0.100)),
        ),
    ),
)
