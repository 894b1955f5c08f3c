"""How a NARX network learns from trials: Levenberg-Marquardt on the one-step prediction of the torque they show.

As thesis 6.2.3: prediction focus, three neurons, no linear term (`ffgym.diagnosis.identification.narx`). What is
predicted is the torque that was missing along the realised motion (`ffgym.agents.fitting.supervised`), which is
friction before all.

Prediction is not simulation. At 4 ms the last torque is a fair guess of the next one, so that a network with y(k-1) can
predict well and still drift once it runs on its own outputs (the thesis finds its models worse in simulation on other
data). `Errors` shows both.

Departures from the source: torque estimated from trials instead of data from a LuGre model; motions are weighted by
their noise, as in `ffgym.agents.fitting.residual_fit`; several random starts, of which the one is kept that *simulates*
best along the trials, since the best in prediction may drift; 200 evaluations at most instead of 1000 iterations;
sampled at the control step of 4 ms instead of 0.5 ms.
"""

from collections.abc import Sequence

import numpy as np

from ffgym.agents.common.lessons import every_speed
from ffgym.agents.common.trials import Trial
from ffgym.agents.fitting.supervised import MotorRecord, Supervised, learn
from ffgym.agents.narx import NARX
from ffgym.diagnosis.identification.narx import Samples, Structure, best_simulating
from ffgym.paths import Reference
from ffgym.robot import RigidArm

N_EVALUATIONS = 200
"""Of the residual at most, per start. Chosen: 1000, as in thesis 6.2.3, simulate no better and take far longer."""
N_STARTS = 5
"""Chosen: fits from different starts end in different minima."""
N_TRIALS = 2
"""Chosen, as for the residual torque model."""


def learn_narx(
    trial: Trial,
    references: Sequence[Reference],
    rng: np.random.Generator,
    structure: Structure | None = None,
    n_trials: int = N_TRIALS,
) -> Supervised[NARX]:
    """NARX network of a machine, from trials along `references`; `rng` draws the starts of the fits.

    Raises:
        FFGymError: if there is no motion, or a number is out of range.
    """
    structure = structure or Structure()

    def fit(records: Sequence[MotorRecord]) -> NARX:
        samples = [samples_of(record) for record in records]
        return NARX(model=best_simulating(samples, structure, rng, N_STARTS, n_evaluations=N_EVALUATIONS))

    return learn(trial, references, fit, n_trials)


def trained_narx(arm: RigidArm, trial: Trial, seed: int = 0) -> NARX:
    """Member of the catalogue: thesis (6.20), on the motions of every speed.

    Raises:
        FFGymError: if the robot has neither a work area nor one joint alone.
    """
    return learn_narx(trial, every_speed(arm), np.random.default_rng(seed)).law


def samples_of(record: MotorRecord) -> Samples:
    """What a trial showed, as the fit takes it: standstill is simulated, but not scored."""
    return Samples(
        dt=record.dt,
        motor_dq=record.motor_dq,
        torque=record.torque,
        scored=record.moving,
        noise=record.noise,
    )
