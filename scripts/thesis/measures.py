"""Numbers that claims are decided by: what the table of claims calls a measure.

Each is a function of the studies; `of` names the results that it is taken from. None is what was not published.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.interpolate import BSpline

from ffgym.agents.spline_basis import FINE_RANGE, SplineBasis
from ffgym.core.measures import rms
from ffgym.core.types import Array, BoolArray
from ffgym.diagnosis.identification.narx import Misfit
from ffgym.published import published_mm
from ffgym.recordings import Recording
from ffgym.recordings.metrics import friction_miss, motor_error, motor_error_rms
from ffgym.report import circle_tables
from ffgym.report.circles.comparison import reduction
from ffgym.report.circles.friction_plot import unlike
from ffgym.studies import CircleStudy
from ffgym.studies.one_axis import SETTLED
from scripts.thesis.narx import ESTIMATION, VALIDATION, static_misfit
from scripts.thesis.studies import ThesisStudies

RECORDS = {"ESTIMATION": ESTIMATION, "VALIDATION": VALIDATION}
"""Names of the two sines of thesis 6.2.2."""
NOTHING = ThesisStudies()
"""No results, for numbers that need none."""
BEND = 1.0
"""Motor speed [rad/s] below which the thesis sees friction's nonlinearity (5.1.1)."""
KNOTS = np.arange(1.0, 6.0)
"""Knots of Figure 3.3."""
PLACES = np.linspace(KNOTS[0], KNOTS[-1], 4001)[:-1]
"""Places at which its splines are compared; the last knot belongs to no piece of (3.9)."""
Joint = int | Sequence[int] | None
"""Joint, from 1, or joints whose mean counts; None is all."""


class AsPublished:
    """The studies with the published RMS path errors of the real robot; circles without one are left out."""

    def __init__(self, studies: ThesisStudies) -> None:
        self._studies = studies

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._studies, name)
        if not isinstance(found, CircleStudy):
            return found
        published = [
            (cell, published_mm(cell.agent, "rms", cell.speed_mm_s / 1e3, cell.radius_mm / 1e3, cell.position))
            for cell in found.cells
        ]
        return replace(found, cells=[replace(cell, rms_mm=rms) for cell, rms in published if rms is not None])


# ---- circles: `speed` in m/s, `radius` in mm; without position, speed or radius the mean over all


def path(
    studies: ThesisStudies,
    of: str,
    law: str,
    position: str | None = None,
    speed: float | None = None,
    radius: float | None = None,
) -> float | None:
    """RMS path error [mm] in the plane of the circle."""
    wanted = {"position": position, "speed_mm_s": None if speed is None else round(speed * 1e3, 6), "radius_mm": radius}
    study: CircleStudy = getattr(studies, of)
    cells = study.select(agent=law, **{name: value for name, value in wanted.items() if value is not None})
    return float(np.mean([cell.rms_mm for cell in cells])) if cells else None


def motor(studies: ThesisStudies, of: str, law: str, position: str, speed: float, joint: int) -> float:
    """RMS motor error of a joint over a whole motion without standstill [mrad], motor side."""
    study: CircleStudy = getattr(studies, of)
    return float((motor_error_rms(study.recordings[law, position, speed]) * 1e3)[joint - 1])


def gone(
    studies: ThesisStudies,
    of: str,
    law: str,
    error: str = "path",
    than: str = "none",
    position: str | None = None,
    speed: float | None = None,
    radius: float | None = None,
) -> float:
    """Share of the mean RMS path error that is gone; of `error` 'motor' the mean share over joints and motions."""
    if error == "path":
        ours, theirs = (path(studies, of, each, position, speed, radius) for each in (law, than))
        assert ours is not None
        assert theirs is not None
        return 1 - ours / theirs
    recordings = getattr(studies, of).recordings
    places = [key[1:] for key in recordings if key[0] == law and position in (None, key[1]) and speed in (None, key[2])]
    rms = [[motor_error_rms(recordings[each, *place]) * 1e3 for each in (law, than)] for place in places]
    return float(np.mean([1 - ours / theirs for ours, theirs in rms]))


def kept(
    studies: ThesisStudies,
    of: str,
    law: str,
    than: str = "none",
    position: str | None = None,
    speed: float | None = None,
    radius: float | None = None,
) -> float:
    """Share of the mean RMS path error that is left."""
    return 1 - gone(studies, of, law, "path", than, position, speed, radius)


def measure_published(studies: ThesisStudies, of: str, law: str, speed: float) -> float | None:
    """Share of the published mean RMS path error that is gone."""
    [table] = circle_tables(getattr(studies, of).only(speeds=[speed]))
    return reduction(table.mean_published_rms(law), table.mean_published_rms("none"))


