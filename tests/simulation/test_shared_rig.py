import numpy as np
import pytest

from ffgym.agents.trials import RigTrial
from ffgym.control import NoCompensation
from ffgym.core.errors import FFGymError
from ffgym.robot import RigidArm
from ffgym.simulation import Run, SimulatedRig
from ffgym.simulation.sensors import Resolver
from ffgym.simulation.shared_rig import learn_together
from ffgym.studies.one_axis import sine_reference


@pytest.fixture(scope="module")
def rig(one_axis):
    return SimulatedRig(arm=RigidArm(one_axis), sensors=(Resolver(bits=16, noise=1e-4),))


@pytest.fixture(scope="module")
def references(one_axis):
    return [sine_reference(one_axis, frequency, 1.0, 0.5) for frequency in (3.0, 1.0)]


def errors_of(references, n_trials):
    """A learner that keeps what its trials measured."""

    def learner(trial):
        seen = []
        for number in range(n_trials):
            runs = [Run(reference=reference, law=NoCompensation()) for reference in references]
            seen += [recording["motor.position.j1"] for recording in trial(runs, number)]
        return np.concatenate(seen)

    return learner


def test_each_learner_sees_what_it_would_see_alone(rig, references):
    learners = {
        "short": (0, errors_of(references[:1], 1)),
        "long": (0, errors_of(references, 3)),
        "other": (7, errors_of(references[1:], 2)),
    }
    together = learn_together(rig, learners)
    assert list(together) == list(learners)
    for name, (seed, learner) in learners.items():
        alone = learner(RigTrial(rig=rig, seed=seed))
        assert together[name].tobytes() == alone.tobytes()


def test_a_learner_that_fails_is_told_and_leaves_nobody_waiting(rig, references):
    def fails(trial):
        trial([Run(reference=references[0])], 0)
        raise FFGymError("this learner cannot go on.")

    with pytest.raises(FFGymError, match="cannot go on"):
        learn_together(rig, {"one": (0, fails), "two": (0, errors_of(references, 2))})


def test_a_trial_that_fails_is_told_and_leaves_nobody_waiting(rig, references, monkeypatch):
    def broken(*args, **kwargs):
        raise FFGymError("the machine has stopped.")

    monkeypatch.setattr(SimulatedRig, "run", broken)
    learners = {name: (0, errors_of(references, 2)) for name in ("one", "two", "three")}
    with pytest.raises((FFGymError, RuntimeError), match=r"the machine has stopped|another learner failed"):
        learn_together(rig, learners)
