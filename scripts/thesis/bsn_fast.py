"""Thesis 5.4.2, networks learned at 40 mm/s: Figures 5.18 to 5.20, simulated, and Table 5.2."""

import numpy as np

from ffgym.report import circle_tables
from ffgym.studies import CircleStudy
from scripts.thesis.bsn_basis import top_speeds
from scripts.thesis.bsn_real import LAWS, slow
from scripts.thesis.bsn_robot import EXTENDED, NETWORKS, STATIC, lower_motors, lower_paths
from scripts.thesis.bsn_training import DYNAMIC, WRIST, near_lugre, settles, unlike_lugre
from scripts.thesis.claims import CLEAR, MAJORITY, MOST, ROUGH, ZERO, Check, Claim
from scripts.thesis.comparisons import (
    label,
    less_gained_than,
    lower_motor_errors,
    lower_path_errors,
    mean_path_reduction,
)
from scripts.thesis.items import Item
from scripts.thesis.laboratory import Laboratory
from scripts.thesis.pictures import joint_friction, paths_and_errors, training_curves, trainings
from scripts.thesis.published_sizes import as_published, sizes_as_published, table_claim


def fast(laboratory: Laboratory) -> CircleStudy:
    """The circles at 40 mm/s with the networks of 40 mm/s."""
    return laboratory.fast_bsn_circles.only(laws=LAWS)


def fast_p1(laboratory: Laboratory) -> CircleStudy:
    """Those at p1."""
    return laboratory.fast_bsn_circles.only(laws=LAWS, positions=["p1"])


def _joints_learn_alike(laboratory: Laboratory) -> list[Check]:
    slow, fast = trainings(laboratory.learning), trainings(laboratory.fast_learning)
    return [
        Check(
            where=f"{after.title}, {what}, spread of the share left over the joints (max - min), 40 against 10 mm/s",
            value=float(np.ptp(after.left[what][-1])),
            limit=float(np.ptp(before.left[what][-1])),
        )
        for before, after in zip(slow, fast, strict=True)
        for what in after.left
    ]


def _larger_interval(laboratory: Laboratory) -> list[Check]:
    slow, fast = (top_speeds(laboratory.lugre_circles, "p1", speed) for speed in (0.010, 0.040))
    return [
        Check(where=f"largest motor speed of joint {j + 1}, 10 against 40 mm/s [rad/s]", value=float(a), limit=float(b))
        for j, (a, b) in enumerate(zip(slow, fast, strict=True))
    ]


def _wrist_nearer(laboratory: Laboratory) -> list[Check]:
    before = unlike_lugre(laboratory.bsn_circles, EXTENDED, 0.010)
    after = unlike_lugre(laboratory.fast_bsn_circles, EXTENDED, 0.040)
    return [
        Check(
            where=f"joint {j}, RMS difference / RMS of dynamic LuGre, 40 against 10 mm/s",
            value=float(after[j - 1]),
            limit=float(before[j - 1]),
        )
        for j in WRIST
    ]


def _not_inside(study: CircleStudy) -> list[Check]:
    return [
        Check(
            where=f"{label(law)}, r = 1 mm, share of the RMS path error that is gone",
            value=mean_path_reduction(study, law, radius_mm=1.0),
            limit=CLEAR,
        )
        for law in NETWORKS
    ]


def _lower_outside(study: CircleStudy) -> list[Check]:
    return [check for law in NETWORKS for check in lower_path_errors(study, law, "none", radii_mm=[3.0, 5.0])]


