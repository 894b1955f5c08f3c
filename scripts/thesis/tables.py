"""Tables of the reproduction: path errors beside published ones, parameters, records, agents and networks."""

from typing import Any

import numpy as np

from ffgym.agents.catalogue import CATALOGUE
from ffgym.core.types import Array
from ffgym.diagnosis.identification.bristle_fit import NAMES
from ffgym.paths import SPEEDS
from ffgym.published import ESTIMATION_RECORDS, FRICTION_RECORDS
from ffgym.report import SpeedTable, Table, circle_tables, law_styles
from ffgym.report.circles.comparison import percent
from scripts.thesis.measures import gone, path, static_of
from scripts.thesis.narx import ESTIMATION, VALIDATION, NarxFit, record_name
from scripts.thesis.studies import IDENTIFIED, ThesisStudies

VALIDATING = [each.number for each in FRICTION_RECORDS if each.number not in ESTIMATION_RECORDS]
"""Set V of thesis 6.1.2."""
OLD = "lugre_dynamic"
"""Dynamic LuGre with the parameters that the controller's model carries."""


def circles(studies: ThesisStudies, of: str, speed: float) -> list[SpeedTable]:
    """Path errors beside published ones at one speed."""
    return circle_tables(getattr(studies, of).only(speeds=[speed]))


def network_circles(studies: ThesisStudies, of: str, speed: float) -> list[SpeedTable]:
    """The same of both networks and no compensation."""
    laws = ["none", "bsn_static", "bsn_extended"]
    return circle_tables(getattr(studies, of).only(laws=laws, speeds=[speed]))


def parameters(studies: ThesisStudies) -> Table:
    """The six parameters of joint 1: published, identified, before."""
    measured, thesis = studies.joint_1, studies.axis.friction  # the one axis carries (6.9) and (6.18)
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
    return Table.of_rows(
        headings=("parameter", "thesis, real robot", "workcell", "90 % interval", "before", "status"),
        rows=rows,
        note="The workcell was made with the thesis' values and errs beyond the LuGre model, so that near is by "
        "construction and exact is not to be expected. A parameter that is not identified keeps its value.",
    )


def records(studies: ThesisStudies) -> Table:
    """The fifteen records, and what both models leave of them."""
    after, before = (studies.joint_1.errors_of(model) for model in ("identified", "original"))
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
    return Table.of_rows(
        headings=("record", "A [rad/s]", "f [Hz]", "set", "RMS friction [N m]", "original [N m]", "identified [N m]"),
        rows=rows,
        note="RMS errors of the dynamic LuGre model. Record 11 is printed with A = 5, as record 6; by the pattern "
        "of the table and Figure 6.5e it is 10.",
    )


def mean_rms(studies: ThesisStudies) -> dict[str, list[float]]:
    """Mean RMS path error [mm] of every agent over the 12 circles at each speed, by law."""
    return {
        each.law.name: [path(studies, "all_circles", each.law.name, speed=speed) or 0.0 for speed in SPEEDS]
        for each in studies.contenders
    }


def agents(studies: ThesisStudies) -> Table:
    """List what each agent may know, how much it tried, and its mean path errors."""
    errors = mean_rms(studies)

    def error(value: float, without: float) -> str:
        """An error [mm] in micrometres, and how it compares to that without compensation."""
        return f"{value * 1e3:.4g}" + ("" if value == without else f" ({percent(1 - value / without)})")

    rows = tuple(
        (
            each.entry.title,
            each.entry.track,
            f"{each.trials}",
            f"{each.robot_seconds:.0f}",
            *map(error, errors[each.law.name], errors["none"]),
        )
        for each in studies.contenders
    )
    missing = [f"{entry.title} ({entry.package})" for entry in CATALOGUE.values() if not entry.is_available]
    left_out = f" Left out, as a package is not installed: {', '.join(missing)}." if missing else ""
    return Table.of_rows(
        headings=(
            *("law", "what it may know", "trials", "robot time [s]"),
            *(f"{speed * 1e3:g} mm/s [µm]" for speed in SPEEDS),
        ),
        rows=rows,
        note="Mean RMS path error over 3 radii and 4 positions, nominal robot; in brackets against none. "
        "Trials are those that a law learned from; one may run several motions. The oracle knows the machine's "
        "true parameters, which are the nominal ones here, and is not ranked. Laws that learn, but not per task, "
        "were trained at p1: the circles at p1, which they learned on, are among those that are scored; p2 to p4 "
        "are held out. Laws per task learned on every circle that is scored, and begin with laws of nominal "
        f"parameters.{left_out}",
    )


