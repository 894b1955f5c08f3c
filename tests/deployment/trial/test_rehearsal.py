"""Rehearsals of trials on simulated machines: what differs from run to run does, and nothing else."""

import itertools

import numpy as np
import pytest

from ffgym.agents.lugre import dynamic_lugre
from ffgym.control import SetpointChannel
from ffgym.core.errors import FFGymError
from ffgym.deployment.trial import make_program, plan_trial, read_trial, rehearse
from ffgym.deployment.trial.rehearsal import compute_starts
from ffgym.paths import joint_reference, joint_sine
from ffgym.robot import RigidArm
from ffgym.simulation import SimulatedRig, sensors_of


@pytest.fixture(scope="module")
def rig(one_axis) -> SimulatedRig:
    """One axis with its resolver."""
    return SimulatedRig(arm=RigidArm(one_axis), sensors=sensors_of(one_axis))


@pytest.fixture(scope="module")
def plan(rig):
    """Trial of a sine, three pairs."""
    sine = joint_reference(rig.robot, joint_sine([0.02], 2.0, 0.5))
    return plan_trial("one_axis", [make_program(rig.arm, sine)], pairs=3, seed=1)


def test_logs_have_the_names_of_the_plan_and_one_clock_with_pauses(plan, rig):
    logs = list(rehearse(plan, rig, dynamic_lugre(rig.robot), begin=100.0, pause=3.0))
    assert [log.name for log in logs] == [run.log for run in plan.runs]
    begins = [log.recording.t[0] for log in logs]
    assert np.allclose(begins, np.array(compute_starts(plan, begin=100.0, pause=3.0)) - 100.0)
    gaps = [after.recording.t[0] - before.recording.t[-1] for before, after in itertools.pairwise(logs)]
    assert np.allclose(gaps, 3.0, atol=0.01)


def test_laps_follow_each_other_with_their_phases(plan, rig):
    (program,) = plan.programs
    one, two = program.make_reference(rig.arm), program.make_reference(rig.arm, laps=2)
    n, lap = len(one.t), program.duration + program.recording.dt
    assert np.array_equal(two.q, np.concatenate([one.q, one.q]))
    assert two.t[n] == pytest.approx(lap)
    starts = [phase.start for phase in one.phases]
    assert [phase.start for phase in two.phases] == pytest.approx([*starts, *(start + lap for start in starts)])


@pytest.mark.parametrize("channel", [None, SetpointChannel()])
def test_the_correction_is_on_in_the_runs_of_the_plan_alone_by_torque_and_by_set_points(plan, rig, channel):
    logs = list(rehearse(plan, rig, dynamic_lugre(rig.robot), channel=channel, seed=2))
    family = "compensation.effort" if channel is None else "correction.position"
    for run, log in zip(plan.runs, logs, strict=True):
        added = log.recording.joint_array(family) if log.recording.has(family) else np.zeros((1, 1))
        assert np.any(added) == run.corrected
    result = read_trial(plan, logs)
    assert all(one.counts for one in result.runs if not one.run.is_warm_up)
    assert result.gains[0].gain > 0.3


def test_runs_of_one_kind_differ_by_friction_and_not_without_its_variation(plan, rig):
    exact = SimulatedRig(arm=rig.arm)

    def spread(variation: float) -> float:
        logs = rehearse(plan, exact, dynamic_lugre(rig.robot), variation=variation, seed=3)
        sizes = [
            np.ptp(log.recording["feedback.effort.j1"])
            for run, log in zip(plan.runs, logs, strict=True)
            if not run.corrected
        ]
        return float(np.std(sizes) / np.mean(sizes))

    assert spread(0.0) < 1e-12
    assert 0.01 < spread(0.1) < 0.3


def test_the_same_seed_gives_the_same_logs_and_another_one_others(plan, rig):
    first, again, other = (list(rehearse(plan, rig, dynamic_lugre(rig.robot), seed=seed)) for seed in (4, 4, 5))
    assert all(one.recording.equals(two.recording) for one, two in zip(first, again, strict=True))
    assert not any(one.recording.equals(two.recording) for one, two in zip(first, other, strict=True))


def test_numbers_out_of_range_are_refused(plan, rig):
    law = dynamic_lugre(rig.robot)
    with pytest.raises(FFGymError, match="variation from run to run"):
        next(rehearse(plan, rig, law, variation=0.5))
    with pytest.raises(FFGymError, match="pause between runs"):
        next(rehearse(plan, rig, law, pause=0.0))
