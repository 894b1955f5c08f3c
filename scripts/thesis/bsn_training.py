"""Thesis 5.3.2, B-spline networks learning on the simulated robot: Figures 5.10 and 5.11."""

import numpy as np

from ffgym.agents.learning.progress import Learning
from ffgym.core.types import Array
from ffgym.report import law_styles
from ffgym.report.circles.friction_loops import unlike
from ffgym.studies import CircleStudy
from scripts.thesis.claims import ROUGH, ZERO, Check, Claim
from scripts.thesis.items import Item
from scripts.thesis.laboratory import Laboratory
from scripts.thesis.pictures import joint_friction, training_curves, trainings

STATIC, EXTENDED = NETWORKS = ("bsn_static", "bsn_extended")
DYNAMIC = "lugre_dynamic"
WRIST = (4, 5, 6)
"""Joints, from 1, that the thesis finds to learn less, or otherwise, than joints 1 to 3."""


def unlike_lugre(study: CircleStudy, law: str, speed: float) -> Array:
    """RMS difference of what a network and dynamic LuGre add at p1, over RMS of the latter, shape (N,)."""
    return unlike(study.recordings[law, "p1", speed], study.recordings[DYNAMIC, "p1", speed])


def near_lugre(study: CircleStudy, law: str, speed: float, joints: tuple[int, ...] = (1, 2, 3, 4, 5, 6)) -> list[Check]:
    """Whether what a network learned is roughly dynamic LuGre, joint by joint."""
    shares = unlike_lugre(study, law, speed)
    return [
        Check(
            where=f"{law_styles([law])[law].label}, joint {j}, RMS difference / RMS of dynamic LuGre",
            value=float(shares[j - 1]),
            limit=ROUGH,
        )
        for j in joints
    ]


def settles(learning: dict[str, Learning], names: tuple[str, ...] = NETWORKS) -> list[Check]:
    """Whether mean squares of error and signal hardly change in the last iteration, joint by joint."""
    return [
        Check(
            where=f"{training.title}, {what}, joint {j + 1}, change in the last iteration / first mean square",
            value=float(abs(left[-1, j] - left[-2, j])),
            limit=ZERO,
        )
        for training in trainings({name: learning[name] for name in names})
        for what, left in training.left.items()
        for j in range(left.shape[1])
    ]


def falls(learning: dict[str, Learning]) -> list[Check]:
    """Whether mean squares of error and signal are lower at the end than at first, joint by joint."""
    return [
        Check(
            where=f"{training.title}, {what}, joint {j + 1}, last / first mean square",
            value=float(left[-1, j]),
            limit=1.0,
        )
        for training in trainings(learning)
        for what, left in training.left.items()
        for j in range(left.shape[1])
    ]


def _extended_goes_on(laboratory: Laboratory) -> list[Check]:
    falling = {name: 1 - float(np.mean(each.error[-1] / each.error[-2])) for name, each in laboratory.learning.items()}
    return [
        Check(
            where="last fall of the mean square error / itself, mean of the joints, static against extended",
            value=falling[STATIC],
            limit=falling[EXTENDED],
        )
    ]


def _less_than_on_one_axis(laboratory: Laboratory) -> list[Check]:
    robot, axis = trainings(laboratory.learning), trainings(laboratory.axis_learning)
    return [
        Check(
            where=f"{one.title}, {what}, share of the mean square that is left, one axis against the robot",
            value=float(one.left[what][-1, 0]),
            limit=float(all_six.left[what][-1].mean()),
        )
        for one, all_six in zip(axis, robot, strict=True)
        for what in one.left
    ]


def _wrist_deviates(laboratory: Laboratory) -> list[Check]:
    static, extended = (unlike_lugre(laboratory.bsn_circles, law, 0.010) for law in NETWORKS)
    return [
        Check(
            where=f"joint {j}, RMS difference / RMS of dynamic LuGre, static against extended network",
            value=float(static[j - 1]),
            limit=float(extended[j - 1]),
        )
        for j in WRIST
    ]


ITEMS = (
    Item(
        name="figure-5.10",
        chapter="chapter-5",
        title="learning on the robot at p1, 10 mm/s, 10 iterations at rate 0.95",
        figures=lambda laboratory: training_curves("figure-5.10", laboratory.learning, laboratory.robot.joints),
        claims=(
            Claim(
                name="5.10-falls",
                statement="Error and learning signal decrease with both networks.",
                criterion="Mean square at the end below the first one, on every joint.",
                checks=lambda laboratory: falls(laboratory.learning),
            ),
            Claim(
                name="5.10-static",
                statement="Learning of the static network tends to convergence.",
                criterion=f"Mean squares change by less than {ZERO:.0%} of the first ones in the last iteration.",
                checks=lambda laboratory: settles(laboratory.learning, (STATIC,)),
            ),
            Claim(
                name="5.10-extended",
                statement="With the extended network the error tends to go on falling.",
                criterion="It falls by a larger share in the last iteration than with the static one.",
                checks=_extended_goes_on,
            ),
            Claim(
                name="5.10-axis",
                statement="The decrease is less significant than on one axis.",
                criterion="Share of the mean squares that is left, mean of the joints.",
                checks=_less_than_on_one_axis,
            ),
        ),
    ),
    Item(
        name="figure-5.11",
        chapter="chapter-5",
        title="what the networks learned at p1, 10 mm/s, beside dynamic LuGre",
        figures=lambda laboratory: joint_friction(
            "figure-5.11", laboratory.bsn_circles.only(positions=["p1"], speeds=[0.010]), DYNAMIC
        ),
        claims=(
            Claim(
                name="5.11-static",
                statement="The static network comes close to dynamic LuGre on every joint.",
                criterion=f"RMS difference less than {ROUGH:.0%} of the RMS of dynamic LuGre.",
                checks=lambda laboratory: near_lugre(laboratory.bsn_circles, STATIC, 0.010),
            ),
            Claim(
                name="5.11-extended",
                statement="The extended network resembles dynamic LuGre on joints 1 to 3.",
                criterion=f"RMS difference less than {ROUGH:.0%} of the RMS of dynamic LuGre.",
                checks=lambda laboratory: near_lugre(laboratory.bsn_circles, EXTENDED, 0.010, (1, 2, 3)),
            ),
            Claim(
                name="5.11-wrist",
                statement="On joints 4 to 6 the extended network deviates from it, the static one does not.",
                criterion="The extended network is further from dynamic LuGre than the static one.",
                checks=_wrist_deviates,
            ),
        ),
    ),
)
