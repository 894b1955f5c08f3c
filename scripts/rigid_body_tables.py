"""Rigid-body identification of two recorded machines beside what was published of them.

python -m scripts.rigid_body_tables --write docs/rigid_body_identification.md

reads the published recordings of the EMPS axis and of the KUKA KR 300 (folder in the environment variable FFGYM_DATA).
The KR 300 is fitted to run A, near its description; run C is only predicted, and the page says what was known of it.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
import tyro

from ffgym.core.files import check_writable, read_text, write_json, write_text
from ffgym.core.provenance import versions
from ffgym.diagnosis.identification import LowPass
from ffgym.diagnosis.identification.rigid_body import Filtering, RigidBodyFit, RigidBodyOptions, identify_rigid_body
from ffgym.diagnosis.identification.rigid_body.terms import DEFAULT_TERMS
from ffgym.logs import read_log
from ffgym.published import EMPS_ASYMMETRIC, EMPS_SYMMETRIC, EmpsModel
from ffgym.recordings import Recording
from ffgym.robot import RobotDescription, load_robot
from ffgym.studies.measured import measured_folder
from ffgym.studies.torque_prediction import predict_torque
from scripts.convergence_table import renewed

AUTHORS_FILTERING = Filtering(motion=LowPass(cutoff=100.0, order=4), parallel=LowPass(cutoff=40.0, order=4), moving=0.0)
"""As the EMPS scripts: position at 100 Hz, both sides below 40 Hz, every tenth row; standstill counts, too."""

ASYMMETRIC_TERMS = (*DEFAULT_TERMS, "viscous_asymmetry")

RESAMPLES = RigidBodyOptions().resamples
"""Bootstrap resamples of the tables; tests take fewer."""

NEAR_CAD = 0.03
"""Spread [1] of masses that are believed: CAD masses of a machine that was built from them."""

SPREADS_OF_MASSES: Mapping[str, float | None] = {"near CAD": NEAR_CAD, "free": None}
"""Spreads of masses by name; None is chosen from the fitted run."""


@dataclass(frozen=True)
class Config:
    """Identification of the EMPS axis and of the KR 300."""

    json: Path | None = None
    """Numbers as JSON."""
    write: Path | None = None
    """Markdown file whose tables are renewed, docs/rigid_body_identification.md."""


def main(config: Config) -> Mapping[str, str]:
    """Print the tables; write what is asked for."""
    if config.json is not None:
        check_writable(config.json)
    emps = read_log(measured_folder() / "emps" / "emps_id.npz", "emps")
    runs = {
        run: read_log(measured_folder() / "kuka_kr300_2020" / f"{run}.npz", "kuka_kr300_2020") for run in ("A", "C")
    }
    fits = emps_fits(emps)
    arm = kr300_fits(runs["A"])
    springs = spring_fits(runs["A"])
    tables = {
        "emps": emps_table(fits),
        "kr300": kr300_table(arm, runs["C"]),
        "spring": spring_table(springs, runs["C"]),
    }
    for name, text in tables.items():
        print(f"{name}\n{text}\n")
    if config.json is not None:
        numbers = {"emps": {name: asdict(model_of(fit)) for name, fit in fits.items()}, "tables": dict(tables)}
        write_json(config.json, {"versions": versions()} | numbers)
    if config.write is not None:
        write_text(config.write, renewed(read_text(config.write), tables))
    return tables


def doubtful_axis() -> RobotDescription:
    """The ball-screw axis as someone describes it who does not know the published numbers: none of them is in it."""
    robot = load_robot("ball_screw")
    friction = robot.friction.scaled(coulomb=2.0, static=2.0, viscous=0.5)
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


def emps_table(fits: Mapping[str, RigidBodyFit]) -> str:
    """What the authors' scripts give and what is found, and what is left of the force."""
    rows = ["| model | parameter | authors' script | found | difference |", "|---|---|---|---|---|"]
    for name, published in (("symmetric", EMPS_SYMMETRIC), ("asymmetric", EMPS_ASYMMETRIC)):
        found = numbers_of(model_of(fits[name]))
        for parameter, value in numbers_of(published).items():
            change = found[parameter] / value - 1
            rows.append(f"| {name} | {parameter} | {value:.4f} | {found[parameter]:.4f} | {change:+.2%} |")
        left = float(fits[name].errors.identified[0] * fits[name].robot.drive.gear_ratio[0])
        rows.append(f"| {name} | left of the force, RMS [N] |  | {left:.2f} |  |")
    return "\n".join(rows)


def kr300_fits(run: Recording, resamples: int = RESAMPLES) -> dict[str, RigidBodyFit]:
    """Masses, rotors, friction and offsets: with masses that are believed, and as far from them as predicts best."""
    robot = load_robot("kuka_kr300_r2500")
    return {
        masses: identify_rigid_body(robot, [run], RigidBodyOptions(spread=spread, resamples=resamples))
        for masses, spread in SPREADS_OF_MASSES.items()
    }


def kr300_table(fits: Mapping[str, RigidBodyFit], run: Recording) -> str:
    """RMS errors on a run that was not fitted, axis by axis, motor side [N m]."""
    errors = {name: fit.validate([run]) for name, fit in fits.items()}
    first = next(iter(fits.values()))
    raw = {"description": _unfiltered(first.robot, run)} | {
        name: _unfiltered(fit.identified, run) for name, fit in fits.items()
    }
    heads = [f"{name} ({fit.trade_off.chosen:g}){file}" for name, fit in fits.items() for file in ("", ", file")]
    heads = ["axis", "measured", "description", *heads, *(f"unfiltered: {name}" for name in raw)]
    rows = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for j, joint in enumerate(first.robot.joints):
        cells = [errors["near CAD"].measured[j], errors["near CAD"].described[j]]
        cells += [value[j] for e in errors.values() for value in (e.identified, e.in_file)]
        cells += [values[j] for values in raw.values()]
        rows.append(f"| {joint} | {' | '.join(f'{cell:.2f}' for cell in cells)} |")
    return "\n".join(rows)


def _unfiltered(robot: RobotDescription, run: Recording) -> list[float]:
    """Errors as docs/torque_prediction.md has them: against the torque as it was measured."""
    return [error.rms_error for error in predict_torque(robot, run).errors("description")]


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


def spring_table(fits: Mapping[str, RigidBodyFit], run: Recording) -> str:
    """RMS error of axis 2 behind the gearbox on the fitted run and on another, and the factor on the spring."""
    rows = ["| model | spread of masses | run A [N m] | run C [N m] | factor (90 %) |", "|---|---|---|---|---|"]
    for name, fit in fits.items():
        ratio = float(np.abs(fit.robot.drive.gear_ratio[1]))
        fitted, other = (ratio * float(errors.identified[1]) for errors in (fit.errors, fit.validate([run])))
        rows.append(f"| {name} | {fit.trade_off.chosen:g} | {fitted:.0f} | {other:.0f} | {_factor(fit)} |")
    return "\n".join(rows)


def _factor(fit: RigidBodyFit) -> str:
    label = "springs.counterbalance"
    if label not in fit.labels:
        return ""
    i = fit.labels.index(label)
    return f"{fit.estimate[i]:.2f} ({fit.intervals.low[i]:.2f} to {fit.intervals.high[i]:.2f})"


if __name__ == "__main__":
    main(tyro.cli(Config))
