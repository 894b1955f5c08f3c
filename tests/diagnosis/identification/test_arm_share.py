"""Share of friction behind the elasticity: given back from constant speeds with a tracker or link encoders."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis.identification.arm_share import NOT_MEASURED, identify_arm_share
from ffgym.diagnosis.identification.friction import friction_quantities, identify_friction
from ffgym.diagnosis.identification.friction_data import friction_torque
from ffgym.diagnosis.identification.parameter_file import parameter_text
from ffgym.effects.transmission.backlash import Backlash
from ffgym.effects.transmission.hysteresis import TorsionalHysteresis
from ffgym.recordings import Recording
from ffgym.robot import RigidArm, load_robot, with_parameters
from ffgym.simulation import Machine, Resolver, SimulatedRig, TorqueSensor
from ffgym.simulation.protocols import plan_session, record
from ffgym.simulation.protocols.one_by_one import SlowTriangles, SpeedLadder
from ffgym.simulation.sensors import measure, sensors_of

SHARES = (0.0, 0.4, 0.73)
IN_EVERY_RUN = ((0.0, "encoder"), (0.4, "tracker"))
"""Shares and sensors of the usual tests."""
SPEEDS = (0.2, 1.0, 4.0)
"""Motor speeds of a short ladder [rad/s]."""
ENCODER_NOISE = 1e-5
"""Of an encoder behind the gearbox [rad]."""


@pytest.fixture(scope="module")
def arm():
    return RigidArm(load_robot("two_link"))


def run(arm, protocol, share, effects=()):
    """Exact recordings of a protocol, with a part of the friction of all joints behind their springs, and effects."""
    machine = Machine(robot=arm.robot.with_arm_share(share), effects=effects)
    rig = SimulatedRig(arm=arm, machine=machine, sensors=())
    return list(record(plan_session(arm, [protocol]), rig, record_dt=2e-3))


def seen(arm, recordings, seed, sensor="tracker"):
    """Friction along recordings as sensors see them: resolvers, torques, and a tracker, link encoders or neither."""
    torques = []
    for recording, rng in zip(recordings, np.random.default_rng(seed).spawn(len(recordings)), strict=True):
        sensors = sensors_of(arm.robot) if sensor == "tracker" else (Resolver(bits=16),)
        made = measure(recording, (*sensors, TorqueSensor(noise=np.full(2, 0.05))), rng)
        if sensor == "encoder":
            links = {f"link.position.{joint}": recording[f"link.position.{joint}"] for joint in arm.robot.joints}
            noisy = {name: x + ENCODER_NOISE * rng.normal(size=len(x)) for name, x in links.items()}
            made = Recording(columns=dict(made.columns) | noisy, header=made.header)
        torques.append(friction_torque(arm, made))
    return torques


def identify(torques, joint=0, spread=0.0, n_resamples=60, seed=0):
    robot = torques[0].signals.robot
    presliding = float(robot.friction.static[joint] / robot.friction.bristle_stiffness[joint])
    rng = np.random.default_rng(seed)
    return identify_arm_share(
        torques, robot, joint, presliding, rng, stiffness_spread=spread, n_resamples=n_resamples, level=0.9
    )


LADDER = SpeedLadder(joints=["shoulder"], speeds=SPEEDS, longest=2.0)


@pytest.fixture(scope="module")
def ladders(arm):
    """Exact ladders of the shoulder by the share behind the springs of both joints."""
    return {share: run(arm, LADDER, share) for share in SHARES}


@pytest.mark.parametrize(
    ("share", "sensor"),
    [
        pytest.param(share, sensor, marks=[pytest.mark.slow] * ((share, sensor) not in IN_EVERY_RUN))
        for share in SHARES
        for sensor in ("tracker", "encoder")
    ],
)
def test_intervals_hold_the_share(arm, ladders, share, sensor):
    draws, errors, inside = 10, [], 0
    for seed in range(draws):
        estimate = identify(seen(arm, ladders[share], seed, sensor), seed=seed).estimate
        assert estimate.status == "identified"
        assert estimate.high - estimate.low < 0.05
        errors.append(estimate.value - share)
        inside += estimate.low <= share <= estimate.high
    # of 10 intervals that hold it nine times of ten, fewer than 7 do so with a probability of 1 %
    assert inside >= 7
    assert np.abs(errors).max() < 0.02


def test_without_a_sensor_behind_the_spring_it_cannot_be_told(arm, ladders):
    found = identify(seen(arm, ladders[0.73], 0, "neither"))
    assert found.fit is None
    assert (found.estimate.status, found.estimate.reason) == ("not measured", NOT_MEASURED)
    assert (found.estimate.value, found.estimate.low, found.estimate.high) == (0.0, 0.0, np.inf)
    for words in ("tracker", "link.position", "slow_triangles", "speed_ladder"):
        assert words in NOT_MEASURED


def test_a_tracker_carries_the_uncertainty_of_the_stiffness_into_the_interval(arm, ladders):
    torques = seen(arm, ladders[0.4], 0)
    exact, unsure = identify(torques), identify(torques, spread=0.2, n_resamples=300)
    assert unsure.fit.share == pytest.approx(exact.fit.share, rel=1e-3)
    # s / K is what deflections tell, so that s is as uncertain as K
    width = (unsure.estimate.high - unsure.estimate.low) / (2 * unsure.fit.share)
    assert width == pytest.approx(1.1 * 1.645 * 0.2, rel=0.15)


def test_an_encoder_tells_a_wrong_stiffness_from_the_load_and_a_tracker_covers_it(arm, ladders):
    drive = arm.robot.drive
    wrong = RigidArm(replace(arm.robot, drive=replace(drive, joint_stiffness=0.8 * drive.joint_stiffness)))
    by_encoder = identify(seen(wrong, ladders[0.4], 0, "encoder"), spread=0.3)
    assert by_encoder.fit.stiffness[0] == pytest.approx(drive.joint_stiffness[0], rel=0.03)
    assert by_encoder.estimate.low <= 0.4 <= by_encoder.estimate.high
    by_tracker = identify(seen(wrong, ladders[0.4], 0), spread=0.3)
    assert by_tracker.fit.share == pytest.approx(0.8 * 0.4, abs=0.02)
    assert by_tracker.estimate.low <= 0.4 <= by_tracker.estimate.high


def test_triangles_of_one_speed_leave_a_late_sensor_as_a_rival(arm):
    found = identify(seen(arm, run(arm, SlowTriangles(joints=["shoulder"], sizes=(2.0,)), 0.73), 0))
    assert found.estimate.low <= 0.73 <= found.estimate.high
    assert found.estimate.high - found.estimate.low > 0.4
    (note,) = found.notes
    assert "late" in note


def test_triangles_of_three_speeds_tell_the_delay(arm):
    triangles = SlowTriangles(joints=["shoulder"], sizes=(2.0,), speeds=(0.2, 2.0))
    found = identify(seen(arm, run(arm, triangles, 0.73), 0))
    assert found.estimate.low <= 0.73 <= found.estimate.high
    assert found.estimate.high - found.estimate.low < 0.05
    assert not found.notes


def test_a_joint_of_a_six_axis_robot_is_measured_beside_two_others_that_bend():
    arm = RigidArm(load_robot("irb4600_60_205"))
    machine = Machine(robot=arm.robot.with_arm_share([0.73, 0.73, 0.73, 0.0, 0.0, 0.0]))
    rig = SimulatedRig(arm=arm, machine=machine, sensors=())
    ladder = SpeedLadder(joints=["j2"], speeds=SPEEDS, longest=2.0)
    (exact,) = record(plan_session(arm, [ladder]), rig, record_dt=2e-3)
    made = measure(exact, sensors_of(arm.robot), np.random.default_rng(0))
    found = identify([friction_torque(arm, made)], joint=1)
    assert found.fit.share == pytest.approx(0.73, abs=0.02)


def test_the_other_joints_of_the_arm_do_not_pass_for_the_one_that_moves(arm):
    elbow = SpeedLadder(joints=["elbow"], speeds=SPEEDS, longest=2.0)
    found = identify(seen(arm, run(arm, elbow, 0.73), 0), joint=1)
    assert found.fit.share == pytest.approx(0.73, abs=0.02)
    resting = identify(seen(arm, run(arm, elbow, 0.73), 0), joint=0)
    assert (resting.fit, resting.estimate.status) == (None, "not excited")


def test_torsional_hysteresis_alone_is_no_friction_on_the_arm(arm):
    slipping = TorsionalHysteresis(lost_motion=np.array([1e-4, 0.0]), width=np.array([3e-4, 3e-4]))
    estimate = identify(seen(arm, run(arm, LADDER, 0.0, (slipping,)), 0)).estimate
    assert estimate.low == 0.0
    assert estimate.high < 0.05


@pytest.fixture(scope="module")
def floating():
    """The arm without gravity, so that nothing closes a gap."""
    robot = load_robot("two_link")
    return RigidArm(replace(robot, gravity=np.zeros(3)))


def test_a_gap_under_load_is_no_friction_and_one_without_load_is_doubted(arm, floating, ladders):
    gap = (Backlash(half_gap=np.array([4e-5, 0.0])),)
    loaded = identify(seen(arm, run(arm, LADDER, 0.4, gap), 0))
    assert loaded.fit.share == pytest.approx(identify(seen(arm, ladders[0.4], 0)).fit.share, abs=1e-3)
    assert not loaded.fit.unloads
    assert not loaded.notes
    free = identify(seen(floating, run(floating, LADDER, 0.4, gap), 0))
    assert free.estimate.low > 0.6
    (note,) = free.notes
    assert "gap" in note


def test_more_lost_motion_than_all_friction_makes_is_another_fault(floating):
    gap = (Backlash(half_gap=np.array([1.5e-4, 0.0])),)
    found = identify(seen(floating, run(floating, LADDER, 0.73, gap), 0))
    assert found.estimate.status == "at bound"
    assert found.estimate.value == 0.0
    assert "gap" in found.estimate.reason


def test_the_share_is_in_the_description_and_in_the_parameter_file(arm, ladders, tmp_path):
    found = identify_friction(
        seen(arm, ladders[0.73], 0), joints=["shoulder"], stiffness_spread=0.05, n_resamples=40, seed=0
    )
    shoulder, elbow = found.joints
    assert shoulder.arm.estimate.status == "identified"
    assert elbow.arm is None
    np.testing.assert_array_equal(found.robot.arm_share, [shoulder.arm.estimate.value, 0.0])
    quantities = friction_quantities(found)
    path = tmp_path / "parameters.toml"
    path.write_text(parameter_text(arm.robot, quantities, "identified"))
    robot = with_parameters(arm.robot, path)
    quantity = robot.quantities["friction.arm_share"]
    np.testing.assert_array_equal(robot.arm_share, found.robot.arm_share)
    assert quantity.origin == ("fitted", "chosen")
    assert quantity.interval[0, 0] <= 0.73 <= quantity.interval[0, 1]
    np.testing.assert_array_equal(quantity.prior, [0.0, 0.0])


def test_a_stiffness_with_an_interval_needs_no_spread(arm, ladders):
    stiffness = arm.robot.quantities["drive.joint_stiffness"]
    known = replace(stiffness, interval=np.stack([0.9 * stiffness.value, 1.1 * stiffness.value], axis=1))
    robot = replace(arm.robot, quantities=dict(arm.robot.quantities) | {"drive.joint_stiffness": known})
    torques = seen(RigidArm(robot), ladders[0.4], 0)
    estimates = [identify(torques, spread=spread).estimate for spread in (None, 0.1 / 1.645)]
    assert estimates[0].low == pytest.approx(estimates[1].low, abs=1e-9)
    assert estimates[0].high == pytest.approx(estimates[1].high, abs=1e-9)