def larger_over_published(
    studies: ThesisStudies, of: str, law: str, position: str, speed: float, radius: float
) -> float | None:
    """Simulated and published RMS path error of a circle, the larger over the smaller."""
    published = published_mm(law, "rms", speed, radius / 1e3, position)
    simulated = path(studies, of, law, position, speed, radius)
    return max(simulated / published, 1 / (simulated / published)) if published and simulated else None


def top_speed(studies: ThesisStudies, speed: float, joint: int | None = None) -> float:
    """Largest motor speed [rad/s] of the reference at p1, of one joint or all."""
    speeds = top_speeds(studies, speed)
    return float(speeds.max() if joint is None else speeds[joint - 1])


def top_speeds(studies: ThesisStudies, speed: float) -> Array:
    """Largest motor speed of the reference [rad/s] of each joint at p1, shape (N,)."""
    recording = studies.lugre_circles.recordings["none", "p1", speed]
    return np.abs(recording.joint_array("reference.velocity")).max(axis=0)


def mean_feedback(studies: ThesisStudies, integral: bool) -> float:
    """Mean feedback of joint 2 at p1, 10 mm/s, without sign [N m], with or without its integral part."""
    recording = studies.lugre_circles.recordings["none", "p1", 0.010]
    moving = ~recording.mask(kind="standstill")
    feedback = recording.joint_array("feedback.effort")[moving, 1]
    if not integral:
        feedback = feedback - recording.joint_array("feedback.integral")[moving, 1]
    return float(abs(feedback.mean()))


def unlike_lugre(studies: ThesisStudies, of: str, law: str, speed: float, joint: Joint = None) -> float:
    """RMS difference of what a network and dynamic LuGre add at p1, over RMS of the latter."""
    recordings = getattr(studies, of).recordings
    return _of_joints(unlike(recordings[law, "p1", speed], recordings["lugre_dynamic", "p1", speed]), joint)


# ---- one axis that follows a sine


def sine(studies: ThesisStudies, of: str, law: str, frequency: float) -> float:
    """RMS motor error of the sine test [mrad], motor side."""
    [result] = [r for r in getattr(studies, of).results if (r.agent, r.frequency_hz) == (law, frequency)]
    return float(result.motor_rms_rad * 1e3)


def sine_left(studies: ThesisStudies, of: str, law: str, frequency: float) -> float:
    """Share of the RMS motor error of the sine test that is left."""
    [result] = [r for r in getattr(studies, of).results if (r.agent, r.frequency_hz) == (law, frequency)]
    return float(1 - result.reduction)


def axis_miss(studies: ThesisStudies, of: str, law: str, frequency: float, above: float = -1.0) -> float:
    """RMS of friction minus added torque over RMS friction, where the motor is faster than `above` [rad/s]."""
    recording, rows = _settle(studies, of, law, frequency)
    return float(friction_miss(recording, rows & (_speed_size(recording) > above))[0])


def feedback(studies: ThesisStudies, of: str, law: str, frequency: float) -> float:
    """RMS feedback torque [N m], motor side."""
    recording, rows = _settle(studies, of, law, frequency)
    return rms(recording.joint_array("feedback.effort")[rows, 0])


def feedback_at_reversal(studies: ThesisStudies, of: str, law: str, frequency: float) -> float:
    """RMS feedback [N m] while the speed goes from negative to positive."""
    recording, rows = _settle(studies, of, law, frequency)
    rises = np.gradient(recording.joint_array("reference.velocity")[:, 0]) > 0
    return rms(recording.joint_array("feedback.effort")[rows & (_speed_size(recording) < BEND) & rises, 0])


def speed_of_largest_error(studies: ThesisStudies, of: str, law: str, frequency: float) -> float:
    """Motor speed without sign [rad/s] at which the motor error is largest."""
    recording, rows = _settle(studies, of, law, frequency)
    return float(_speed_size(recording)[rows][np.abs(motor_error(recording)[rows, 0]).argmax()])


def peak_near_rest(studies: ThesisStudies, of: str, frequency: float, law: str = "none") -> float:
    """Largest friction below BEND [N m]."""
    recording, rows = _settle(studies, of, law, frequency)
    return float(np.abs(recording.joint_array("friction.effort")[rows & (_speed_size(recording) < BEND), 0]).max())


def off_the_branches(studies: ThesisStudies, of: str, law: str, frequency: float) -> float:
    """RMS distance of a static law from the mean of both branches of friction below BEND [N m]."""
    recording, _ = _settle(studies, of, law, frequency)
    up, down = _branches(recording, "friction.effort")
    return rms(np.mean(_branches(recording, "compensation.effort"), axis=0) - (up + down) / 2)


