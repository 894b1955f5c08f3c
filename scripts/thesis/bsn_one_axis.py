"""Thesis 5.3.1, B-spline networks learned on one axis that follows a sine: Figures 5.6 to 5.9."""

import numpy as np

from ffgym.recordings import Recording
from scripts.thesis.axis_measures import BEND, axis_miss, feedback_rms, settled, static_law_averages
from scripts.thesis.claims import CLEAR, ZERO, Check, Claim
from scripts.thesis.comparisons import label, less_left_than, lower_sine_errors
from scripts.thesis.items import Item
from scripts.thesis.laboratory import Laboratory
from scripts.thesis.pictures import axis_friction, axis_outputs, training_curves, trainings

STATIC, EXTENDED = NETWORKS = ("bsn_static", "bsn_extended")
QUICK = 5
"""Iterations that count as quick: a third of the 15 of thesis 5.3.1; chosen."""
REST = 0.1
"""Share of the whole fall that may be left after them; chosen."""


def _quickly(laboratory: Laboratory) -> list[Check]:
    return [
        Check(
            where=f"{training.title}, {what}, share left after {QUICK} iterations against {REST:.0%} of the fall",
            value=float(left[QUICK, 0] - left[-1, 0]),
            limit=REST * float(1 - left[-1, 0]),
        )
        for training in trainings(laboratory.axis_learning)
        for what, left in training.left.items()
    ]


def _almost_to_zero(laboratory: Laboratory) -> list[Check]:
    return [
        Check(
            where=f"{training.title}, {what}, share of the mean square that is left",
            value=float(left[-1, 0]),
            limit=ZERO,
        )
        for training in trainings(laboratory.axis_learning)
        for what, left in training.left.items()
    ]


def _miss_outside(laboratory: Laboratory) -> list[Check]:
    recording = laboratory.bsn_sines.recordings[STATIC, 1.0]
    fast = np.abs(recording.joint_array("reference.velocity")[:, 0]) > BEND
    return [
        Check(
            where=f"RMS difference / RMS friction, above {BEND:g} rad/s", value=axis_miss(recording, fast), limit=ZERO
        )
    ]


def _follows(laboratory: Laboratory) -> list[Check]:
    static, extended = (axis_miss(laboratory.bsn_sines.recordings[law, 1.0]) for law in NETWORKS)
    return [
        Check(where="extended against static network, RMS difference / RMS friction", value=extended, limit=static),
        Check(where="extended network, RMS difference / RMS friction", value=extended, limit=ZERO),
    ]


def _lower(laboratory: Laboratory, frequency: float, by: float) -> list[Check]:
    return [lower_sine_errors(laboratory.bsn_sines, law, "none", frequency, by=by) for law in NETWORKS]


def _feedback_almost_zero(laboratory: Laboratory) -> list[Check]:
    recordings = laboratory.bsn_sines.recordings
    limit = ZERO * feedback_rms(recordings["none", 1.0])
    return [
        Check(where=f"{label(law)}, RMS feedback [N m]", value=feedback_rms(recordings[law, 1.0]), limit=limit)
        for law in NETWORKS
    ]


def _feedback_at_reversal(recording: Recording) -> float:
    """RMS feedback [N m] while the speed goes from negative to positive."""
    speed = recording.joint_array("reference.velocity")[:, 0]
    rows = settled(recording) & (np.abs(speed) < BEND) & (np.gradient(speed) > 0)
    return float(np.sqrt(np.mean(recording.joint_array("feedback.effort")[rows, 0] ** 2)))


def _calmer_reversal(laboratory: Laboratory) -> list[Check]:
    static, extended = (_feedback_at_reversal(laboratory.bsn_sines.recordings[law, 1.0]) for law in NETWORKS)
    return [
        Check(where="RMS feedback below 1 rad/s, extended against static network [N m]", value=extended, limit=static)
    ]


def _feedback_remains(laboratory: Laboratory) -> list[Check]:
    recordings = laboratory.bsn_sines.recordings
    limit = ZERO * feedback_rms(recordings["none", 3.0])
    return [
        Check(
            where=f"{ZERO:.0%} of the RMS feedback without, against that with {label(law)} [N m]",
            value=limit,
            limit=feedback_rms(recordings[law, 3.0]),
        )
        for law in NETWORKS
    ]


