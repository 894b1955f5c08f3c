"""Thesis 4.4, LuGre feed-forward on the real robot: Tables 4.1 and 4.2, and what stands for Figures 4.10 to 4.12."""

from ffgym.report import circle_tables
from ffgym.studies import CircleStudy
from scripts.thesis.claims import CLEAR, Check, Claim
from scripts.thesis.comparisons import (
    clear_mean_gain,
    label,
    less_gained_than,
    lower_motor_errors,
    lower_path_errors,
    mean_motor_reduction,
    mean_path_reduction,
)
from scripts.thesis.items import Item
from scripts.thesis.laboratory import Laboratory
from scripts.thesis.lugre_robot import DYNAMIC, LAWS, STATIC, at
from scripts.thesis.published_sizes import more_gained_than_published, sizes_as_published, table_claim


def _circles(laboratory: Laboratory, speed: float) -> CircleStudy:
    return laboratory.lugre_circles.only(speeds=[speed])


def _slow(laboratory: Laboratory) -> CircleStudy:
    return _circles(laboratory, 0.010)


def _slow_and_fast(laboratory: Laboratory) -> CircleStudy:
    return laboratory.lugre_circles.only(speeds=[0.010, 0.040])


def _dynamic_better(study: CircleStudy) -> list[Check]:
    checks = lower_path_errors(study, DYNAMIC, STATIC)
    return [check for check in checks if "p3, r = 5 mm" not in check.where]


def _nearer_together(study: CircleStudy) -> list[Check]:
    apart = [
        abs(mean_path_reduction(part, DYNAMIC) - mean_path_reduction(part, STATIC))
        for part in (study.only(speeds=[0.040]), study.only(speeds=[0.010]))
    ]
    return [
        Check(
            where="static and dynamic LuGre apart, share of the mean RMS path error, 40 against 10 mm/s",
            value=apart[0],
            limit=apart[1],
        )
    ]


def _limited_inside(study: CircleStudy) -> list[Check]:
    """Whether little of the error is gone on the smallest circle, and a clear share on the others."""
    gone = {
        (law, radius): mean_path_reduction(study, law, radius_mm=radius) for law in LAWS for radius in (1.0, 3.0, 5.0)
    }
    return [
        Check(where=f"{label(law)}, r = 1 mm, share of the RMS path error that is gone", value=share, limit=CLEAR)
        if radius == 1.0
        else Check(
            where=f"{label(law)}, r = {radius:g} mm, share of the RMS path error that is left",
            value=1 - share,
            limit=1 - CLEAR,
        )
        for (law, radius), share in gone.items()
    ]


def _static_better_but_on_joint_2(study: CircleStudy) -> list[Check]:
    others = [joint for joint in range(1, study.robot.n_joints + 1) if joint != 2]
    return [
        *lower_motor_errors(study, STATIC, DYNAMIC, joints=others),
        *lower_motor_errors(study, DYNAMIC, STATIC, joints=[2]),
    ]


def _static_better_in_the_mean(study: CircleStudy) -> list[Check]:
    return [
        Check(
            where="dynamic against static LuGre, share of the RMS motor error that is gone",
            value=mean_motor_reduction(study, DYNAMIC),
            limit=mean_motor_reduction(study, STATIC),
        )
    ]


def _little_gained(study: CircleStudy) -> list[Check]:
    return [
        Check(
            where=f"{label(law)}, share of the mean RMS {what} error that is gone",
            value=reduction(study, law),
            limit=CLEAR,
        )
        for what, reduction in (("path", mean_path_reduction), ("motor", mean_motor_reduction))
        for law in LAWS
    ]


ITEMS = (
    Item(
        name="figure-4.10",
        chapter="chapter-4",
        title="LuGre on the real robot at p1, 10 mm/s",
        counterpart="Figure 4.6 shows the simulated robot.",
        claims=(
            Claim(
                name="4.10-joints",
                statement="On the real robot the dynamic law is better than the static one on joint 2 only.",
                criterion="RMS motor error of every joint, simulated.",
                checks=lambda laboratory: _static_better_but_on_joint_2(at(laboratory, "p1", 0.010)),
            ),
            Claim(
                name="4.10-practice",
                statement="Compensation removes less of the path error in practice than in simulation.",
                criterion="Share of the mean RMS path error at 10 mm/s that is gone (Table 4.1).",
                checks=lambda laboratory: more_gained_than_published(_circles(laboratory, 0.010), LAWS),
            ),
        ),
    ),
    Item(
        name="figure-4.11",
        chapter="chapter-4",
        title="LuGre on the real robot at p1, 40 mm/s",
        counterpart="Figure 4.8 shows the simulated robot.",
        claims=(
            Claim(
                name="4.11-inner",
                statement="The gain is limited on the smallest circle and noteworthy on the others.",
                criterion=f"Less than {CLEAR:.0%} of the RMS path error is gone inside, more on the others, simulated.",
                checks=lambda laboratory: _limited_inside(at(laboratory, "p1", 0.040)),
            ),
            Claim(
                name="4.11-motors",
                statement="The dynamic law lowers the motor errors by less than the static one.",
                criterion="Share of the RMS motor error that is gone, mean over the joints, simulated.",
                checks=lambda laboratory: _static_better_in_the_mean(at(laboratory, "p1", 0.040)),
            ),
        ),
    ),
    Item(
        name="figure-4.12",
        chapter="chapter-4",
        title="LuGre on the real robot at p1, 100 mm/s",
        counterpart="Figure 4.9 shows the simulated robot.",
        claims=(
            Claim(
                name="4.12-limited",
                statement="The gain is very limited in path error and in motor error.",
                criterion=f"Less than {CLEAR:.0%} of the mean RMS error is gone, simulated.",
                checks=lambda laboratory: _little_gained(at(laboratory, "p1", 0.100)),
            ),
        ),
    ),
    Item(
        name="table-4.1",
        chapter="chapter-4",
        title="path error with LuGre at 10 mm/s, simulated beside published",
        tables=lambda laboratory: circle_tables(_slow(laboratory)),
        claims=(
            table_claim(
                "T4.1-clear",
                "Both laws do significantly better than no compensation.",
                f"Mean RMS path error at least {CLEAR:.0%} lower than without",
                _slow,
                lambda study: clear_mean_gain(study, LAWS),
            ),
            table_claim(
                "T4.1-dynamic",
                "The dynamic law is better than the static one on all circles but that of 5 mm at p3.",
                "RMS path error of the other 11 circles",
                _slow,
                _dynamic_better,
            ),
            sizes_as_published("T4.1-sizes", _slow, ("none", *LAWS)),
        ),
    ),
    Item(
        name="table-4.2",
        chapter="chapter-4",
        title="path error with LuGre at 40 mm/s, simulated beside published",
        tables=lambda laboratory: circle_tables(_circles(laboratory, 0.040)),
        claims=(
            table_claim(
                "T4.2-less",
                "The gain is smaller than at 10 mm/s.",
                "Share of the mean RMS path error that is gone",
                _slow_and_fast,
                lambda study: less_gained_than(study.only(speeds=[0.040]), study.only(speeds=[0.010]), LAWS),
            ),
            table_claim(
                "T4.2-nearer",
                "Static and dynamic law are nearer to one another than at 10 mm/s.",
                "Shares of the mean RMS path error that are gone",
                _slow_and_fast,
                _nearer_together,
            ),
            sizes_as_published("T4.2-sizes", lambda laboratory: _circles(laboratory, 0.040), ("none", *LAWS)),
        ),
    ),
)
