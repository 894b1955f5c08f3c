"""Thesis 5.3.2, B-spline networks on the simulated robot after learning at p1 at 10 mm/s: Figures 5.12 to 5.14."""

from ffgym.studies import CircleStudy
from scripts.thesis.claims import CLEAR, SIMILAR, Check, Claim
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

STATIC, EXTENDED = NETWORKS = ("bsn_static", "bsn_extended")


def at(laboratory: Laboratory, position: str, speed: float) -> CircleStudy:
    """The circles at one position and speed [m/s], without compensation and with the networks of 10 mm/s."""
    return laboratory.bsn_circles.only(laws=["none", *NETWORKS], positions=[position], speeds=[speed])


def lower_motors(study: CircleStudy, by: float = 0.0) -> list[Check]:
    """Whether both networks lower the RMS motor error of every joint, by a share of it."""
    return [check for law in NETWORKS for check in lower_motor_errors(study, law, "none", by=by)]


def lower_paths(study: CircleStudy) -> list[Check]:
    """Whether both networks lower the RMS path error of every circle."""
    return [check for law in NETWORKS for check in lower_path_errors(study, law, "none")]


def extended_better_but_on(study: CircleStudy, exceptions: tuple[int, ...]) -> list[Check]:
    """Whether the extended network has the lower motor errors, and the static one on the joints of `exceptions`."""
    others = [joint for joint in range(1, study.robot.n_joints + 1) if joint not in exceptions]
    return [
        *lower_motor_errors(study, EXTENDED, STATIC, joints=others),
        *lower_motor_errors(study, STATIC, EXTENDED, joints=exceptions),
    ]


def _less_at_speed(laboratory: Laboratory) -> list[Check]:
    slow, fast = (at(laboratory, "p1", speed) for speed in (0.010, 0.040))
    return [
        Check(
            where=f"{label(law)}, share of the RMS motor error that is gone, 40 against 10 mm/s",
            value=mean_motor_reduction(fast, law),
            limit=mean_motor_reduction(slow, law),
        )
        for law in NETWORKS
    ]


def _alike(study: CircleStudy) -> list[Check]:
    apart = abs(mean_motor_reduction(study, STATIC) - mean_motor_reduction(study, EXTENDED))
    return [
        Check(
            where="static and extended network apart, share of the RMS motor error that is gone",
            value=apart,
            limit=SIMILAR,
        )
    ]


def _little_inside(study: CircleStudy) -> list[Check]:
    return [
        Check(
            where=f"{label(law)}, r = {radius:g} mm, share of the RMS path error that is gone",
            value=mean_path_reduction(study, law, radius_mm=radius),
            limit=CLEAR,
        )
        for law in NETWORKS
        for radius in (1.0, 3.0)
    ]


def _as_at_p1(laboratory: Laboratory) -> list[Check]:
    first, third = (at(laboratory, position, 0.010) for position in ("p1", "p3"))
    return [
        Check(
            where=f"{label(law)}, share of the RMS motor error that is gone, p1 minus p3 without sign",
            value=abs(mean_motor_reduction(first, law) - mean_motor_reduction(third, law)),
            limit=SIMILAR,
        )
        for law in NETWORKS
    ]


def _better_than_at_p1(laboratory: Laboratory) -> list[Check]:
    first, third = (at(laboratory, position, 0.010) for position in ("p1", "p3"))
    gains = [
        Check(
            where=f"{label(law)}, share of the RMS motor error that is gone, p1 against p3",
            value=mean_motor_reduction(first, law),
            limit=mean_motor_reduction(third, law),
        )
        for law in NETWORKS
    ]
    sizes = [
        Check(
            where=f"{label(law)}, r = {there.radius_mm:g} mm, p3 against p1 [mm]", value=there.rms_mm, limit=here.rms_mm
        )
        for law in NETWORKS
        for here, there in zip(first.select(agent=law), third.select(agent=law), strict=True)
    ]
    return gains + sizes


def _item(name: str, position: str, speed: float, *claims: Claim) -> Item:
    return Item(
        name=name,
        chapter="chapter-5",
        title=f"networks of 10 mm/s on the circles at {position}, {speed * 1e3:g} mm/s",
        figures=lambda laboratory: paths_and_errors(name, at(laboratory, position, speed)),
        claims=claims,
    )


ITEMS = (
    _item(
        "figure-5.12",
        "p1",
        0.010,
        Claim(
            name="5.12-motors",
            statement="Both networks lower the motor errors.",
            criterion="RMS motor error of every joint, against none.",
            checks=lambda laboratory: lower_motors(at(laboratory, "p1", 0.010)),
        ),
        Claim(
            name="5.12-joints",
            statement="The extended network is better than the static one on every joint but joint 4.",
            criterion="RMS motor error; on joint 4 the static network must be the better one.",
            checks=lambda laboratory: extended_better_but_on(at(laboratory, "p1", 0.010), (4,)),
        ),
        Claim(
            name="5.12-path",
            statement="The tool strays less from the path with both networks.",
            criterion="RMS path error lower than without, on every circle.",
            checks=lambda laboratory: lower_paths(at(laboratory, "p1", 0.010)),
        ),
    ),
    _item(
        "figure-5.13",
        "p1",
        0.040,
        Claim(
            name="5.13-less",
            statement="At 40 mm/s the networks of 10 mm/s lower the motor errors by less.",
            criterion="Share of the RMS motor error that is gone, mean of the joints.",
            checks=_less_at_speed,
        ),
        Claim(
            name="5.13-alike",
            statement="Static and extended network perform very much alike.",
            criterion=f"Shares of the RMS motor error that are gone differ by less than {SIMILAR:g}.",
            checks=lambda laboratory: _alike(at(laboratory, "p1", 0.040)),
        ),
        Claim(
            name="5.13-path",
            statement="Neither makes the smaller circles significantly more accurate.",
            criterion=f"Less than {CLEAR:.0%} of the RMS path error is gone at r = 1 and 3 mm.",
            checks=lambda laboratory: _little_inside(at(laboratory, "p1", 0.040)),
        ),
    ),
    _item(
        "figure-5.14",
        "p3",
        0.010,
        Claim(
            name="5.14-alike",
            statement="At p3 the networks of p1 do about as much as at p1.",
            criterion=f"Shares of the RMS motor error that are gone differ by less than {SIMILAR:g}.",
            checks=_as_at_p1,
        ),
        Claim(
            name="5.14-better",
            statement="At p3 the gain is larger and the path deviations are smaller than where they were trained.",
            criterion="Share of the RMS motor error that is gone, and RMS path error of every circle.",
            checks=_better_than_at_p1,
        ),
    ),
)
