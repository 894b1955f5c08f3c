"""Thesis 4.3.1, LuGre feed-forward on one axis that follows a sine: Figures 4.2 to 4.5."""

import numpy as np

from ffgym.recordings import Recording
from ffgym.recordings.metrics import motor_error
from scripts.thesis.axis_measures import BEND, axis_miss, feedback_rms, settled, static_law_averages
from scripts.thesis.claims import CLEAR, ROUGH, ZERO, Check, Claim
from scripts.thesis.comparisons import label, less_left_than, lower_sine_errors, sine_rms_mrad
from scripts.thesis.items import Item
from scripts.thesis.laboratory import Laboratory
from scripts.thesis.pictures import axis_friction, axis_outputs

STATIC, DYNAMIC = "lugre_static", "lugre_dynamic"


def _same_curve(laboratory: Laboratory, frequency: float) -> list[Check]:
    miss = axis_miss(laboratory.lugre_sines.recordings[DYNAMIC, frequency])
    return [Check(where=f"{label(DYNAMIC)}, RMS difference / RMS friction", value=miss, limit=ZERO)]


def _peak_near_rest(recording: Recording) -> float:
    rows = settled(recording) & (np.abs(recording.joint_array("reference.velocity")[:, 0]) < BEND)
    return float(np.abs(recording.joint_array("friction.effort")[rows, 0]).max())


def _higher_peak(laboratory: Laboratory) -> list[Check]:
    slow, fast = (_peak_near_rest(laboratory.lugre_sines.recordings["none", f]) for f in (1.0, 3.0))
    return [Check(where=f"largest friction below {BEND:g} rad/s, 1 Hz against 3 Hz [N m]", value=slow, limit=fast)]


def _only_partly(laboratory: Laboratory) -> list[Check]:
    recordings = laboratory.lugre_sines.recordings
    miss = axis_miss(recordings[STATIC, 3.0])
    return [
        Check(
            where="dynamic against static LuGre, RMS difference / RMS friction",
            value=axis_miss(recordings[DYNAMIC, 3.0]),
            limit=miss,
        ),
        Check(where="static LuGre, RMS difference / RMS friction", value=miss, limit=ROUGH),
    ]


def _clearly_lower(laboratory: Laboratory, frequency: float) -> list[Check]:
    return [lower_sine_errors(laboratory.lugre_sines, law, "none", frequency, by=CLEAR) for law in (STATIC, DYNAMIC)]


def _nothing_left(laboratory: Laboratory) -> list[Check]:
    study = laboratory.lugre_sines
    feedback = {law: feedback_rms(study.recordings[law, 1.0]) for law in ("none", DYNAMIC)}
    return [
        lower_sine_errors(study, DYNAMIC, "none", 1.0, by=1 - ZERO),
        Check(where="RMS feedback [N m]", value=feedback[DYNAMIC], limit=ZERO * feedback["none"]),
    ]


def _error_at_reversals(laboratory: Laboratory) -> list[Check]:
    study = laboratory.lugre_sines
    recording = study.recordings[STATIC, 1.0]
    rows = settled(recording)
    error = np.abs(motor_error(recording)[rows, 0])
    speed = np.abs(recording.joint_array("reference.velocity")[rows, 0])
    return [
        Check(where="speed at which the error is largest [rad/s]", value=float(speed[error.argmax()]), limit=BEND),
        Check(
            where="a noticeable error, against what static LuGre leaves [mrad]",
            value=ZERO * sine_rms_mrad(study, "none", 1.0),
            limit=sine_rms_mrad(study, STATIC, 1.0),
        ),
    ]


ITEMS = (
    Item(
        name="figure-4.2",
        chapter="chapter-4",
        title="friction and LuGre feed-forward of one axis, 1 Hz",
        figures=lambda laboratory: axis_friction("figure-4.2", laboratory.lugre_sines.only(frequencies=[1.0])),
        claims=(
            Claim(
                name="4.2-dynamic",
                statement="The torque of the dynamic law and the friction of the axis are the same curve.",
                criterion=f"RMS difference at most {ZERO:.0%} of the RMS friction, a line's width.",
                checks=lambda laboratory: _same_curve(laboratory, 1.0),
            ),
            Claim(
                name="4.2-static",
                statement="The static law averages over the two branches of the dynamic friction.",
                criterion="At low speed it is nearer to the mean of the branches than they are.",
                checks=lambda laboratory: static_law_averages(laboratory.lugre_sines.recordings[STATIC, 1.0]),
            ),
        ),
    ),
    Item(
        name="figure-4.3",
        chapter="chapter-4",
        title="one axis before and after LuGre feed-forward, 1 Hz",
        figures=lambda laboratory: axis_outputs("figure-4.3", laboratory.lugre_sines.only(frequencies=[1.0])),
        claims=(
            Claim(
                name="4.3-both",
                statement="Both laws reduce the motor error significantly.",
                criterion=f"RMS error at least {CLEAR:.0%} lower than without.",
                checks=lambda laboratory: _clearly_lower(laboratory, 1.0),
            ),
            Claim(
                name="4.3-dynamic",
                statement="With the dynamic law motor error and feedback are zero.",
                criterion=f"At most {ZERO:.0%} of their RMS without compensation is left.",
                checks=_nothing_left,
            ),
            Claim(
                name="4.3-static",
                statement="With the static law a small, noticeable error stays where the speed changes its direction.",
                criterion=f"The error peaks below {BEND:g} rad/s, and its RMS is more than {ZERO:.0%} of that without.",
                checks=_error_at_reversals,
            ),
        ),
    ),
    Item(
        name="figure-4.4",
        chapter="chapter-4",
        title="friction and LuGre feed-forward of one axis, 3 Hz",
        figures=lambda laboratory: axis_friction("figure-4.4", laboratory.lugre_sines.only(frequencies=[3.0])),
        claims=(
            Claim(
                name="4.4-peak",
                statement="The peak of the friction is larger than at 1 Hz.",
                criterion=f"Largest friction below {BEND:g} rad/s, where the bristles break away.",
                checks=_higher_peak,
            ),
            Claim(
                name="4.4-dynamic",
                statement="The dynamic law follows the friction.",
                criterion=f"RMS difference at most {ZERO:.0%} of the RMS friction.",
                checks=lambda laboratory: _same_curve(laboratory, 3.0),
            ),
            Claim(
                name="4.4-static",
                statement="The static law follows only parts of it.",
                criterion=f"It misses more than the dynamic law, yet less than {ROUGH:.0%} of the RMS friction.",
                checks=_only_partly,
            ),
        ),
    ),
    Item(
        name="figure-4.5",
        chapter="chapter-4",
        title="one axis before and after LuGre feed-forward, 3 Hz",
        figures=lambda laboratory: axis_outputs("figure-4.5", laboratory.lugre_sines.only(frequencies=[3.0])),
        claims=(
            Claim(
                name="4.5-both",
                statement="Both laws still improve the tracking of the motor significantly.",
                criterion=f"RMS error at least {CLEAR:.0%} lower than without.",
                checks=lambda laboratory: _clearly_lower(laboratory, 3.0),
            ),
            Claim(
                name="4.5-less",
                statement="The error is reduced by less than at 1 Hz.",
                criterion="A larger share of the RMS error is left at 3 Hz than at 1 Hz.",
                checks=lambda laboratory: less_left_than(laboratory.lugre_sines, (STATIC, DYNAMIC), 1.0, 3.0),
            ),
        ),
    ),
)
