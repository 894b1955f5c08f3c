"""The report's figures under the names of the thesis' figures: what the table of claims calls `figures`."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ffgym.agents.bspline import StaticBSN
from ffgym.agents.spline_basis import FINE_RANGE, SplineBasis
from ffgym.agents.stability import learning_curves
from ffgym.agents.trials import SimulatedTrial, thesis_motions
from ffgym.paths import SPEEDS
from ffgym.published import FRICTION_RECORDS
from ffgym.report import ReportFigure, law_styles
from ffgym.report.circles.errors_plot import motor_error_figure
from ffgym.report.circles.friction_plot import joint_loops_figure, one_axis_figure, one_axis_loops_figure
from ffgym.report.circles.paths_plot import paths_figure
from ffgym.report.identification import friction_loops_figure, friction_over_time_figure
from ffgym.report.identification.plots import stribeck_figure
from ffgym.report.learning_plots import agents_figure, learning_figure
from ffgym.robot import RigidArm
from ffgym.studies import CircleStudy
from scripts.thesis.measures import KNOTS, PLACES, lefts, printed_splines, record_share, splines_of, top_speeds
from scripts.thesis.narx import ESTIMATION, VALIDATION, record_name
from scripts.thesis.network_plots import (
    basis_figure,
    feedback_over_speed_figure,
    feedback_parts_figure,
    fits_figure,
    narx_figure,
    orders_figure,
    training_caption,
    training_figure,
)
from scripts.thesis.studies import ThesisStudies
from scripts.thesis.tables import VALIDATING, fit_of_static, mean_rms, spread

RATES = (0.4, 0.8, 1.6, 2.2)
"""Learning rates of the figure of stability: half and all of that of thesis 5.3.1, and two beyond; chosen."""
ITERATIONS = 15
"""Iterations as in thesis 5.3.1."""


ORDERS = (1, 2, 3)
"""Orders of Figure 3.3."""


def _name(figure: ReportFigure, name: str, title: str) -> ReportFigure:
    """Figure of a report under the name of the thesis' figure."""
    return replace(figure, name=name, title=title, thesis="")


def axis_friction(studies: ThesisStudies, name: str, of: str, frequency: float) -> list[ReportFigure]:
    """Friction of one axis over speed, and what each law adds."""
    study = getattr(studies, of).only(frequencies=[frequency])
    return [_name(one_axis_loops_figure(study), name, "Friction and added torque over speed")]


def axis_outputs(studies: ThesisStudies, name: str, of: str, frequency: float) -> list[ReportFigure]:
    """Speed, error and feedback of one axis over time."""
    study = getattr(studies, of).only(frequencies=[frequency])
    return [_name(one_axis_figure(study, frequency), name, "Speed, motor error and feedback before and after")]


def paths(studies: ThesisStudies, name: str, of: str, position: str, speed: float) -> list[ReportFigure]:
    """Path of the tool (a) and motor errors (b)."""
    return _paths(name, getattr(studies, of).only(positions=[position], speeds=[speed]))


def network_paths(studies: ThesisStudies, name: str, of: str, position: str, speed: float) -> list[ReportFigure]:
    """The same with both networks and no compensation."""
    laws = ["none", "bsn_static", "bsn_extended"]
    return _paths(name, getattr(studies, of).only(laws=laws, positions=[position], speeds=[speed]))


def _paths(name: str, study: CircleStudy) -> list[ReportFigure]:
    return [
        _name(paths_figure(study), f"{name}a", "Path of the tool"),
        _name(motor_error_figure(study), f"{name}b", "RMS motor position error per joint"),
    ]


def joint_friction(studies: ThesisStudies, name: str, of: str, speed: float) -> list[ReportFigure]:
    """Friction of each joint over speed at p1, what each law adds, and what dynamic LuGre would add."""
    study = getattr(studies, of).only(positions=["p1"], speeds=[speed])
    figure = joint_loops_figure(study, beside="lugre_dynamic")
    return [_name(figure, name, "Friction and added torque of each joint over speed")]


