"""Iterative learning: better with each trial, better than any law that has not tried the motion, steady in noise."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.agents.catalogue import CATALOGUE, make_law
from ffgym.agents.declaration import AgentSetting
from ffgym.agents.iterative import TRIALS, IterativeLearning
from ffgym.agents.torque_response import task_error
from ffgym.agents.trials import SimulatedTrial
from ffgym.control import DynamicLuGreExact, StaticLuGre
from ffgym.core.errors import FFGymError
from ffgym.core.measures import rms_length
from ffgym.recordings.metrics import motor_error, path_errors
from ffgym.robot import RigidArm
from ffgym.simulation import Resolver, Run, sensors_of, simulate
from ffgym.studies import circle_references, circle_study, sine_references

POSITIONS, SPEEDS, RADII = ["p1", "p3"], [0.04, 0.1], [0.003]
MICROMETRE = 1e-6


@pytest.fixture(scope="module")
def references(arm):
    return list(circle_references(arm, POSITIONS, SPEEDS, RADII).values())


@pytest.fixture(scope="module")
def one(references):
    """The shortest motion alone."""
    return references[-2:-1]


@pytest.fixture(scope="module")
def tool(arm, references):
    return IterativeLearning(arm=arm, target="tcp").learn(references, SimulatedTrial(arm=arm))


@pytest.fixture(scope="module")
def motors(arm, references):
    return IterativeLearning(arm=arm, target="motor").learn(references, SimulatedTrial(arm=arm))


def path_rms(study, law):
    """Of each circle [mm]."""
    return np.array([cell.rms_mm for cell in study.select(agent=law)])


def motor_rms(study, law):
    """Of all motors together on each circle with its leads [rad]."""
    return np.array([np.linalg.norm(cell.motor_rms_rad) for cell in study.select(agent=law)])


def test_every_circle_improves_in_every_trial(tool, motors):
    for learned, floor in ((tool, 10 * MICROMETRE), (motors, 0.0)):
        error = learned.history.circle_error
        assert error.shape == (TRIALS, 4)
        assert ((np.diff(error, axis=0) < 0) | (error[1:] < floor)).all()
        assert (np.diff(learned.history.motion_error, axis=0) < 0).all()


@pytest.mark.slow
def test_each_member_is_the_best_at_what_it_learns_from(irb4600, references):
    setting = AgentSetting.of(irb4600, references)
    others = ["none", *(name for name, entry in CATALOGUE.items() if "nominal" in entry.track)]
    laws = [make_law(name, setting) for name in (*others, "ilc_motor", "ilc_tcp")]
    study = circle_study(irb4600, laws=laws, positions=POSITIONS, speeds=SPEEDS, radii=RADII)
    for name in others:
        assert (path_rms(study, "ilc_tcp") < path_rms(study, name)).all(), name
        assert (motor_rms(study, "ilc_motor") < motor_rms(study, name)).all(), name
    assert (path_rms(study, "ilc_tcp") < 1e-3).all()  # [mm]


def test_from_zero_torque_the_tool_comes_as_near(irb4600, tool):
    study = circle_study(irb4600, laws=[tool.law], positions=POSITIONS, speeds=SPEEDS, radii=RADII)
    assert (path_rms(study, "ilc_tcp") < 3e-3).all()


def test_motors_without_error_leave_the_tool_off_its_path_as_the_arm_is_elastic(irb4600, motors, tool):
    assert (motors.history.motion_error[-1] < 0.25 * motors.history.motion_error[0]).all()
    study = circle_study(irb4600, laws=[motors.law, tool.law], positions=POSITIONS, speeds=SPEEDS, radii=RADII)
    assert (path_rms(study, "ilc_motor") > 50 * path_rms(study, "ilc_tcp")).all()


def test_the_history_is_what_the_trials_measured(arm, references, tool):
    history = tool.history
    assert history.motions == tuple(reference.name for reference in references)
    assert history.circles == tuple(f"{reference.name}, circle 3 mm" for reference in references)
    seconds = sum(reference.duration for reference in references)
    np.testing.assert_allclose(history.robot_seconds, seconds * np.arange(1, TRIALS + 1))
    recordings = simulate([Run(reference=reference, law=tool.law) for reference in references], arm=arm)
    kept = [rms_length(task_error(recording, r, "tcp")) for r, recording in zip(references, recordings, strict=True)]
    np.testing.assert_array_equal(kept, history.motion_error.min(axis=0))


def test_noise_of_the_sensors_is_the_floor_and_does_not_pile_up(arm, irb4600, one):
    noisy = SimulatedTrial(arm=arm, sensors=sensors_of(irb4600))
    learned = IterativeLearning(arm=arm, target="tcp").learn(one, noisy, trials=24)
    error = learned.history.motion_error[:, 0]
    assert error[-8:].max() < np.sqrt(3) * irb4600.sensors.tracker_noise  # what one row of the tracker is off
    assert error[-8:].mean() < 1.1 * error[-16:-8].mean()
    (exact,) = simulate([Run(reference=one[0], law=learned.law)], arm=arm)
    assert path_errors(exact)[0].rms < 0.5 * irb4600.sensors.tracker_noise


def test_resolvers_do_not_disturb_learning_from_motors(arm, irb4600, one):
    measured, exact = (
        IterativeLearning(arm=arm, target="motor").learn(one, SimulatedTrial(arm=arm, sensors=sensors), trials=6)
        for sensors in ((Resolver(bits=irb4600.sensors.encoder_bits),), ())
    )
    np.testing.assert_allclose(measured.history.motion_error, exact.history.motion_error, rtol=0.02)


def test_a_torque_that_the_drive_cannot_give_does_not_pile_up(arm, irb4600):
    (reference,) = circle_references(arm, ["p1"], [0.1], [0.001]).values()
    plant, tried = SimulatedTrial(arm=arm), []

    def watched(runs, number):
        tried.append(runs[0].law)
        return plant(runs, number)

    learned = IterativeLearning(arm=arm, target="motor", tolerance=1e-3).learn([reference], watched)
    (recording,) = simulate([Run(reference=reference, law=tried[-1])], arm=arm)
    control = recording.joint_array("command.effort") - recording.joint_array("compensation.effort")
    peak = irb4600.drive.peak_torque
    assert (np.abs(recording.joint_array("motor.effort")).max(axis=0) == peak).any()  # the drive limits
    assert (np.abs(tried[-1].torque(reference)).max(axis=0) < 1.05 * (peak + np.abs(control).max(axis=0))).all()
    error = learned.history.motion_error[:, 0]
    assert error[-1] < min(1.3 * error.min(), 0.5 * error[0])


def test_it_learns_on_a_machine_that_is_not_the_model(arm, irb4600):
    drive = replace(irb4600.drive, joint_stiffness=0.8 * irb4600.drive.joint_stiffness)
    machine = replace(irb4600, drive=drive, friction=irb4600.friction.scale(coulomb=1.3, static=1.3, viscous=1.3))
    (reference,) = circle_references(RigidArm(machine), ["p3"], [0.1], [0.003]).values()
    learned = IterativeLearning(arm=arm, target="tcp").learn([reference], SimulatedTrial(arm=RigidArm(machine)))
    error = learned.history.circle_error[:, 0]
    assert (np.diff(error)[error[1:] > 20 * MICROMETRE] < 0).all()
    assert error[-1] < 0.01 * error[0]


def test_each_motion_learns_for_itself_and_the_same_every_time(arm, references):
    learning = IterativeLearning(arm=arm, target="tcp")
    together = learning.learn(references[-2:], SimulatedTrial(arm=arm, n_threads=2), trials=3)
    alone = [learning.learn([r], SimulatedTrial(arm=arm, n_threads=1), trials=3) for r in references[-2:]]
    for reference, learned in zip(references[-2:], alone, strict=True):
        np.testing.assert_array_equal(learned.law.torque(reference), together.law.torque(reference))
    errors = [learned.history.motion_error for learned in alone]
    np.testing.assert_array_equal(np.hstack(errors), together.history.motion_error)


def test_the_first_trial_has_the_torque_of_the_base(arm, one):
    base = DynamicLuGreExact(arm.robot.friction)
    learned = IterativeLearning(arm=arm, target="motor", base=base).learn(one, SimulatedTrial(arm=arm), trials=1)
    (recording,) = simulate([Run(reference=one[0], law=base)], arm=arm)
    np.testing.assert_array_equal(
        learned.history.motion_error, [[rms_length(motor_error_at_samples(recording, one[0]))]]
    )


def test_no_torque_is_added_before_the_first_sample(one_axis):
    arm, (reference,) = RigidArm(one_axis), sine_references(one_axis, [3.0]).values()
    base = StaticLuGre(one_axis.friction)
    assert base.torque(reference)[0] != 0.0
    learned = IterativeLearning(arm=arm, target="motor", base=base).learn(
        [reference], SimulatedTrial(arm=arm), trials=2
    )
    assert learned.law.torque(reference)[0] == 0.0


def motor_error_at_samples(recording, reference):
    assert len(motor_error(recording)) == 4 * (len(reference.t) - 1) + 1
    return task_error(recording, reference, "motor")


def test_the_best_torque_is_kept_when_a_trial_goes_wrong(arm, one):
    plant, seen = SimulatedTrial(arm=arm), []

    def someone_leans_on_the_robot(runs, number):
        seen.append(runs[0].law.torque(one[0]))
        return plant([Run(reference=run.reference) for run in runs] if number == 3 else runs, number)

    learned = IterativeLearning(arm=arm, target="tcp").learn(one, someone_leans_on_the_robot, trials=4)
    assert learned.history.best.tolist() == [2]
    np.testing.assert_array_equal(learned.law.torque(one[0]), seen[2])


def test_learning_goes_on_from_its_state_bit_for_bit(arm, irb4600, one, tmp_path):
    trial = SimulatedTrial(arm=arm, sensors=sensors_of(irb4600), seed=3)
    learning, state, told = IterativeLearning(arm=arm, target="tcp"), tmp_path / "state.npz", []
    whole = learning.learn(one, trial, trials=4)

    def stopped(runs, number):
        if number == 2:
            raise KeyboardInterrupt
        return trial(runs, number)

    with pytest.raises(KeyboardInterrupt):
        learning.learn(one, stopped, trials=4, state=state)
    resumed = learning.learn(one, trial, trials=4, state=state, progress=lambda *now: told.append(now))
    assert told == [(3, 4), (4, 4)]
    np.testing.assert_array_equal(resumed.history.circle_error, whole.history.circle_error)
    np.testing.assert_array_equal(resumed.law.torque(one[0]), whole.law.torque(one[0]))
    with pytest.raises(FFGymError, match=r"holds other learning: .*tolerance was 2e-05, now 0\.0001"):
        replace(learning, tolerance=1e-4).learn(one, trial, trials=4, state=state)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"target": "link"}, r"Unknown target 'link'\. Available: motor, tcp"),
        ({"target": "tcp", "tolerance": -1.0}, r"tolerance = -1\.0 rad or m is out of range"),
    ],
)
def test_wrong_learning_is_refused(arm, changes, message):
    with pytest.raises(FFGymError, match=message):
        IterativeLearning(arm=arm, **changes)


def test_motions_that_cannot_be_learned_are_refused(arm, one_axis, one):
    trial, learning = SimulatedTrial(arm=arm), IterativeLearning(arm=arm, target="tcp")
    with pytest.raises(FFGymError, match="There is no motion to learn: references is empty"):
        learning.learn([], trial)
    with pytest.raises(FFGymError, match="The motion 'p1, 100 mm/s' is among the references twice"):
        learning.learn([one[0], replace(one[0], q=one[0].q.copy())], trial)
    with pytest.raises(FFGymError, match="'p1, 100 mm/s' for 6 joints does not fit a model with 1"):
        IterativeLearning(arm=RigidArm(one_axis), target="motor").learn(one, trial)
    with pytest.raises(FFGymError, match=r"No column 'tcp\.position\.x'"):
        learning.learn(one, replace(trial, sensors=(Resolver(bits=16),)))


@pytest.mark.slow
def test_all_36_circles_of_the_thesis_improve_in_every_trial(irb4600, arm):
    references = list(circle_references(arm).values())
    for target, floor in (("tcp", 10 * MICROMETRE), ("motor", 0.0)):
        learned = IterativeLearning(arm=arm, target=target).learn(references, SimulatedTrial(arm=arm))
        error = learned.history.circle_error
        assert error.shape == (TRIALS, 36)
        assert ((np.diff(error, axis=0) < 0) | (error[1:] < floor)).all()
        assert (np.diff(learned.history.motion_error, axis=0) < 0).all()


@pytest.mark.slow
def test_on_all_36_circles_each_member_is_better_than_every_causal_agent(irb4600, arm):
    setting = AgentSetting.of(irb4600, list(circle_references(arm).values()))
    others = [name for name, entry in CATALOGUE.items() if entry.track.startswith("causal")]
    study = circle_study(irb4600, laws=[make_law(name, setting) for name in (*others, "ilc_motor", "ilc_tcp")])
    for name in others:
        assert (path_rms(study, "ilc_tcp") < path_rms(study, name)).all(), name
        assert (motor_rms(study, "ilc_motor") < motor_rms(study, name)).all(), name
