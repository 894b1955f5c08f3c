"""Recorded machines beside predictions: docs/torque_prediction.md, rigid_body_identification.md and diagnosis.md.

The first two read published recordings, which are not part of the package and lie where FFGYM_DATA says. Of the KUKA
KR 300 the authors identified friction and payload from run A; run C is one of their validation runs.
"""

import os
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.identification.rigid_body import Filtering, RigidBodyFit, RigidBodyOptions, identify_rigid_body
from ffgym.diagnosis.identification.rigid_body.terms import DEFAULT_TERMS
from ffgym.diagnosis.nominal import EXAMPLE_ROBOT, example_logs
from ffgym.diagnosis.procedure import examine
from ffgym.diagnosis.regimes import collect_rows, map_by_regime
from ffgym.diagnosis.residual import Residual
from ffgym.logs import read_log
from ffgym.logs.preparation import LowPass
from ffgym.published import EMPS_ASYMMETRIC, EMPS_SYMMETRIC, KR300_FRICTION, EmpsModel
from ffgym.recordings import Recording
from ffgym.report.diagnosis.evidence import profiles_figure
from ffgym.report.diagnosis.maps import map_figure
from ffgym.report.diagnosis.words import by_model
from ffgym.report.identification.plots import torque_figure
from ffgym.robot import RobotDescription, compile_model, load_robot, physics_fingerprint
from ffgym.studies.torque_prediction import CUTOFF, MOVING, TorquePrediction, predict_torque
from scripts.tables.page import Contents, markdown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DATA_VARIABLE = "FFGYM_DATA"
"""Environment variable with the folder of published recordings."""

AUTHORS_FILTERING = Filtering(motion=LowPass(cutoff=100.0, order=4), parallel=LowPass(cutoff=40.0, order=4), moving=0.0)
"""Filters as in the EMPS scripts: position at 100 Hz, both sides below 40 Hz, every tenth row; standstill counts,
too."""
ASYMMETRIC_TERMS = (*DEFAULT_TERMS, "viscous_asymmetry")
RESAMPLES = RigidBodyOptions().resamples
"""Bootstrap resamples of the tables; tests take fewer."""
NEAR_CAD = 0.03
"""Spread [1] of masses that are believed: CAD masses of a machine that was built from them."""
SPREADS_OF_MASSES: Mapping[str, float | None] = {"near CAD": NEAR_CAD, "free": None}
"""Spreads of masses by name; None is chosen from the fitted run."""


def measure(machine: str, file: str) -> Recording:
    """A published recording, e.g. of the 'emps' its file 'emps_id', of the 'kuka_kr300_2020' its run 'A'.

    Raises:
        FFGymError: if the environment variable is not set, or leads to no folder.
    """
    folder = os.environ.get(DATA_VARIABLE, "")
    if not folder or not Path(folder).is_dir():
        raise FFGymError(f"{DATA_VARIABLE} = {folder!r} must be the folder with the published recordings.")
    return read_log(Path(folder) / machine / f"{file}.npz", machine)


# ---- predicted torque of the KR 300; nothing is fitted


def torques(runs: tuple[str, ...] = ("A", "C"), cutoff: float = CUTOFF) -> Contents:
    """Predicted beside measured motor torque of runs; motor angles are filtered below the cut-off [Hz]."""
    predictions = {run: torque_of(run, cutoff) for run in runs}
    numbers = {
        run: {
            "config": {"run": run, "cutoff_hz": cutoff, "moving_rad_s": MOVING},
            "physics_fingerprint": physics_fingerprint(compile_model(each.robot)),
            "errors_nm": {name: [asdict(error) for error in each.errors(name)] for name in each.predicted},
        }
        for run, each in predictions.items()
    }
    return Contents(
        parts={f"run {run}": torque_table(each) for run, each in predictions.items()},
        numbers=numbers,
        pictures={f"torque_{run}": torque_figure(each) for run, each in predictions.items()},
    )


def torque_of(run: str, cutoff: float = CUTOFF) -> TorquePrediction:
    """Predictions of the motor torque of a run."""
    recording = measure("kuka_kr300_2020", run)
    return predict_torque(load_robot(recording.header.robot), recording, KR300_FRICTION, cutoff)