def training(studies: ThesisStudies, name: str, of: str) -> list[ReportFigure]:
    """Mean squares of error and learning signal of each network over iterations; all learn on one motion."""
    joints = (studies.axis if of == "axis_learning" else studies.robot).joints
    found = {
        law_styles([law])[law].label: {what: lefts(studies, of, law, what) for what in ("error", "signal")}
        for law in getattr(studies, of)
    }
    title = "Mean squares of error and learning signal over iterations"
    return [ReportFigure(name, title, training_caption(found, joints), training_figure(found, joints))]


def basis(studies: ThesisStudies, name: str) -> list[ReportFigure]:
    """Basis functions of a B-spline network."""
    basis = SplineBasis()
    speeds = np.linspace(basis.knots[0], basis.knots[-1], 8001)
    values, splines = basis.active(speeds)
    curves = np.zeros((len(speeds), basis.n_splines))
    np.put_along_axis(curves, splines, values, axis=1)
    caption = f"{basis.n_splines} splines of order {basis.order} on {len(basis.knots)} knots; their sum is 1."
    return [ReportFigure(name, "Basis functions of a network", caption, basis_figure(speeds, curves, FINE_RANGE))]


def orders(studies: ThesisStudies, name: str) -> list[ReportFigure]:
    """B-splines of the orders 1 to 3 on the knots 1 to 5, and with outermost knots repeated as in the networks."""
    ends = np.append(PLACES, KNOTS[-1])
    repeated = {}
    for order in ORDERS:
        basis = SplineBasis(knots=KNOTS, order=order)
        values, splines = basis.active(ends)
        repeated[order] = np.zeros((len(ends), basis.n_splines))
        np.put_along_axis(repeated[order], splines, values, axis=1)
    caption = (
        "Above: splines of the usual recursion on these knots. Below: with the outermost knots repeated, as the "
        "networks have them, so that they add up to 1 from the first knot to the last. Dotted: (3.11) as it is "
        "printed, its first spline; the knots in its denominators are counted one too far."
    )
    plain = {order: splines_of(order)[1] for order in ORDERS}
    printed = {order: printed_splines(order)[:, 0] for order in ORDERS[1:]}
    figure = orders_figure(PLACES, plain, printed, ends, repeated)
    return [ReportFigure(name, "B-splines of orders 1 to 3", caption, figure)]


def feedback_over_speed(studies: ThesisStudies, name: str) -> list[ReportFigure]:
    """Feedback of each joint at p1, 100 mm/s."""
    speeds = ", ".join(f"{speed:.3g}" for speed in top_speeds(studies, 0.100))
    caption = f"No compensation, p1, 100 mm/s, without standstill. Largest speeds: {speeds} rad/s."
    figure = feedback_over_speed_figure(studies.lugre_circles.recordings["none", "p1", 0.100])
    return [ReportFigure(name, "Feedback over motor speed", caption, figure)]


def feedback_parts(studies: ThesisStudies, name: str) -> list[ReportFigure]:
    """Feedback of joint 2 at p1, 10 mm/s, and its integral part."""
    title = "Feedback of joint 2 with and without its integral part"
    caption = "No compensation, p1, 10 mm/s. The integral part carries gravity, so that u_p has no offset."
    figure = feedback_parts_figure(studies.lugre_circles.recordings["none", "p1", 0.010], joint=1)
    return [ReportFigure(name, title, caption, figure)]


def static_friction(studies: ThesisStudies, name: str) -> list[ReportFigure]:
    """Friction of joint 1 at constant speeds."""
    measured = studies.joint_1
    caption = f"{measured.joint} of a workcell; without what both directions do not share. "
    title = "Friction at constant speeds, and the identified static model"
    figure = stribeck_figure(measured.found)
    return [ReportFigure(name, title, f"{caption}Before: the model of the controller.", figure)]


def records_over_speed(
    studies: ThesisStudies, name: str, what: str, numbers: Sequence[int], models: Sequence[str]
) -> list[ReportFigure]:
    """Friction of records of joint 1 over motor speed, one panel each, with models."""
    measured = studies.joint_1
    shown, curves = [measured.records[number] for number in numbers], {each: measured.model(each) for each in models}
    figure = friction_loops_figure(shown, measured.index, curves, known=measured.known)
    return [ReportFigure(name, what, _records_caption(studies, numbers, models), figure)]


