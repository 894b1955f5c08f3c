r"""Model fitted on the machine: motions, then all numbers of the nominal description together, then a law from them.

Idea: system identification before feed-forward. Motions run on the machine without compensation, through its sensors;
friction with its share on the arm, rotors, masses and springs of all joints are fitted to the recordings at once
(`ffgym.diagnosis.tuning`), near the description where recordings do not say; the law inverts the model with these
numbers (`ffgym.agents.elastic`). It is the law `fitted` of `ffgym improve --fit`, before any diagnosis.

Source: the fit is that of `ffgym.diagnosis.tuning`, a Gauss-Newton method with a Gaussian prior about the description.

Run it:

    python -m scripts.adaptation --adapters fitted

Logged: nothing.

Departures from the source: none; recordings of one motion that is repeated have numbers in their names.
"""

from collections.abc import Sequence

from ffgym.agents.model import model_law
from ffgym.agents.trials import Trial, run_trial
from ffgym.control import FeedForwardLaw, NoCompensation
from ffgym.core.errors import check_whole
from ffgym.diagnosis.tuning import tune
from ffgym.paths import Reference
from ffgym.robot import RigidArm
from ffgym.simulation import Machine, Run

NAME = "fitted"


def fit_model(arm: RigidArm, references: Sequence[Reference], trial: Trial, trials: int) -> FeedForwardLaw:
    """Fit the model of a controller to a number of trials of some motions, and make the law that inverts it.

    Args:
        arm: nominal model of the controller.
        references: motions of one trial.
        trial: trials on the machine, whose recordings need torques of the motors; a tracked tool tells springs.
        trials: number of trials, 1 at least.

    Raises:
        FFGymError: if there are no trials, or recordings do not fit the robot.
    """
    check_whole("trials", trials, low=1)
    runs = [Run(reference=reference, law=NoCompensation()) for reference in references]
    recordings = [
        recording.rename(f"{recording.header.segment}, trial {number}")
        for number in range(trials)
        for recording in run_trial(trial, runs, number)
    ]
    return model_law(tune(Machine.of(arm.robot), recordings), arm, NAME)