ITEMS = (
    Item(
        name="figure-5.18",
        chapter="chapter-5",
        title="learning at p1, 40 mm/s, 10 iterations at rate 0.95",
        counterpart="The thesis shows the real robot; here the simulated one learns.",
        figures=lambda laboratory: training_curves("figure-5.18", laboratory.fast_learning, laboratory.robot.joints),
        claims=(
            Claim(
                name="5.18-alike",
                statement="The joints learn more alike than at 10 mm/s.",
                criterion="Spread over the joints of the share of the mean squares that is left.",
                checks=_joints_learn_alike,
            ),
            Claim(
                name="5.18-settles",
                statement="Learning almost converges, on all joints and with both networks.",
                criterion=f"Mean squares change by less than {ZERO:.0%} of the first ones in the last iteration.",
                checks=lambda laboratory: settles(laboratory.fast_learning),
            ),
        ),
    ),
    Item(
        name="figure-5.19",
        chapter="chapter-5",
        title="what the networks learned at p1, 40 mm/s, beside dynamic LuGre",
        counterpart="The thesis shows the real robot; here the simulated one has learned.",
        figures=lambda laboratory: joint_friction(
            "figure-5.19", laboratory.fast_bsn_circles.only(positions=["p1"]), DYNAMIC
        ),
        claims=(
            Claim(
                name="5.19-range",
                statement="What is learned covers a larger interval of speeds than at 10 mm/s.",
                criterion="Largest motor speed of the training motion.",
                checks=_larger_interval,
            ),
            Claim(
                name="5.19-near",
                statement="The extended network matches dynamic LuGre on almost all joints.",
                criterion=f"RMS difference less than {ROUGH:.0%} of the RMS of dynamic LuGre.",
                checks=lambda laboratory: near_lugre(laboratory.fast_bsn_circles, EXTENDED, 0.040),
                share=MOST,
            ),
            Claim(
                name="5.19-wrist",
                statement="On joints 4 to 6 it does so better than after learning at 10 mm/s.",
                criterion="RMS difference / RMS of dynamic LuGre.",
                checks=_wrist_nearer,
            ),
        ),
    ),
    Item(
        name="figure-5.20",
        chapter="chapter-5",
        title="networks of 40 mm/s on the circles at p1, 40 mm/s",
        counterpart="The thesis shows the real robot; here the simulated one moves.",
        figures=lambda laboratory: paths_and_errors("figure-5.20", fast_p1(laboratory)),
        claims=(
            Claim(
                name="5.20-inner",
                statement="The smallest circle does not get better.",
                criterion=f"Less than {CLEAR:.0%} of its RMS path error is gone.",
                checks=lambda laboratory: _not_inside(fast_p1(laboratory)),
            ),
            Claim(
                name="5.20-others",
                statement="The other circles get somewhat better.",
                criterion="RMS path error lower than without at r = 3 and 5 mm.",
                checks=lambda laboratory: _lower_outside(fast_p1(laboratory)),
            ),
            Claim(
                name="5.20-motors",
                statement="The motor errors are much smaller with both networks, on all joints.",
                criterion=f"RMS motor error of every joint at least {CLEAR:.0%} lower than without.",
                checks=lambda laboratory: lower_motors(fast_p1(laboratory), by=CLEAR),
            ),
            Claim(
                name="5.20-extended",
                statement="The extended network is slightly better on a majority of the joints.",
                criterion="RMS motor error of every joint, against the static network.",
                checks=lambda laboratory: lower_motor_errors(fast_p1(laboratory), EXTENDED, STATIC),
                share=MAJORITY,
            ),
        ),
    ),
    Item(
        name="table-5.2",
        chapter="chapter-5",
        title="path error with networks of 40 mm/s at 40 mm/s, simulated beside published",
        tables=lambda laboratory: circle_tables(fast(laboratory)),
        claims=(
            table_claim(
                "T5.2-better",
                "In general compensation is better than none.",
                "RMS path error of every circle",
                fast,
                lower_paths,
                MOST,
            ),
            table_claim(
                "T5.2-worse",
                "Only on a few of the smallest circles it is worse.",
                "RMS path error lower than without on every circle of 3 and 5 mm",
                fast,
                _lower_outside,
            ),
            Claim(
                name="T5.2-less",
                statement="The gain is smaller than at 10 mm/s.",
                criterion="Share of the mean RMS path error that is gone, simulated.",
                checks=lambda laboratory: less_gained_than(fast(laboratory), slow(laboratory), NETWORKS),
                published=lambda laboratory: less_gained_than(
                    as_published(fast(laboratory)), as_published(slow(laboratory)), NETWORKS
                ),
            ),
            table_claim(
                "T5.2-extended",
                "The extended network is better than the static one in most cases, if only slightly.",
                "RMS path error of every circle",
                fast,
                lambda study: lower_path_errors(study, EXTENDED, STATIC),
                MOST,
            ),
            sizes_as_published("T5.2-sizes", fast, LAWS),
        ),
    ),
)
