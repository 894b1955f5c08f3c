"""`ffgym train bspline` and `stability`: B-spline networks, learned trial by trial, and how fast they may learn."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ffgym.agents.bspline import BSplineNetwork, ExtendedBSN, StaticBSN
from ffgym.agents.changing_motions import TRIALS, ChangingMotions
from ffgym.agents.coulomb_prior import CoulombPrior
from ffgym.agents.law_files import save_law
from ffgym.agents.lffc import LFFC, Learning, check_rate, relative, robot_seconds, thesis_training
from ffgym.agents.spline_basis import SplineBasis
from ffgym.agents.stability import MOST_ITERATIONS, STABLE_GROWTH, LearningStability, learning_curves
from ffgym.agents.tensor_bspline import TensorBSN, even_positions
from ffgym.agents.trials import RigTrial, SimulatedTrial, training_motions
from ffgym.cli.learning_options import BSpline, NetworkOptions, Stability
from ffgym.cli.outputs import claim_outputs, given_options, print_places, provenance, write_numbers
from ffgym.cli.progress import progress_bar
from ffgym.core.effort import announce
from ffgym.core.errors import FFGymError, check_choice, check_whole
from ffgym.core.types import Array
from ffgym.envs.machines import is_workcell, load_described_robot, make_rig
from ffgym.paths import Reference
from ffgym.report import check_figure, save_figure
from ffgym.report.learning_plots import learning_figure
from ffgym.robot import RigidArm, RobotDescription

NETWORKS: dict[str, type[StaticBSN] | type[ExtendedBSN]] = {"static": StaticBSN, "extended": ExtendedBSN}
"""Networks over speed alone by the word for them on the command line."""


def make_network(config: NetworkOptions, motions: Sequence[Reference], order: int = 2, **fields: Any) -> BSplineNetwork:
    """Make the network of the options with zero weights; `fields` has other fields of it.

    Raises:
        FFGymError: if an option has no effect, or there is no motion.
    """
    if not motions:
        raise FFGymError("There is no motion to learn on; give one frequency or more.")
    fields["normalised"], basis = not config.unnormalised, SplineBasis(order=order)
    if config.network == "tensor":
        positions = even_positions(config.position_knots, order)
        return TensorBSN.along(motions, basis, positions, **fields)
    if given := given_options(config, ("position_knots",)):
        raise FFGymError(f"{given[0]} has no effect on the {config.network} network, only on tensor. Leave it out.")
    return NETWORKS[config.network].zero(motions[0].robot.n_joints, basis, **fields)


def motions_of(config: NetworkOptions, arm: RigidArm) -> list[Reference]:
    """Motions of one trial.

    Raises:
        FFGymError: if an option says nothing about this robot, or there is no such motion.
    """
    names = ("positions", "speeds_mm_s") if arm.robot.work_area is None else ("frequencies_hz",)
    if given := given_options(config, names):
        runs = "sines, having no work area" if arm.robot.work_area is None else "circles in its work area"
        raise FFGymError(f"{', '.join(given)} has no effect: robot {arm.robot.name!r} runs {runs}. Leave it out.")
    speeds = [speed / 1e3 for speed in config.speeds_mm_s]
    return training_motions(arm, config.positions, speeds, config.frequencies_hz)


def _rate_and_iterations(config: NetworkOptions, robot: RobotDescription) -> tuple[float, int]:
    """Learning rate and updates, those of the thesis where none are given.

    Raises:
        FFGymError: if the thesis has no rate for the update.
    """
    if config.unnormalised and config.gamma is None:
        raise FFGymError(
            "--unnormalised needs --gamma: sums over all samples move weights by far more than their mean does; "
            "ffgym train stability --unnormalised --gamma 0.001 says which rates are stable."
        )
    usual = thesis_training(robot.n_joints)
    return (
        usual.rate if config.gamma is None else config.gamma,
        usual.iterations if config.iterations is None else config.iterations,
    )


def bspline(config: BSpline) -> None:
    """Learn, write, print."""
    if not is_workcell(config.robot) and (given := given_options(config, ("seed",))):
        raise FFGymError(f"{given[0]} has no effect on {config.robot}: only a workcell's sensors are random.")
    claim_outputs({"--out": config.out, "--json": config.json}, suffix=".npz")
    state = config.out.with_suffix(".state.npz")  # what is kept between trials, beside the law
    if state.exists() and not config.resume:
        raise FFGymError(f"{state}: holds a training that was interrupted; go on with it by --resume, or delete it.")
    # robot, its training motions, and a trial that runs them
    rig = make_rig(config.robot)
    robot, motions, record_dt = rig.robot, motions_of(config, rig.arm), config.record_dt_ms / 1e3
    trial = RigTrial(rig=rig, seed=config.seed, record_dt=record_dt, n_threads=config.threads)
    # network before learning: zero, or the Coulomb friction that one trial shows
    first = make_network(config, motions, config.order, name=config.out.stem)
    if config.prior:
        first = first.with_curve(CoulombPrior.from_trial(motions, trial).torque_at)
    # learning rate, and a warning where it makes the iteration unstable
    rate, iterations = _rate_and_iterations(config, robot)
    procedure = LFFC(rate=rate, iterations=iterations, signal=config.signal)
    study = LearningStability.of(first, rig.arm, motions, signal=config.signal, record_dt=record_dt)
    if (warning := study.warning(rate)) is not None:  # training goes on, and keeps its best trial
        print(f"ffgym: warning: {warning}", file=sys.stderr)
    with progress_bar("learning", "trials") as progress:
        learning = procedure.learn(
            first,
            motions,
            trial,
            state=state,
            machine=f"{rig.fingerprint}, rows every {config.record_dt_ms:g} ms",
            watch=lambda learning, total: progress(learning.trials, total),
        )
    # nothing is random but the sensors of a workcell
    seed, trials = config.seed if is_workcell(config.robot) else None, learning.trials + config.prior
    info = provenance("ffgym train bspline", config, robot.name, rig.fingerprint, seed)
    info |= {
        "learning": asdict(procedure),
        "motions": [motion.name for motion in motions],
        "trials": trials,
        "robot_seconds": robot_seconds(motions, trials),
        "mean_square_error_rad2": learning.error.tolist(),
        "mean_square_signal": learning.signal.tolist(),
        "best_trial": learning.best_trial.tolist(),
        "locked": learning.locked.tolist(),
    }
    # law first, then the state is of no further use
    save_law(config.out, learning.best, meta=info)
    write_numbers(config, info)
    state.unlink(missing_ok=True)
    print(learning_table(learning, robot.joints))
    print(f"{trials} trials, {info['robot_seconds']:.0f} s of robot time")
    print_places(law=config.out, numbers=config.json)


def stability(config: Stability) -> None:
    """Predict, print, and maybe simulate and draw."""
    if config.figure is not None:
        check_figure(config.figure)
        claim_outputs({"--figure": config.figure})
        for rate in config.figure_rates:
            check_rate("figure rate", rate)
        if not config.figure_rates or np.any(np.diff(config.figure_rates) <= 0):
            raise FFGymError(f"figure rates = {list(config.figure_rates)} must be one or more, ascending.")
    arm, record_dt = RigidArm(load_described_robot(config.robot)), config.record_dt_ms / 1e3
    for joint in config.figure_joints:
        check_choice("joint", joint, arm.robot.joints)
    rate, iterations = _rate_and_iterations(config, arm.robot)
    rate = check_rate("gamma", rate)
    iterations = check_whole("iterations", iterations, low=0, high=MOST_ITERATIONS)
    motions = motions_of(config, arm)
    network = make_network(config, motions)
    if config.figure is not None:
        announce(len(config.figure_rates) * (iterations + 1) * motions[0].duration, "run")
    groups = [[motion] for motion in motions] + ([motions] if len(motions) > 1 else [])
    for group in groups:
        study = LearningStability.of(network, arm, group, signal=config.signal, record_dt=record_dt)
        print(f"{' + '.join(motion.name for motion in group)}\n{stability_table(study, rate, iterations)}")
        verdict = study.warning(rate) or f"{rate:g} is stable on every joint"
        print(f"{verdict[0].upper()}{verdict[1:]}.\n")
    if config.changing:
        changing = ChangingMotions.of(network, arm, motions, signal=config.signal, record_dt=record_dt)
        print(f"another of these motions in each trial\n{changing_table(changing, motions, rate)}\n")
    if config.figure is not None:
        _draw(config, network, arm, motions[0], iterations)


def _draw(config: Stability, network: BSplineNetwork, arm: RigidArm, motion: Reference, iterations: int) -> None:
    """Simulate learning along a motion, and draw it beside the prediction."""
    assert config.figure is not None
    trial = SimulatedTrial(arm=arm, record_dt=config.record_dt_ms / 1e3, n_threads=config.threads)
    curves = learning_curves(network, trial, motion, config.figure_rates, iterations, signal=config.signal)
    shown = [joint in (config.figure_joints or arm.robot.joints) for joint in arm.robot.joints]
    curves = [each for each, wanted in zip(curves, shown, strict=True) if wanted]
    drawn = learning_figure(curves)
    save_figure(drawn.figure, config.figure)
    print(f"{drawn.caption}\nfigure: {config.figure}")


def learning_table(learning: Learning, joints: tuple[str, ...]) -> str:
    """Relative mean squares per trial and joint as text; the best trial of a joint has a star."""
    width = max(9, *(len(joint) for joint in joints))

    def rows(title: str, values: Array) -> list[str]:
        head = [title, "trial" + "".join(joint.rjust(width + 1) for joint in joints)]
        for k, row in enumerate(values):
            marks = ["*" if k == best else " " for best in learning.best_trial]
            head.append(f"{k:5d}" + "".join(f"{x:{width}.4f}{m}" for x, m in zip(row, marks, strict=True)))
        return head

    done = [joint for joint, locked in zip(joints, learning.locked, strict=True) if locked]
    lines = [
        *rows("mean square of the motor error, trial 0 is 1", relative(learning.error)),
        "",
        *rows("mean square of the learning signal, trial 0 is 1", relative(learning.signal)),
        "",
        f"* weights kept. Done before the end: {', '.join(done) or 'no joint'}.",
    ]
    return "\n".join(lines)


def changing_table(study: ChangingMotions, motions: Sequence[Reference], rate: float) -> str:
    """Growth per trial where each runs another motion, per joint, and the orders that grow most, as text."""
    worst, orders = study.worst(rate)
    rows = {
        "largest rate that no order makes grow": study.safe_rate,
        f"growth per trial at {rate:g}, at most": study.bound(rate),
        "worst order found, repeated": worst,
        f"drawn order of {TRIALS} trials": study.drawn(rate, np.random.default_rng(0)),
    }
    grown = [
        f"{joint}: {'; '.join(motions[motion].name for motion in order)}"
        for joint, growth, order in zip(study.joints, worst, orders, strict=True)
        if growth > STABLE_GROWTH
    ]
    return "\n".join([_rows(study.joints, rows), *(f"grows on {line}" for line in grown)])


def _number(value: float) -> str:
    """A number in 9 places; small ones, as rates of sums over many samples are, with three digits."""
    return f"{value:9.3f}" if value >= 0.01 or value == 0 else f"{value:9.2g}"


def stability_table(study: LearningStability, rate: float, iterations: int) -> str:
    """Largest stable rates, growth at `rate`, and friction's share in the signal that is left, per joint, as text."""
    mean_squares = study.mean_squares(rate, iterations)
    left = np.sqrt(mean_squares[-1] / mean_squares[0])
    rows = {
        "largest stable learning rate": study.largest_rate,
        f"growth per iteration at {rate:g}": study.growth(rate),
        f"friction left after {iterations} (RMS)": left,
    }
    return _rows(study.joints, rows)


def _rows(joints: Sequence[str], rows: Mapping[str, Array]) -> str:
    """Rows of numbers by name under the names of the joints, as text."""
    width = max(map(len, rows))
    lines = [" " * width + "".join(joint.rjust(9) for joint in joints)]
    lines += [name.ljust(width) + "".join(map(_number, values)) for name, values in rows.items()]
    return "\n".join(lines)
