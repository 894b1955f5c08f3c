"""Thesis 5.4.1, networks learned at 10 mm/s on the real robot: what stands for Figures 5.15 to 5.17, and Table 5.1."""

import numpy as np

from ffgym.report import circle_tables
from ffgym.studies import CircleStudy
from scripts.thesis.bsn_robot import EXTENDED, NETWORKS, STATIC, extended_better_but_on
from scripts.thesis.bsn_training import WRIST, unlike_lugre
from scripts.thesis.claims import CLEAR, MOST, Check, Claim
from scripts.thesis.comparisons import (
    clear_mean_gain,
    label,
    lower_path_errors,
)
from scripts.thesis.items import Item
from scripts.thesis.laboratory import Laboratory
from scripts.thesis.pictures import trainings
from scripts.thesis.published_sizes import sizes_as_published, table_claim

LAWS = ("none", *NETWORKS)


def slow(laboratory: Laboratory) -> CircleStudy:
    """The circles at 10 mm/s with the networks of 10 mm/s."""
    return laboratory.bsn_circles.only(laws=LAWS, speeds=[0.010])


def _wrist_learns_less(laboratory: Laboratory) -> list[Check]:
    wrist = [joint - 1 for joint in WRIST]
    return [
        Check(
            where=f"{training.title}, {what}, share of the mean square that is left, joints 1 to 3 against 4 to 6",
            value=float(np.delete(left[-1], wrist).mean()),
            limit=float(left[-1, wrist].mean()),
        )
        for training in trainings(laboratory.learning)
        for what, left in training.left.items()
    ]


def _wrist_unlike(laboratory: Laboratory) -> list[Check]:
    wrist = [joint - 1 for joint in WRIST]
    shares = {law: unlike_lugre(laboratory.bsn_circles, law, 0.010) for law in NETWORKS}
    return [
        Check(
            where=f"{label(law)}, RMS difference / RMS of dynamic LuGre, joints 1 to 3 against 4 to 6",
            value=float(np.delete(share, wrist).mean()),
            limit=float(share[wrist].mean()),
        )
        for law, share in shares.items()
    ]


def _p1(laboratory: Laboratory) -> CircleStudy:
    return laboratory.bsn_circles.only(laws=LAWS, positions=["p1"], speeds=[0.010])


ITEMS = (
    Item(
        name="figure-5.15",
        chapter="chapter-5",
        title="learning on the real robot at p1, 10 mm/s",
        counterpart="Figure 5.10 shows the simulated robot.",
        claims=(
            Claim(
                name="5.15-wrist",
                statement="Joints 4 to 6 improve less than joints 1 to 3.",
                criterion="Share of the mean squares that is left, mean of the joints, simulated.",
                checks=_wrist_learns_less,
            ),
        ),
    ),
    Item(
        name="figure-5.16",
        chapter="chapter-5",
        title="what the networks learned on the real robot at p1, 10 mm/s",
        counterpart="Figure 5.11 shows the simulated robot.",
        claims=(
            Claim(
                name="5.16-wrist",
                statement="Joints 4 to 6 differ most from dynamic LuGre, as in simulation.",
                criterion="RMS difference / RMS of dynamic LuGre, mean of the joints, simulated.",
                checks=_wrist_unlike,
            ),
            Claim(
                name="5.16-joint-3",
                statement="Joint 3 of the real robot behaves otherwise than in simulation at larger speeds.",
                criterion="Not comparable: the curves of the real robot were published as pictures only.",
                checks=lambda laboratory: (),
            ),
        ),
    ),
    Item(
        name="figure-5.17",
        chapter="chapter-5",
        title="networks of 10 mm/s on the real robot at p1, 10 mm/s",
        counterpart="Figure 5.12 shows the simulated robot.",
        claims=(
            Claim(
                name="5.17-joints",
                statement="The extended network is better than the static one on joints 1 to 3, and worse on the rest.",
                criterion="RMS motor error of every joint, simulated.",
                checks=lambda laboratory: extended_better_but_on(_p1(laboratory), WRIST),
            ),
        ),
    ),
    Item(
        name="table-5.1",
        chapter="chapter-5",
        title="path error with networks of 10 mm/s at 10 mm/s, simulated beside published",
        tables=lambda laboratory: circle_tables(slow(laboratory)),
        claims=(
            table_claim(
                "T5.1-clear",
                "Both networks reduce the path error significantly.",
                f"Mean RMS path error at least {CLEAR:.0%} lower than without",
                slow,
                lambda study: clear_mean_gain(study, NETWORKS),
            ),
            table_claim(
                "T5.1-extended",
                "The extended network is better than the static one in almost all instances.",
                "RMS path error of every circle",
                slow,
                lambda study: lower_path_errors(study, EXTENDED, STATIC),
                MOST,
            ),
            sizes_as_published("T5.1-sizes", slow, LAWS),
        ),
    ),
)