ITEMS = (
    Item(
        name="figure-5.6",
        chapter="chapter-5",
        title="learning on one axis, 1 Hz, 15 iterations at rate 0.8",
        figures=lambda laboratory: training_curves("figure-5.6", laboratory.axis_learning, laboratory.axis.joints),
        claims=(
            Claim(
                name="5.6-quickly",
                statement="Learning converges quickly.",
                criterion=f"After {QUICK} iterations less than {REST:.0%} of the whole fall of the mean squares is "
                "still to come.",
                checks=_quickly,
            ),
            Claim(
                name="5.6-zero",
                statement="Error and learning signal converge to almost zero.",
                criterion=f"Less than {ZERO:.0%} of their mean squares is left.",
                checks=_almost_to_zero,
            ),
        ),
    ),
    Item(
        name="figure-5.7",
        chapter="chapter-5",
        title="friction and learned feed-forward of one axis, 1 Hz",
        figures=lambda laboratory: axis_friction("figure-5.7", laboratory.bsn_sines.only(frequencies=[1.0])),
        claims=(
            Claim(
                name="5.7-outside",
                statement=f"Beyond {BEND:g} rad/s the static network is an accurate approximation of the friction.",
                criterion=f"RMS difference at most {ZERO:.0%} of the RMS friction there.",
                checks=_miss_outside,
            ),
            Claim(
                name="5.7-inside",
                statement="Within, it averages over the branches of the dynamic friction.",
                criterion="It is nearer to the mean of the branches than they are.",
                checks=lambda laboratory: static_law_averages(laboratory.bsn_sines.recordings[STATIC, 1.0]),
            ),
            Claim(
                name="5.7-extended",
                statement="The extended network follows the friction.",
                criterion=f"It misses less than the static one, and at most {ZERO:.0%} of the RMS friction.",
                checks=_follows,
            ),
        ),
    ),
    Item(
        name="figure-5.8",
        chapter="chapter-5",
        title="one axis before and after learning, 1 Hz",
        figures=lambda laboratory: axis_outputs("figure-5.8", laboratory.bsn_sines.only(frequencies=[1.0])),
        claims=(
            Claim(
                name="5.8-both",
                statement="Both networks reduce the motor error significantly.",
                criterion=f"RMS error at least {CLEAR:.0%} lower than without.",
                checks=lambda laboratory: _lower(laboratory, 1.0, CLEAR),
            ),
            Claim(
                name="5.8-feedback",
                statement="After learning the feedback is almost zero.",
                criterion=f"At most {ZERO:.0%} of its RMS without compensation is left.",
                checks=_feedback_almost_zero,
            ),
            Claim(
                name="5.8-reversal",
                statement="Where the speed becomes positive, feedback swings less with the extended network than with "
                "the static one.",
                criterion=f"RMS feedback below {BEND:g} rad/s while the speed rises.",
                checks=_calmer_reversal,
            ),
        ),
    ),
    Item(
        name="figure-5.9",
        chapter="chapter-5",
        title="one axis with the networks of 1 Hz, 3 Hz",
        figures=lambda laboratory: axis_outputs("figure-5.9", laboratory.bsn_sines.only(frequencies=[3.0])),
        claims=(
            Claim(
                name="5.9-both",
                statement="Both networks still reduce the motor error.",
                criterion="RMS error lower than without.",
                checks=lambda laboratory: _lower(laboratory, 3.0, 0.0),
            ),
            Claim(
                name="5.9-less",
                statement="They reduce it by less than on the motion that they were trained on.",
                criterion="A larger share of the RMS error is left at 3 Hz than at 1 Hz.",
                checks=lambda laboratory: less_left_than(laboratory.bsn_sines, NETWORKS, 1.0, 3.0),
            ),
            Claim(
                name="5.9-feedback",
                statement="The feedback shows that friction is not compensated completely.",
                criterion=f"More than {ZERO:.0%} of its RMS without compensation is left.",
                checks=_feedback_remains,
            ),
        ),
    ),
)