def half_a_loop(studies: ThesisStudies, of: str, law: str, frequency: float) -> float:
    """Half the RMS distance of both branches of friction below BEND [N m]."""
    up, down = _branches(_settle(studies, of, law, frequency)[0], "friction.effort")
    return rms((up - down) / 2)


def _settle(studies: ThesisStudies, of: str, law: str, frequency: float) -> tuple[Recording, BoolArray]:
    """The recording, and its rows after the start has settled, shape (T,)."""
    recording: Recording = getattr(studies, of).recordings[law, frequency]
    return recording, np.asarray(recording.t >= SETTLED)


def _speed_size(recording: Recording) -> Array:
    return np.abs(recording.joint_array("reference.velocity")[:, 0])


def _branches(recording: Recording, family: str) -> tuple[Array, Array]:
    """Torque of `family` [N m] at 41 speeds below BEND, while the speed rises and while it falls."""
    rows = recording.t >= SETTLED
    speed, torque = (recording.joint_array(name)[rows, 0] for name in ("reference.velocity", family))
    rises = np.gradient(speed) > 0

    def branch(wanted: Array) -> Array:
        order = np.argsort(speed[wanted])
        return np.interp(np.linspace(-BEND, BEND, 41), speed[wanted][order], torque[wanted][order])

    return branch(rises), branch(~rises)


# ---- learning; trials count from 0, which is before learning


def left(studies: ThesisStudies, of: str, law: str, what: str, joint: Joint = None, trial: int = -1) -> float:
    """Mean square of 'error' or 'signal' after a trial, over the first one."""
    return _of_joints(lefts(studies, of, law, what)[trial], joint)


def fall(studies: ThesisStudies, of: str, law: str, what: str, joint: int, after: int) -> float:
    """Fall of what is left from a trial to the last one."""
    found = lefts(studies, of, law, what)
    return float(found[after, joint - 1] - found[-1, joint - 1])


def last_fall(studies: ThesisStudies, of: str, law: str) -> float:
    """Fall of the mean square error in the last iteration over itself, mean of the joints."""
    squares = getattr(studies, of)[law].error
    return 1 - float(np.mean(squares[-1] / squares[-2]))


def spread_over_joints(studies: ThesisStudies, of: str, law: str, what: str) -> float:
    """Largest less smallest of what is left at the end."""
    return float(np.ptp(lefts(studies, of, law, what)[-1]))


def splines_of(order: int) -> tuple[Array, Array]:
    """Splines of Figure 3.3 by the usual recursion: places (T,) from 1 to 5, and values (T, S)."""
    if order == 1:  # (3.9), where a knot belongs to the piece on its right
        return PLACES, ((KNOTS[:-1] <= PLACES[:, None]) & (PLACES[:, None] < KNOTS[1:])).astype(np.float64)
    splines = [BSpline.basis_element(KNOTS[i : i + order + 1], extrapolate=False) for i in range(len(KNOTS) - order)]
    return PLACES, np.stack([np.nan_to_num(spline(PLACES)) for spline in splines], axis=1)


def printed_splines(order: int) -> Array:
    """Splines on the same knots by (3.9) and (3.11) as they are printed, as many as the knots allow, (T, S)."""
    if order == 1:
        return splines_of(1)[1]
    below = printed_splines(order - 1)
    found = []
    for i in range(len(KNOTS) - order - 1):
        rising = (PLACES - KNOTS[i]) / (KNOTS[i + order] - KNOTS[i])
        falling = (KNOTS[i + order + 1] - PLACES) / (KNOTS[i + order + 1] - KNOTS[i + 1])
        found.append(rising * below[:, i] + falling * below[:, i + 1])
    return np.stack(found, axis=1)


def largest_spline(studies: ThesisStudies, order: int) -> float:
    """Largest value of the splines of Figure 3.3 of an order."""
    return float(splines_of(order)[1].max())


def least_spline(studies: ThesisStudies, order: int) -> float:
    """Least value of the splines of Figure 3.3 of an order, without its sign."""
    return float(abs(splines_of(order)[1].min()))


def off_the_printed_recursion(studies: ThesisStudies, order: int) -> float:
    """Largest distance between the splines of Figure 3.3 and (3.11) as it is printed."""
    printed = printed_splines(order)
    return float(np.abs(printed - splines_of(order)[1][:, : printed.shape[1]]).max())


def widest_gap_inside(studies: ThesisStudies) -> float:
    """Widest gap between knots of a B-spline network within its fine range [rad/s]."""
    return float(max(gap for gap, is_fine in _gaps() if is_fine))


