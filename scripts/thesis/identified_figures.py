"""Figures and tables of identified friction: thesis 6.1."""

from collections.abc import Callable, Sequence

import numpy as np

from ffgym.diagnosis.identification.bristle_fit import NAMES
from ffgym.published import ESTIMATION_RECORDS, FRICTION_RECORDS
from ffgym.report import ReportFigure
from ffgym.report.identification import friction_loops_figure, friction_over_time_figure
from ffgym.report.identification.stribeck_plot import stribeck_figure
from ffgym.robot.friction import LuGreParameters
from scripts.thesis.identified_checks import shares
from scripts.thesis.items import PlainTable
from scripts.thesis.laboratory import Laboratory
from scripts.thesis.measured_friction import MeasuredFriction

Models = Callable[[MeasuredFriction], dict[str, LuGreParameters]]


def none(measured: MeasuredFriction) -> dict[str, LuGreParameters]:
    """No model, what was measured alone."""
    return {}


def new(measured: MeasuredFriction) -> dict[str, LuGreParameters]:
    """The identified model."""
    return {"identified": measured.found.friction}


def old(measured: MeasuredFriction) -> dict[str, LuGreParameters]:
    """The original model, that of the controller."""
    return {"original": measured.old}


def both(measured: MeasuredFriction) -> dict[str, LuGreParameters]:
    """The identified and the original model."""
    return new(measured) | old(measured)


def over_speed(
    name: str, title: str, numbers: Sequence[int], models: Models
) -> Callable[[Laboratory], list[ReportFigure]]:
    """Friction of records over motor speed, one panel each."""
    return lambda laboratory: [_loops(name, title, laboratory.joint_1, numbers, models)]


def over_both(name: str, title: str, number: int, models: Models) -> Callable[[Laboratory], list[ReportFigure]]:
    """Friction of one record over time (a) and over motor speed (b)."""

    def figures(laboratory: Laboratory) -> list[ReportFigure]:
        measured = laboratory.joint_1
        over_time = friction_over_time_figure(
            measured.records[number], measured.index, models(measured), known=measured.known
        )
        return [
            ReportFigure(
                name=f"{name}a",
                title=f"{title}, over time",
                thesis="",
                caption=_caption(measured, [number], models),
                figure=over_time,
            ),
            _loops(f"{name}b", f"{title}, over speed", measured, [number], models),
        ]

    return figures


def _loops(name: str, title: str, measured: MeasuredFriction, numbers: Sequence[int], models: Models) -> ReportFigure:
    records = [measured.records[number] for number in numbers]
    return ReportFigure(
        name=name,
        title=title,
        thesis="",
        caption=_caption(measured, numbers, models),
        figure=friction_loops_figure(records, measured.index, models(measured), known=measured.known),
    )


def _caption(measured: MeasuredFriction, numbers: Sequence[int], models: Models) -> str:
    named = {each.number: each for each in FRICTION_RECORDS}
    shown = ", ".join(f"{named[n].amplitude:g} sin(2π {named[n].frequency:g} t) (record {n})" for n in numbers)
    text = f"Speed of the motor {shown}; {measured.joint} of a workcell."
    for name, friction in models(measured).items():
        left = ", ".join(f"{share:.0%}" for share in shares(measured, friction, numbers).values())
        text += f" RMS error of the {name} model over RMS friction: {left}."
    return text


def static(laboratory: Laboratory) -> list[ReportFigure]:
    """Friction at constant speeds, with the identified static model."""
    measured = laboratory.joint_1
    return [
        ReportFigure(
            name="figure-6.1",
            title="Friction at constant speeds, and the identified static model",
            thesis="",
            caption=f"{measured.joint} of a workcell; without what both directions do not share. "
            "Before: the model of the controller.",
            figure=stribeck_figure(measured.found),
        )
    ]


def parameters(laboratory: Laboratory) -> list[PlainTable]:
    """The six parameters: published, identified, before."""
    measured, thesis = laboratory.joint_1, laboratory.axis.friction  # the one axis carries (6.9) and (6.18)
    rows = tuple(
        (
            f"{name.replace('_', ' ')} [{estimate.unit}]",
            f"{getattr(thesis, name)[0]:g}",
            f"{estimate.value:.4g}",
            f"{estimate.low:.4g} to {estimate.high:.4g}" if np.isfinite(estimate.high) else "unknown",
            f"{estimate.prior:.4g}",
            estimate.status,
        )
        for name, estimate in zip(NAMES, measured.found.joints[measured.index].estimates, strict=True)
    )
    return [
        PlainTable(
            headings=("parameter", "thesis, real robot", "workcell", "90 % interval", "before", "status"),
            rows=rows,
            note="The workcell was made with the thesis' values and errs beyond the LuGre model, so that near is by "
            "construction and exact is not to be expected. A parameter that is not identified keeps its value.",
        )
    ]


def records(laboratory: Laboratory) -> list[PlainTable]:
    """The fifteen records, and what both models leave of them."""
    measured = laboratory.joint_1
    after, before = measured.errors(measured.found.friction), measured.errors(measured.old)
    rows = tuple(
        (
            f"{each.number}",
            f"{each.amplitude:g}",
            f"{each.frequency:g}",
            "D" if each.number in ESTIMATION_RECORDS else "V",
            f"{after[each.number].rms_friction:.3f}",
            f"{before[each.number].rms_error:.3f}",
            f"{after[each.number].rms_error:.3f}",
        )
        for each in FRICTION_RECORDS
    )
    return [
        PlainTable(
            headings=(
                "record",
                "A [rad/s]",
                "f [Hz]",
                "set",
                "RMS friction [N m]",
                "original [N m]",
                "identified [N m]",
            ),
            rows=rows,
            note="RMS errors of the dynamic LuGre model. Record 11 is printed with A = 5, as record 6; by the pattern "
            "of the table and Figure 6.5e it is 10.",
        )
    ]
