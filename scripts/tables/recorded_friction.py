"""Friction models of docs/narx.md on a measured robot: the KUKA KR 300, run A fitted, run C predicted.

Friction is what rigid-body torque of the description leaves of the measured motor torque, thesis (6.12). The recordings
are not part of the package and lie where FFGYM_DATA says.
"""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ffgym.core.measures import rms
from ffgym.core.types import Array
from ffgym.diagnosis.identification import FrictionTorque, friction_torque
from ffgym.diagnosis.identification.narx import (
    Errors,
    FrictionModel,
    Misfit,
    Regressors,
    Samples,
    Structure,
    best_simulating,
    fit_linear,
)
from ffgym.published import KR300_FRICTION
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, RobotDescription, load_robot
from ffgym.studies.torque_prediction import MOVING
from scripts.tables.friction import networks
from scripts.tables.page import Contents, markdown
from scripts.tables.recorded import DATA_VARIABLE, measure
from scripts.thesis.narx import LINEAR, OTHERS, PUBLISHED, Candidate

N_EVALUATIONS = 200
"""Evaluations of each start, as for the agent; 1000 change no error in run C by more than 0.02 N m."""
N_STARTS = 10
"""Random starts, of which the one is kept that simulates run A best."""

STATIC = Candidate(name="static", label="v(k), no memory", regressors=Regressors(speed_lags=(0,), output_lags=()))
CANDIDATES = (
    STATIC,
    *PUBLISHED,
    *(each for each in OTHERS if each.name == "both"),
    *(each for each in LINEAR if each.data == "sine"),
)
"""Structures of the study on LuGre data, here fitted to run A; and a network without memory. Networks of slip elements
are left out: here these are square waves, and the end of their fits hangs on rounding."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredFit:
    """Errors of one model on a run, joint by joint, motor side [N m], (N,) each."""

    simulation: Array
    """RMS error in free run."""
    prediction: Array
    """RMS error one step ahead."""


def narx() -> Contents:
    """All tables of the page; those of the measured robot stay as they are where its recordings are not at hand."""
    made = networks()
    if not os.environ.get(DATA_VARIABLE):
        print(f"{DATA_VARIABLE} is not set: the tables of the measured robot stay as they are")
        return made
    own = measured()
    return Contents(parts={**made.parts, **own.parts}, numbers={**made.numbers, "measured": own.numbers})


def measured(
    candidates: Sequence[Candidate] = CANDIDATES,
    n_starts: int = N_STARTS,
    seed: int = 0,
    fit: str = "A",
    other: str = "C",
) -> Contents:
    """Fit friction models to one run of the KUKA, and tabulate what they leave of it and of another."""
    robot = load_robot("kuka_kr300_r2500")
    runs = {run: measure("kuka_kr300_2020", run) for run in (fit, other)}
    found = compare_models(robot, runs[fit], runs, candidates, n_starts=n_starts, seed=seed)
    along = {run: friction_torque(RigidArm(robot), recording) for run, recording in runs.items()}
    laws: Mapping[str, Callable[[FrictionTorque], Array]] = {
        "description, static LuGre": lambda each: robot.friction.steady_torque(each.signals.motor_dq),
        "authors' static law": lambda each: robot.drive.motor_torque(KR300_FRICTION.torque(each.signals.dq)),
    }
    samples = {run: samples_of(each) for run, each in along.items()}
    # what there is to explain, and laws that others identified
    size = {run: [rms(own.torque[own.scored]) for own in each] for run, each in samples.items()}
    rows = [("RMS friction", *_cells(size[other], size[fit]))]
    for name, law in laws.items():
        left = {run: static_errors(law(along[run]), samples[run]) for run in runs}
        rows.append((name, *_cells(left[other], left[fit])))
    rows += [(name, *_cells(each[other].simulation, each[fit].simulation)) for name, each in found.items()]
    # one step ahead is another question only for models of past outputs; an OE model is its own predictor in free run
    asked = [own.label for own in candidates if own.regressors.output_lags and own.focus == "prediction"]
    ahead = [(name, *_cells(found[name][other].prediction, found[name][fit].prediction)) for name in asked]
    return Contents(
        parts={
            "measured": markdown(("", *robot.joints), rows),
            "measured, one step": markdown(("", *robot.joints), ahead),
        },
        numbers={
            "config": {"n_starts": n_starts, "seed": seed, "fitted": fit, "predicted": other},
            "rms_nm": {
                name: {run: {"simulation": own.simulation.tolist(), "prediction": own.prediction.tolist()}}
                for name, each in found.items()
                for run, own in each.items()
            },
        },
    )


def compare_models(
    robot: RobotDescription,
    fitted: Recording,
    runs: Mapping[str, Recording],
    candidates: Sequence[Candidate],
    *,
    n_starts: int = N_STARTS,
    seed: int = 0,
) -> dict[str, dict[str, MeasuredFit]]:
    """Fit models of friction to a recording, joint by joint, and give their errors on others, by label and run."""
    arm = RigidArm(robot)
    begin = samples_of(friction_torque(arm, fitted))
    scored = {run: samples_of(friction_torque(arm, recording)) for run, recording in runs.items()}
    found = {}
    for candidate in candidates:
        models = [fit_model(candidate, own, n_starts, seed) for own in begin]
        found[candidate.label] = {run: _errors(models, own) for run, own in scored.items()}
    return found


def samples_of(friction: FrictionTorque) -> list[Samples]:
    """Turn friction along a recording into samples, joint by joint; those count that move.

    Below `MOVING` friction is what bristles hold, which the motor angle does not show.
    """
    signals = friction.signals
    return [
        Samples(
            dt=signals.dt,
            motor_dq=signals.motor_dq[:, [j]],
            torque=friction.friction[:, [j]],
            scored=friction.counts(j) & (np.abs(signals.dq[:, j]) > MOVING),
            noise=np.ones(1),
        )
        for j in range(signals.dq.shape[1])
    ]


def fit_model(candidate: Candidate, samples: Samples, n_starts: int, seed: int) -> FrictionModel:
    """Fit a candidate to the samples of one joint; of a network the start that simulates them best."""
    if candidate.kind == "linear":
        return fit_linear([samples], candidate.regressors, focus=candidate.focus)
    structure, rng = Structure(regressors=candidate.regressors), np.random.default_rng(seed)
    return best_simulating([samples], structure, rng, n_starts, n_evaluations=N_EVALUATIONS)


def static_errors(torque: Array, samples: Sequence[Samples]) -> list[float]:
    """RMS error of a static law with torques (T, N) [N m], joint by joint."""
    return [
        float(Misfit.of(torque[own.scored][:, [j]], own.torque[own.scored]).rms[0]) for j, own in enumerate(samples)
    ]


def _errors(models: Sequence[FrictionModel], samples: Sequence[Samples]) -> MeasuredFit:
    errors = [Errors.of(model, own) for model, own in zip(models, samples, strict=True)]
    return MeasuredFit(
        simulation=np.array([each.simulation.rms[0] for each in errors]),
        prediction=np.array([each.prediction.rms[0] for each in errors]),
    )


def _cells(predicted: Sequence[float] | Array, fitted: Sequence[float] | Array) -> list[str]:
    """Errors in the run that was predicted, with those in the fitted one in brackets."""
    return [f"{one:.2f} ({other:.2f})" for one, other in zip(predicted, fitted, strict=True)]
