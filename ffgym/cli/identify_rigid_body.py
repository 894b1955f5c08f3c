"""Masses, rotors and friction for `ffgym identify`."""

from typing import TYPE_CHECKING

from ffgym.cli.identify_logs import LogSet
from ffgym.cli.identify_outcome import Outcome
from ffgym.cli.progress import progress_bar
from ffgym.core.errors import check_number
from ffgym.diagnosis.identification import LowPass
from ffgym.diagnosis.identification.rigid_body import Filtering, RigidBodyOptions, identify_rigid_body, starting_robot
from ffgym.robot import RobotDraft

if TYPE_CHECKING:
    from ffgym.cli.identify import Identify


def identified_rigid_body(config: "Identify", draft: RobotDraft, logs: LogSet) -> Outcome:
    """Identify bodies, rotors and friction from logs, and see how well they predict those kept out.

    Args:
        config: the command.
        draft: the description; where it lacks masses, they are stood in for.
        logs: recordings.
    """
    from ffgym.report.identification import (
        RigidBodyReport,
        format_rigid_body,
        render_rigid_body_page,
        rigid_body_numbers,
    )

    options = _options(config)
    robot = starting_robot(draft, logs.used, options.filtering) if draft.missing else logs.robot
    with progress_bar("identifying", "resamples") as progress:
        fit = identify_rigid_body(robot, logs.used, options, progress)
    report = RigidBodyReport(fit=fit, held_out=logs.held_out, doubts_of_logs=logs.doubts)
    return Outcome(
        title=f"Rigid body of {robot.title}, identified",
        text=format_rigid_body(report),
        quantities=fit.quantities,
        numbers=rigid_body_numbers(report),
        page=lambda origin: render_rigid_body_page(report, logs.used[0], origin),
    )


def _options(config: "Identify") -> RigidBodyOptions:
    """Options of the command; what it leaves open is the default."""
    filtering, default = Filtering(), RigidBodyOptions()
    if config.cutoff_hz is not None:
        cutoff = check_number("--cutoff-hz", config.cutoff_hz, unit="Hz", low=0.0, open_low=True)
        filtering = Filtering(parallel=LowPass(cutoff=cutoff, order=filtering.parallel.order))
    return RigidBodyOptions(
        terms=config.terms or default.terms,
        filtering=filtering,
        spread=config.spread,
        resamples=config.resamples,
        level=config.level,
        seed=config.seed,
    )