def torque_table(prediction: TorquePrediction) -> str:
    """Measured torque and errors, motor side [N m], one row per joint."""
    rows = []
    for errors in zip(*(prediction.errors(name) for name in prediction.predicted), strict=True):
        cells = [f"{e.rms_error:.2f}, {e.share:.0%}, {e.max_error:.2f}" for e in errors]
        rows.append((errors[0].joint, f"{errors[0].rms_measured:.2f}", *cells))
    return markdown(("joint", "measured RMS", *prediction.predicted), rows)


# ---- rigid bodies: the EMPS axis, and the KR 300 fitted to run A near its description


def rigid_bodies() -> Contents:
    """Rigid-body identification of two recorded machines beside what was published of them."""
    fits = emps_fits(measure("emps", "emps_id"))
    run_a, run_c = (measure("kuka_kr300_2020", run) for run in ("A", "C"))
    return Contents(
        parts={
            "emps": _emps_table(fits),
            "kr300": _kr300_table(kr300_fits(run_a), run_c),
            "spring": _spring_table(spring_fits(run_a), run_c),
        },
        numbers={"emps": {name: asdict(model_of(fit)) for name, fit in fits.items()}},
    )


def doubtful_axis() -> RobotDescription:
    """The ball-screw axis as someone describes it who does not know the published numbers: none of them is in it."""
    robot = load_robot("ball_screw")
    friction = robot.friction.scale(coulomb=2.0, static=2.0, viscous=0.5)
    bodies = replace(robot.bodies, mass=2.0 * robot.bodies.mass)
    return replace(robot, bodies=bodies, friction=friction)


def emps_fits(recording: Recording, resamples: int = RESAMPLES) -> dict[str, RigidBodyFit]:
    """Both models of the authors, from a description that is off by half."""
    robot, options = doubtful_axis(), RigidBodyOptions(filtering=AUTHORS_FILTERING, resamples=resamples)
    return {
        "symmetric": identify_rigid_body(robot, [recording], options),
        "asymmetric": identify_rigid_body(robot, [recording], replace(options, terms=ASYMMETRIC_TERMS)),
    }


def model_of(fit: RigidBodyFit) -> EmpsModel:
    """Parameters of the axis behind the screw, as the authors name them."""
    ratio = float(fit.robot.drive.gear_ratio[0])
    coulomb, offset = ratio * fit.of("coulomb.x"), ratio * fit.of("offset.x")
    viscous = ratio**2 * fit.of("viscous.x")
    half = ratio**2 * fit.of("viscous_asymmetry.x") if "viscous_asymmetry.x" in fit.labels else 0.0
    return EmpsModel(
        mass=float(fit.base.values(fit.estimate)[0]),
        viscous=(viscous + half, viscous - half),
        coulomb=(coulomb + offset, coulomb - offset),
    )


def numbers_of(model: EmpsModel) -> dict[str, float]:
    """Parameters by name, forwards and backwards."""
    return {
        "M [kg]": model.mass,
        "F_v forwards [N s/m]": model.viscous[0],
        "F_v backwards [N s/m]": model.viscous[1],
        "F_c forwards [N]": model.coulomb[0],
        "F_c backwards [N]": model.coulomb[1],
    }


def _emps_table(fits: Mapping[str, RigidBodyFit]) -> str:
    """Numbers of the authors' scripts and those found, and what is left of the force."""
    rows = []
    for name, published in (("symmetric", EMPS_SYMMETRIC), ("asymmetric", EMPS_ASYMMETRIC)):
        found = numbers_of(model_of(fits[name]))
        for parameter, value in numbers_of(published).items():
            change = found[parameter] / value - 1
            rows.append((name, parameter, f"{value:.4f}", f"{found[parameter]:.4f}", f"{change:+.2%}"))
        left = float(fits[name].errors.identified[0] * fits[name].robot.drive.gear_ratio[0])
        rows.append((name, "left of the force, RMS [N]", "", f"{left:.2f}", ""))
    return markdown(("model", "parameter", "authors' script", "found", "difference"), rows)


