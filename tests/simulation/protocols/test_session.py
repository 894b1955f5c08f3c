"""Sessions: motions on one clock, under names of their own, and their recordings."""

import sys
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from ffgym.control import StaticLuGre
from ffgym.core.errors import FFGymError
from ffgym.robot import RigidArm
from ffgym.simulation import SimulatedRig
from ffgym.simulation.plant import Climate, Machine
from ffgym.simulation.protocols import plan_session, record, usual_sensors
from ffgym.simulation.protocols.load import MotionFile
from ffgym.simulation.protocols.mixtures import Circles, DiagnosisMotions
from ffgym.simulation.protocols.one_by_one import SlowTriangles, Table61
from ffgym.simulation.protocols.rests import DwellRestart
from ffgym.simulation.protocols.together import WarmUp
from tests.simulation.protocols.protocol_samples import arm_of

WARM = WarmUp(times=(0.0, 600.0, 2400.0), duration=2.0)
SHORT = SlowTriangles(sizes=(2.0,), period=1.0, periods=1)


@pytest.fixture(scope="module")
def session():
    return plan_session(arm_of("one_axis"), [WARM, SHORT, SHORT])


@pytest.fixture(scope="module")
def rig():
    arm = arm_of("one_axis")
    climate = Climate(rise=np.array([20.0]), time_constant=1200.0, running_since=300.0)
    machine = Machine(robot=arm.robot, climate=climate)
    return SimulatedRig(arm=arm, machine=machine, sensors=usual_sensors(arm.robot))


@pytest.fixture(scope="module")
def recordings(session, rig):
    return list(record(session, rig, seed=1))


def test_motions_follow_each_other_on_one_clock_with_pauses_between(session):
    assert [motion.start for motion in session[:3]] == [0.0, 600.0, 2400.0]
    for before, after in pairwise(session[2:]):
        assert after.start == pytest.approx(before.end + 5.0)


def test_a_protocol_that_comes_twice_gets_other_names_the_second_time(session):
    names = [motion.reference.name for motion in session]
    assert names[3:] == [
        "slow_triangles.j1.bristles_x2",
        "slow_triangles.j1.sliding",
        "slow_triangles.j1.bristles_x2.2",
        "slow_triangles.j1.sliding.2",
    ]


def test_names_make_files_and_files_differ():
    twice = [MotionFile(file="sine"), MotionFile(file="SINE".lower(), repeats=2), MotionFile(file="sine")]
    stems = [motion.stem for motion in plan_session(arm_of("one_axis"), twice)]
    assert stems == ["motion.sine", "motion.sine.1", "motion.sine.2", "motion.sine.3"]


def test_a_session_may_begin_later():
    first, *_ = plan_session(arm_of("one_axis"), [SHORT], start=3600.0)
    assert first.start == 3600.0


def test_recordings_say_where_they_belong_and_hold_no_truth(session, recordings):
    for motion, recording in zip(session, recordings, strict=True):
        header = recording.header
        assert header.segment == motion.reference.name
        assert header.phases == motion.reference.phases
        assert (header.meta["protocol"], header.meta["session_start"]) == (motion.protocol, motion.start)
        assert header.provenance["seed"] == 1
        assert header.encoder_bits == 16
        assert not any(recording.has(family) for family in ("friction.effort", "link.position"))
        assert recording.t[-1] == pytest.approx(motion.reference.duration, abs=1e-9)


def test_the_machine_warms_up_on_the_clock_of_the_session(session, recordings):
    for motion, recording in zip(session, recordings, strict=True):
        expected = 20.0 + 20.0 * -np.expm1(-(300.0 + motion.start) / 1200.0)
        assert recording["temperature.j1"][0] == pytest.approx(expected, abs=0.5)


def test_a_recording_does_not_depend_on_which_others_are_made(session, rig, recordings):
    alone = list(record(session, rig, seed=1, only={2, 4}))
    assert [one.equals(recordings[i]) for one, i in zip(alone, (2, 4), strict=True)] == [True, True]
    other = list(record(session, rig, seed=2, only={2}))
    assert not other[0].equals(recordings[2])


def test_recordings_do_not_depend_on_how_many_motions_run_together(session, rig, recordings, monkeypatch):
    together = []
    run = SimulatedRig.run

    def counted(self, runs, **options):
        together.append(len(runs))
        return run(self, runs, **options)

    monkeypatch.setattr(SimulatedRig, "run", counted)
    monkeypatch.setattr(sys.modules[record.__module__], "BATCH", 2.5)
    again = list(record(session, rig, seed=1))
    assert [one.equals(other) for one, other in zip(again, recordings, strict=True)] == [True] * len(session)
    assert len(together) > 1
    assert sum(together) == len(session)
    assert max(together) > 1
    together.clear()
    list(record(session, rig, record_dt=0.00025))
    assert together == [1] * len(session)  # samples four times as close: a quarter of the time together


def test_the_feedforward_law_is_that_of_every_motion(session, rig):
    law = StaticLuGre(rig.robot.friction)
    (recording,) = record(session, rig, law=law, only={4})
    assert recording.header.meta["feedforward_law"] == "lugre_static"
    np.testing.assert_allclose(
        recording["compensation.effort.j1"][8::4], law.torque(session[4].reference)[2:, 0], atol=1e-9
    )


def test_progress_counts_the_motions_that_are_made(session, rig):
    seen = []
    list(record(session, rig, only={3, 4}, progress=lambda done, total: seen.append((done, total))))
    total = session[3].reference.duration + session[4].reference.duration
    assert seen[0] == (0.0, pytest.approx(total))
    assert seen[-1] == (pytest.approx(total), pytest.approx(total))


def test_a_sine_of_table_6_1_gives_the_friction_loop_of_the_thesis():
    """Torque of joint 1 at 1.3 rad/s and 0.25 Hz: the loop is as high as Coulomb and viscous friction say."""
    arm = arm_of("one_axis")
    motions = plan_session(arm, [Table61(records=(1,), least=4.0, periods=1)])
    (recording,) = record(motions, SimulatedRig(arm=arm))
    u, dq = recording["motor.effort.j1"], recording["motor.velocity.j1"]
    fast = np.abs(dq) > 1.25
    friction = arm.robot.friction.steady_torque(dq[fast][:, None])[:, 0]
    np.testing.assert_allclose(u[fast], friction, atol=0.03)


def test_dwell_shows_in_the_recording_as_rests_of_the_motor():
    arm = arm_of("one_axis")
    motions = plan_session(arm, [DwellRestart(rests=(0.5, 1.0), run=0.5)])
    (recording,) = record(motions, SimulatedRig(arm=arm))
    rest = recording.mask(label="rest of 1 s")
    assert np.ptp(recording["motor.position.j1"][rest][200:]) < 1e-3


@pytest.mark.parametrize(
    ("protocols", "message"),
    [([], "There is nothing to record"), ([Circles()], "^Protocol circles on 'one_axis'")],
)
def test_a_session_that_cannot_be_is_refused(protocols, message):
    with pytest.raises(FFGymError, match=message):
        plan_session(arm_of("one_axis"), protocols)


def test_a_machine_whose_work_area_has_no_positions_yet_makes_small_motions_in_its_joints():
    robot = arm_of("two_link").robot
    assert robot.tool is not None
    assert robot.work_area is not None
    arm = RigidArm(replace(robot, work_area=replace(robot.work_area, positions={})))
    names = [motion.reference.name for motion in plan_session(arm, [DiagnosisMotions()])]
    assert {"diagnosis.slow_small", "diagnosis.fast_small"} <= set(names)
