"""What a trial shows of the missing torque, and the loop of trials and fits."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from ffgym.agents.declaration import AgentSetting
from ffgym.agents.supervised import MotorRecord, learn
from ffgym.control import CausalLaw
from ffgym.core.errors import FFGymError
from ffgym.simulation import Run
from ffgym.studies import circle_references, sine_references


@dataclass(frozen=True, kw_only=True, eq=False)
class Constant(CausalLaw):
    """A torque of 0.1 N m, for counting."""

    name: str = "constant"
    seen: list = field(default_factory=list)

    @property
    def n_joints(self):
        return 1

    def step(self, memory, window):
        return np.full_like(window.motor_dq[..., 0, :], 0.1), memory


@pytest.fixture(scope="module")
def setting(one_axis):
    return AgentSetting.of(one_axis)


def test_a_record_shows_the_friction_of_the_motor_though_nobody_told(setting, one_axis):
    """Rigid axis: what the feedback adds is friction, but for the acceleration that the motor makes on its own."""
    reference = sine_references(one_axis)[1.0]
    (recording,) = setting.trial([Run(reference=reference)], 0)
    record = MotorRecord.of(reference, recording)
    true = recording.joint_array("friction.effort")[::4]
    late = record.moving & (reference.t > 1.0)
    assert np.corrcoef(record.torque[late, 0], true[late, 0])[0, 1] > 0.99
    np.testing.assert_allclose(record.motor_dq[late], recording.joint_array("motor.velocity")[::4][late], atol=0.1)


def test_gravity_that_the_integral_carries_at_rest_is_no_friction(arm):
    reference = circle_references(arm, ["p1"], [0.01], [0.003])["p1", 0.01]
    (recording,) = AgentSetting.of(arm.robot).trial([Run(reference=reference)], 0)
    record = MotorRecord.of(reference, recording)
    carried = recording.joint_array("feedback.integral")[0]
    true = recording.joint_array("friction.effort")[::4]
    assert np.abs(carried).max() > 1  # [N m], far more than friction
    wrong = np.sqrt(np.mean((record.torque - true)[record.moving] ** 2, axis=0))
    assert np.all(wrong < 0.2 * arm.robot.friction.coulomb)


def test_trials_run_without_a_law_first_and_then_with_the_newest_fit(setting, one_axis):
    references = list(sine_references(one_axis).values())
    calls = []

    def trial(runs, number):
        calls.append((number, [run.law.name for run in runs]))
        return setting.trial(runs, number)

    learned = learn(trial, references, lambda records: Constant(), n_trials=3)
    assert calls == [(0, ["none"] * 2), (1, ["constant"] * 2), (2, ["constant"] * 2)]
    assert learned.error.shape == learned.noise.shape == (3, 2, 1)
    assert learned.robot_seconds == pytest.approx(3 * sum(reference.duration for reference in references))


@pytest.mark.parametrize(
    ("arguments", "message"), [({"n_trials": 0}, "n_trials = 0"), ({"references": []}, "no motion to learn on")]
)
def test_nothing_to_learn_from_is_refused(setting, one_axis, arguments, message):
    given = {"references": [sine_references(one_axis)[1.0]], "n_trials": 1} | arguments
    with pytest.raises(FFGymError, match=message):
        learn(setting.trial, given["references"], lambda records: Constant(), given["n_trials"])