def record_over_both(
    studies: ThesisStudies, name: str, what: str, number: int, models: Sequence[str]
) -> list[ReportFigure]:
    """Friction of one record over time (a) and over motor speed (b)."""
    measured = studies.joint_1
    curves = {each: measured.model(each) for each in models}
    over_time = friction_over_time_figure(measured.records[number], measured.index, curves, known=measured.known)
    caption = _records_caption(studies, [number], models)
    return [
        ReportFigure(f"{name}a", f"{what}, over time", caption, over_time),
        *records_over_speed(studies, f"{name}b", f"{what}, over speed", [number], models),
    ]


def _records_caption(studies: ThesisStudies, numbers: Sequence[int], models: Sequence[str]) -> str:
    named = {each.number: each for each in FRICTION_RECORDS}
    shown = ", ".join(f"{named[n].amplitude:g} sin(2π {named[n].frequency:g} t) (record {n})" for n in numbers)
    caption = f"Speed of the motor {shown}; {studies.joint_1.joint} of a workcell."
    for model in models:
        shares = ", ".join(f"{record_share(studies, number, model):.0%}" for number in numbers)
        caption += f" RMS error of the {model} model over RMS friction: {shares}."
    return caption


def network_torque(studies: ThesisStudies, name: str, of: str, network: str) -> list[ReportFigure]:
    """A NARX network in free run and the LuGre model."""
    found = getattr(studies, of)[network]
    parts = [
        f"{what}: free run {spread(found.errors[record].simulation.fit)} %, "
        f"one step {spread(found.errors[record].prediction.fit)} %"
        for record, what in ((ESTIMATION, "estimation"), (VALIDATION, "validation"))
    ]
    starts = found.model.n_joints
    caption = f"Fit, median of {starts} random starts (least to most); {'; '.join(parts)}. Drawn is the free run."
    title = f"NARX network of {found.candidate.label} and the LuGre model"
    return [ReportFigure(name, title, caption, narx_figure(found, studies.narx_records))]


def reach_of_networks(studies: ThesisStudies) -> list[ReportFigure]:
    """Fits of extended NARX networks to motions that they were not fitted to."""
    names = [ESTIMATION, VALIDATION, *map(record_name, VALIDATING), *studies.narx_reach]
    fits = {
        fit.candidate.label: np.stack([fit.errors[name].simulation.fit for name in names], axis=1)
        for fit in studies.narx_extended.values()
    }
    title = "Fit of the networks on motions they were not fitted to"
    caption = (
        "Free run; marks are medians of the random starts, bars reach from worst to best. What is below 0 "
        "errs more than the mean torque would, and is not drawn. The four on the right are unlike all records of "
        "Table 6.1; A in rad/s, f in Hz."
    )
    floors = np.array([fit_of_static(studies, name) for name in names])
    return [ReportFigure("narx-reach", title, caption, fits_figure(fits, floors, names))]


def agents(studies: ThesisStudies, name: str) -> list[ReportFigure]:
    """Mean path errors of every agent."""
    titles = {each.law.name: each.entry.title for each in studies.contenders}
    errors = {titles[law]: values for law, values in mean_rms(studies).items()}
    caption = "Mean RMS path error over 12 circles at each speed, logarithmic."
    return [
        ReportFigure(
            name, "Mean path error of every law", caption, agents_figure(errors, [speed * 1e3 for speed in SPEEDS])
        )
    ]


def stability(studies: ThesisStudies, name: str) -> list[ReportFigure]:
    """Learning of a static network on one axis at several rates."""
    arm = RigidArm(studies.axis)
    trial = SimulatedTrial(arm=arm, n_threads=studies.n_threads)
    curves = learning_curves(StaticBSN.zero(1), trial, thesis_motions(arm)[0], RATES, ITERATIONS)
    return [_name(learning_figure(curves), name, "Learning at several rates, predicted and simulated")]


def draw_reidentified(studies: ThesisStudies, name: str, of: str) -> list[ReportFigure]:
    """Motor errors with old and with identified parameters."""
    study = getattr(studies, of)
    title = "RMS motor position error per joint, with old and with identified parameters"
    return [_name(motor_error_figure(study), name, title)]