def other_speeds(studies: ThesisStudies) -> Table:
    """Mean path errors and motor errors that are gone, of networks by the speed of their training and of their use."""
    trained = {SPEEDS[0]: "bsn_circles", SPEEDS[1]: "networks_of_40", SPEEDS[2]: "networks_of_100"}
    rows = [("no compensation", *(f"{path(studies, 'bsn_circles', 'none', speed=speed):.4f}" for speed in SPEEDS))]
    for law in ("bsn_static", "bsn_extended"):
        label = law_styles([law])[law].label
        for at, of in trained.items():
            cells = [
                f"{path(studies, of, law, speed=speed):.4f} ({percent(gone(studies, of, law, 'motor', speed=speed))})"
                for speed in SPEEDS
            ]
            rows.append((f"{label}, trained at {at * 1e3:g} mm/s", *cells))
    return Table.of_rows(
        headings=("network", *(f"used at {speed * 1e3:g} mm/s [mm]" for speed in SPEEDS)),
        rows=tuple(rows),
        note="Mean RMS path error over 3 radii and 4 positions, nominal robot; in brackets the change of the RMS motor "
        "error against none, mean over joints and positions. All were trained at p1.",
    )


def networks(studies: ThesisStudies) -> Table:
    """Fits of every NARX network, of linear models, and of the static curve."""
    floor = {name: fit_of_static(studies, name) for name in (ESTIMATION, VALIDATION, *map(record_name, VALIDATING))}
    on_v = [floor[record_name(number)] for number in VALIDATING]
    sines = (floor[ESTIMATION], floor[VALIDATION])
    static = [*map(write_fit, sines), "", write_fit(float(np.median(on_v))), write_fit(min(on_v))]
    fits = (studies.narx_published | studies.narx_extended | studies.narx_linear).values()
    return Table.of_rows(
        headings=(
            "model",
            f"{ESTIMATION} [%]",
            f"{VALIDATION} [%]",
            f"{VALIDATION}, one step [%]",
            "set V, median [%]",
            "set V, worst record [%]",
        ),
        rows=(*((fit.candidate.label, *map(spread, columns_of(fit))) for fit in fits), ("static curve", *static)),
        note="Fit, in free run but where it says one step: median of random starts (least to most); a linear model has "
        "one. All are fitted to A = 1, f = 1, or where it says so to set D, records 2, 4, 7, 9, 12 and 14 of Table "
        "6.1; set V is its other records.",
    )


def columns_of(fit: NarxFit) -> list[Array]:
    """Fits [%] of each start: estimation, validation, one step ahead, median and worst record of set V, (S,) each."""
    on_v = np.stack([fit.errors[record_name(number)].simulation.fit for number in VALIDATING])
    sines = [fit.errors[name].simulation.fit for name in (ESTIMATION, VALIDATION)]
    return [*sines, fit.errors[VALIDATION].prediction.fit, np.median(on_v, axis=0), on_v.min(axis=0)]


def fit_of_static(studies: ThesisStudies, record: str) -> float:
    """Fit of the static curve to a record [%]."""
    return float(static_of(studies, record).fit[0])


def spread(values: Array) -> str:
    """Write the median, the least and the most of fits [%]; of one fit itself."""
    if len(values) == 1:
        return write_fit(values[0])
    return f"{write_fit(np.median(values))} ({write_fit(values.min())} to {write_fit(values.max())})"


def write_fit(fit: float) -> str:
    """Write a fit [%] by the digits that any processor finds: rounding decides how far a model runs away."""
    if fit > 99.0:
        return f"{fit:.1f}"
    coarse = round(fit, 1 - int(np.log10(-fit))) if fit < -100.0 else round(fit)
    return f"{coarse:.0f}" if coarse else "0"


def list_reidentified(studies: ThesisStudies, of: str) -> Table:
    """Mean path errors with old and with identified parameters."""
    study = getattr(studies, of)
    rows = []
    for speed in dict.fromkeys(key[2] for key in study.recordings):
        cells = {law: study.only(laws=[law], speeds=[speed]).cells for law in ("none", OLD, IDENTIFIED)}
        better = [new.rms_mm < old.rms_mm for new, old in zip(cells[IDENTIFIED], cells[OLD], strict=True)]
        means = [f"{np.mean([cell.rms_mm for cell in each]):.4f}" for each in cells.values()]
        less = percent(gone(studies, of, IDENTIFIED, than=OLD, speed=speed))
        rows.append((f"{speed * 1e3:g} mm/s", *means, less, f"{sum(better)} of {len(better)}"))
    return Table.of_rows(
        headings=("", "none [mm]", "old [mm]", "identified [mm]", "identified against old", "circles with less"),
        rows=tuple(rows),
        note="Mean RMS path error of dynamic LuGre over 3 radii and 4 positions, workcell.",
    )


def old_and_identified(studies: ThesisStudies) -> Table:
    """Parameters of all joints of the workcell."""
    found = studies.all_joints.found
    names = [estimate.name.removeprefix("friction.").replace("_", " ") for estimate in found.joints[0].estimates]

    def change(each: Any) -> str:
        return f"{each.prior:.3g} → {each.value:.3g}{'' if each.is_identified else ' *'}"

    return Table.of_rows(
        headings=("joint", *names),
        rows=tuple((joint.joint, *map(change, joint.estimates)) for joint in found.joints),
        note="Old → identified, motor side, SI units. "
        "* not identified: the data do not tell it, and it keeps its value.",
    )