def narrowest_gap_outside(studies: ThesisStudies) -> float:
    """Narrowest gap outside [rad/s]."""
    return float(min(gap for gap, is_fine in _gaps() if not is_fine))


def _gaps() -> list[tuple[float, bool]]:
    knots = SplineBasis().knots
    gaps = np.diff(knots)
    return list(zip(gaps, np.abs(knots[:-1] + gaps / 2) < FINE_RANGE, strict=True))


def lefts(studies: ThesisStudies, of: str, law: str, what: str) -> Array:
    """Mean squares over those of the first trial, shape (K, N)."""
    squares: Array = getattr(getattr(studies, of)[law], what)[:, 0]
    return squares / squares[0]


# ---- identified friction of joint 1 (6.1): `number` of a record of Table 6.1, `model` 'identified' or 'original'


def record_error(studies: ThesisStudies, number: int, model: str) -> float:
    """RMS error of a model on a record [N m]."""
    return studies.joint_1.errors_of(model)[number].rms_error


def record_share(studies: ThesisStudies, number: int, model: str) -> float:
    """RMS error of a model over RMS friction of a record."""
    return record_error(studies, number, model) / studies.joint_1.errors_of(model)[number].rms_friction


def record_friction(studies: ThesisStudies, number: int) -> float:
    """RMS friction of a record [N m]."""
    torque, joint = studies.joint_1.records[number], studies.joint_1.index
    return rms(torque.friction[torque.valid, joint])


def rising_from_falling(studies: ThesisStudies, number: int) -> float:
    """Distance of mean friction while the speed rises from that while it falls, below BEND [N m]."""
    torque, joint = studies.joint_1.records[number], studies.joint_1.index
    speed, friction = torque.signals.motor_dq[:, joint], torque.friction[:, joint]
    rises, slow = np.gradient(speed) > 0, torque.valid & (np.abs(speed) < BEND)
    return float(abs(friction[slow & rises].mean() - friction[slow & ~rises].mean()))


def off_the_stribeck_curve(studies: ThesisStudies) -> float | None:
    """RMS distance of the points at constant speed from the identified curve [N m]; None if there are too few."""
    fit = studies.joint_1.found.joints[studies.joint_1.index].stribeck
    return None if fit is None else fit.rms_error


def friction_at_constant_speeds(studies: ThesisStudies) -> float | None:
    """RMS friction of these points [N m]."""
    fit = studies.joint_1.found.joints[studies.joint_1.index].stribeck
    return None if fit is None else rms(fit.data.levels()[1])


# ---- NARX networks (6.2): one number per random start, shape (S,), or their median


def free_run(studies: ThesisStudies, of: str, network: str, record: str, median: bool = False) -> Array | float:
    """RMS error in free run [N m]."""
    found = getattr(studies, of)[network].rms(record)
    return float(np.median(found)) if median else found


def one_step(studies: ThesisStudies, of: str, network: str, record: str) -> Array:
    """RMS error one step ahead [N m]."""
    return np.asarray(getattr(studies, of)[network].errors[record].prediction.rms)


def fit(studies: ThesisStudies, of: str, network: str, record: str) -> Array:
    """Fit in free run [%]."""
    return np.asarray(getattr(studies, of)[network].errors[record].simulation.fit)


def missing_fit(studies: ThesisStudies, of: str, network: str, record: str) -> Array:
    """Fit in free run that is missing to 100 %."""
    return 100 - fit(studies, of, network, record)


def median_share(studies: ThesisStudies, of: str, network: str, record: str) -> float:
    """RMS error in free run over RMS friction, median of the starts."""
    return float(np.median(getattr(studies, of)[network].errors[record].simulation.share))


def branch_error(studies: ThesisStudies, of: str, network: str, rising: bool) -> Array:
    """RMS error in free run on validation data [N m] while the speed rises, or while it falls."""
    model, samples = getattr(studies, of)[network].model, studies.narx_records[VALIDATION]
    rows = (np.gradient(samples.motor_dq[:, 0]) > 0) == rising
    simulated = model.simulate(np.repeat(samples.motor_dq, model.n_joints, axis=1))
    return Misfit.of(simulated[rows], samples.torque[rows]).rms


def static_curve(studies: ThesisStudies, record: str) -> float:
    """RMS error of the static curve [N m]."""
    return float(static_of(studies, record).rms[0])


def static_of(studies: ThesisStudies, record: str) -> Misfit:
    """Compute what the static curve leaves of a record."""
    return static_misfit(studies.axis.friction, (studies.narx_records | studies.narx_reach)[record])


def _of_joints(values: Array, joint: Joint) -> float:
    """Value of one joint, or the mean of several."""
    return float(values.mean() if joint is None else np.mean(values[np.asarray(joint) - 1]))
