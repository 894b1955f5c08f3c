"""Speed, motor error and feedback torque of the sine test over time, before and after: thesis Figures 4.3 and 4.5."""

from typing import TYPE_CHECKING

from ffgym.core.types import Array
from ffgym.recordings import Recording
from ffgym.recordings.metrics import motor_error
from ffgym.report.figure import house_style, legend_above, new_figure
from ffgym.report.laws import LawStyle, baseline_of, compensated, law_styles
from ffgym.studies import OneAxisStudy
from ffgym.studies.one_axis import SETTLED

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHOWN = 2.0
"""Length of the stretch that is drawn [s], after the start has settled."""


def one_axis_figure(study: OneAxisStudy, frequency: float) -> "Figure":
    """Three rows (speed, error, feedback torque), one column per law that compensates, at `frequency` [Hz]."""
    laws = [law for law, f in study.recordings if f == frequency]
    styles, columns = law_styles(laws), compensated(laws)
    before = baseline_of(laws)
    with house_style():
        figure = new_figure(max(4.6 * len(columns), 5.0), 6.2)
        grid = figure.subplots(3, len(columns), squeeze=False, sharex=True, sharey="row")
        for j, law in enumerate(columns):
            for name in dict.fromkeys((before, law)):
                _draw([grid[i][j] for i in range(3)], study.recordings[name, frequency], styles[name])
            grid[0][j].set_title(f"{styles[law].label}, {frequency:g} Hz")
            grid[2][j].set_xlabel("time [s]")
        for row, label in zip(grid, ("motor speed [rad/s]", "motor error [mrad]", "feedback $u_c$ [N m]"), strict=True):
            row[0].set_ylabel(label)
        handles = {
            label: line for axes in grid[0] for line, label in zip(*axes.get_legend_handles_labels(), strict=True)
        }
        legend_above(figure, list(handles.values()), list(handles))
        figure.align_ylabels()
    return figure


def one_axis_caption(study: OneAxisStudy, frequency: float) -> str:
    """What the figure shows, with error and what of it is gone."""
    results = [result for result in study.results if result.frequency_hz == frequency]
    styles = law_styles(result.agent for result in results)
    before = baseline_of([result.agent for result in results])
    values = "; ".join(
        f"{styles[result.agent].label} {result.motor_rms_rad * 1e3:.2f} mrad"
        + ("" if result.agent == before else f" ({abs(result.reduction):.1%} {_way(result.reduction)})")
        for result in results
    )
    return (
        f"One axis following a sine of {frequency:g} Hz, {SHOWN:g} s after the start has settled: speed, motor "
        f"position error and feedback torque, before ({styles[before].label}) and after. RMS motor error: {values}."
    )


def _way(reduction: float) -> str:
    return "less" if reduction >= 0 else "more"


def _draw(column: "list[Axes]", recording: Recording, style: LawStyle) -> None:
    rows = (recording.t >= SETTLED) & (recording.t <= SETTLED + SHOWN)
    signals: tuple[Array, ...] = (
        recording.joint_array("motor.velocity")[:, 0],
        motor_error(recording)[:, 0] * 1e3,
        recording.joint_array("feedback.effort")[:, 0],
    )
    for axes, signal in zip(column, signals, strict=True):
        axes.plot(recording.t[rows], signal[rows], color=style.colour, linestyle=style.line, label=style.label)
        axes.set_xlim(SETTLED, SETTLED + SHOWN)