def kr300_fits(run: Recording, resamples: int = RESAMPLES) -> dict[str, RigidBodyFit]:
    """Masses, rotors, friction and offsets: with masses that are believed, and as far from them as predicts best."""
    robot = load_robot("kuka_kr300_r2500")
    return {
        masses: identify_rigid_body(robot, [run], RigidBodyOptions(spread=spread, resamples=resamples))
        for masses, spread in SPREADS_OF_MASSES.items()
    }


def _kr300_table(fits: Mapping[str, RigidBodyFit], run: Recording) -> str:
    """RMS errors on a run that was not fitted, axis by axis, motor side [N m].

    Those called unfiltered are as docs/torque_prediction.md has them: against the torque as it was measured.
    """
    errors = {name: fit.validate([run]) for name, fit in fits.items()}
    robot = next(iter(fits.values())).robot
    robots = {"description": robot} | {name: fit.identified for name, fit in fits.items()}
    raw = {
        name: [error.rms_error for error in predict_torque(each, run).errors("description")]
        for name, each in robots.items()
    }
    heads = [f"{name} ({fit.trade_off.chosen:g}){file}" for name, fit in fits.items() for file in ("", ", file")]
    rows = []
    for j, joint in enumerate(robot.joints):
        cells = [errors["near CAD"].measured[j], errors["near CAD"].described[j]]
        cells += [value[j] for e in errors.values() for value in (e.identified, e.in_file)]
        cells += [values[j] for values in raw.values()]
        rows.append((joint, *(f"{cell:.2f}" for cell in cells)))
    return markdown(("axis", "measured", "description", *heads, *(f"unfiltered: {name}" for name in raw)), rows)


def spring_fits(
    run: Recording, resamples: int = RESAMPLES, spreads: Mapping[str, float | None] = SPREADS_OF_MASSES
) -> dict[str, RigidBodyFit]:
    """Two explanations of what axis 2 carries, by how far masses may be from the description."""
    robot = load_robot("kuka_kr300_r2500")
    models = {"no spring": replace(robot, springs=()), "factor on the spring": robot}
    fits = {}
    for model, described in models.items():
        terms = (*DEFAULT_TERMS, "springs") if described.springs else DEFAULT_TERMS
        for masses, spread in spreads.items():
            options = RigidBodyOptions(terms=terms, spread=spread, resamples=resamples)
            fits[f"{model}, masses {masses}"] = identify_rigid_body(described, [run], options)
    return fits


def _spring_table(fits: Mapping[str, RigidBodyFit], run: Recording) -> str:
    """RMS error of axis 2 behind the gearbox on the fitted run and on another, and the factor on the spring."""
    rows = []
    for name, fit in fits.items():
        ratio = float(np.abs(fit.robot.drive.gear_ratio[1]))
        fitted, other = (ratio * float(errors.identified[1]) for errors in (fit.errors, fit.validate([run])))
        factor = ""
        if "springs.counterbalance" in fit.labels:
            i = fit.labels.index("springs.counterbalance")
            factor = f"{fit.estimate[i]:.2f} ({fit.intervals.low[i]:.2f} to {fit.intervals.high[i]:.2f})"
        rows.append((name, f"{fit.trade_off.chosen:g}", f"{fitted:.0f}", f"{other:.0f}", factor))
    return markdown(("model", "spread of masses", "run A [N m]", "run C [N m]", "factor (90 %)"), rows)


# ---- pictures of the example logs


def diagnosis() -> Contents:
    """Diagnose the example logs: where their model is wrong before and after."""
    examined = examine(load_robot(EXAMPLE_ROBOT), example_logs())
    assert examined.before is not None
    return Contents(pictures=diagnosis_pictures(examined.before, examined.after))


def diagnosis_pictures(before: Residual, after: Residual | None) -> dict[str, "Figure"]:
    """Residuals of torque by regime, and those of joint 2, which stand out most, over what they may depend on."""
    models = by_model(before, after)
    rows = {name: collect_rows(one, "torque") for name, one in models.items()}
    depends = profiles_figure(rows, "torque", 1, 1)
    assert depends is not None
    regimes = map_figure([[(name, map_by_regime(one, "torque"))] for name, one in models.items()])
    return {"diagnosis_regimes": regimes, "diagnosis_depends": depends}
