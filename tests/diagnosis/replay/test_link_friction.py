"""Friction behind the elasticity in a replay: the engine's log, small changes of it, and links too light for steps."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.perturbation import perturb, perturb_numbers, propagate
from ffgym.diagnosis.replay import predict, replay
from ffgym.diagnosis.replay.rows import bend_with_shares, lends_deflection
from ffgym.diagnosis.replay.springs import Springs
from ffgym.diagnosis.replay.states import along_links, flown
from ffgym.diagnosis.residual_rows import find_valid_rows
from ffgym.diagnosis.variant import add_effect
from ffgym.effects import EFFECTS, State
from ffgym.effects.transmission.arm_friction import LinkFriction
from tests.diagnosis.replay.replay_samples import left, nominal, recorded, with_effect

SHARE = 0.73


@pytest.fixture(scope="module")
def behind():
    return with_effect(EFFECTS["arm_friction"].on(nominal().robot, share=SHARE))


@pytest.fixture(scope="module")
def recording(behind):
    return recorded({"behind": behind})["behind"]


def rms_left(recording, machine):
    log, rest = left([recording], machine)
    inside = find_valid_rows(log)
    return {channel: np.sqrt(np.mean(rest[channel][inside] ** 2)) for channel in ("torque", "tool", "link")}


def test_a_replay_with_the_true_share_leaves_hardly_anything(recording, behind):
    without, true = rms_left(recording, nominal()), rms_left(recording, behind)
    assert true["tool"] < 0.03 * without["tool"]
    assert true["link"] < 0.03 * without["link"]
    assert true["torque"] < 0.02 * nominal().robot.friction.coulomb.max()


def test_the_share_of_a_description_is_replayed_as_that_of_the_effect(recording, behind):
    described = nominal().with_robot(behind.physical)
    log = assemble_log(nominal().robot, [recording])
    one, other = replay(log, behind), replay(log, described)
    np.testing.assert_array_equal(one.torque, other.torque)
    np.testing.assert_array_equal(one.link_q, other.link_q)


def test_a_little_more_of_it_changes_a_replay_as_its_slope_says(recording):
    log, robot = assemble_log(nominal().robot, [recording]), nominal().robot
    run = replay(log, nominal())
    effect = EFFECTS["arm_friction"].on(robot, share=0.01)
    parts = propagate(run, [perturb(run, effect)])[0]
    before, after = predict(run), predict(replay(log, with_effect(effect)))
    inside = find_valid_rows(log)
    for k in (0, 2):
        change = (after["tool"] - before["tool"])[..., k][inside]
        assert np.sqrt(np.mean((change - parts["tool", k][inside]) ** 2)) < 0.15 * np.sqrt(np.mean(change**2))


@pytest.mark.parametrize("joint", [0, 1])
def test_more_friction_of_one_joint_on_both_sides_changes_a_replay_as_its_slope_says(recording, behind, joint):
    log, friction = assemble_log(nominal().robot, [recording]), behind.physical.friction
    run = replay(log, nominal().with_robot(behind.physical))
    more = np.where(np.arange(friction.n_joints) == joint, 1.02, 1.0)
    other = replace(run.robot, friction=friction.scale(coulomb=more, static=more, viscous=more))
    parts = propagate(run, [perturb_numbers(run, other)])[0]
    before, after = predict(run), predict(replay(log, nominal().with_robot(other)))
    inside = find_valid_rows(log)
    for channel, k in (("torque", joint), ("link", joint)):
        change = (after[channel] - before[channel])[..., k][inside]
        assert np.sqrt(np.mean((change - parts[channel, k][inside]) ** 2)) < 0.25 * np.sqrt(np.mean(change**2))


def test_machines_with_several_shares_bend_side_by_side_as_each_would_by_itself(recording, behind):
    run = replay(assemble_log(nominal().robot, [recording]), nominal())
    machines = [
        with_effect(EFFECTS["arm_friction"].on(nominal().robot, share=np.array(s))) for s in ((0.4, 0), (0, 0.9))
    ]
    for machine, bent in zip(machines, bend_with_shares(run, machines), strict=True):
        alone = replay(run.log, machine, run).deflection
        for name in ("angle", "rate", "braking"):
            there, expected = getattr(bent, name), getattr(alone, name)
            np.testing.assert_allclose(there, expected, rtol=1e-3, atol=1e-3 * np.abs(expected).max())


def test_machines_that_differ_by_more_than_shares_are_bent_by_themselves(recording, behind):
    run = replay(assemble_log(nominal().robot, [recording]), nominal())
    loaded = with_effect(EFFECTS["arm_load_friction"].on(nominal().robot, share=0.02))
    assert bend_with_shares(run, [behind, loaded]) == [None, None]


def test_a_replay_lends_its_deflection_to_machines_whose_links_have_the_same_friction(recording, behind):
    log = assemble_log(nominal().robot, [recording])
    run, drive = replay(log, behind), nominal().robot.drive
    stiffer = replace(nominal().robot, drive=replace(drive, joint_stiffness=2 * drive.joint_stiffness))
    late = add_effect(behind, EFFECTS["tracker_clock"].on(nominal().robot, latency=0.01, drift=0.0))
    assert lends_deflection(run, log, late)
    assert not lends_deflection(run, log, nominal())
    assert not lends_deflection(run, log, behind.with_robot(stiffer))


@pytest.mark.parametrize("other", ["share", "stiffness", "friction", "gear"])
def test_friction_of_motors_is_taken_from_a_replay_where_it_is_the_same(recording, behind, other):
    log, robot = assemble_log(nominal().robot, [recording]), nominal().robot
    drive, friction = robot.drive, robot.friction
    machine = {
        "share": behind,
        "stiffness": nominal().with_robot(
            replace(robot, drive=replace(drive, joint_stiffness=2 * drive.joint_stiffness))
        ),
        "friction": nominal().with_robot(replace(robot, friction=friction.scale(coulomb=0.9))),
        "gear": nominal().with_robot(replace(robot, drive=replace(drive, gear_ratio=1.1 * drive.gear_ratio))),
    }[other]
    run = replay(log, nominal())
    found, alone = replay(log, machine, run), replay(log, machine)
    assert (found.bristles.whole is run.bristles.whole) == (other in ("share", "stiffness"))
    for name in ("torque", "whole", "sign"):
        np.testing.assert_array_equal(getattr(found.bristles, name), getattr(alone.bristles, name))


@pytest.mark.parametrize("light", [1e-3, 3.0])
def test_links_that_creep_behind_their_motors_stick_until_the_spring_tears_them_off(light):
    """The motor turns slowly forth: the spring winds up by friction over stiffness, and the link follows."""
    robot, dt = nominal().robot.with_arm_share(SHARE), 0.002
    t, stiffness = dt * np.arange(2000), robot.drive.joint_stiffness
    speed = np.broadcast_to(0.02 * np.minimum(t / 0.2, 1.0)[:, None, None], (2000, 1, 2))
    springs = Springs(mass=np.broadcast_to(light * np.eye(2), (2000, 1, 2, 2)), stiffness=stiffness,
                      damping=robot.drive.joint_damping, dt=dt)  # fmt: skip
    angle = np.cumsum(speed, axis=0) * dt
    none = np.zeros_like(speed)
    state = State.of(robot, time=t[:, None, None], joint_angle=angle, joint_speed=speed,
                     deflection=none, deflection_rate=none)  # fmt: skip
    bent = flown(springs, state, [LinkFriction.of(robot)], none, none[0], dt)
    steady = SHARE * robot.drive.gear_ratio * robot.friction.steady_torque(robot.drive.gear_ratio * 0.02)
    np.testing.assert_allclose(bent.angle[-1, 0], -steady / stiffness, rtol=0.02)
    np.testing.assert_allclose(bent.braking[-1, 0], -steady, rtol=0.02)
    # bristles along the motion that was found pull as they did in its steps
    along = SHARE * robot.drive.gear_ratio * along_links(robot, speed + bent.rate, dt).torque
    assert np.sqrt(np.mean((along + bent.braking) ** 2)) < 0.05 * np.abs(steady).max()


def test_friction_on_links_that_stays_bends_joints_no_second_time(recording, behind):
    log = assemble_log(nominal().robot, [recording])
    first = replay(log, nominal().with_robot(behind.physical))
    more = replace(first.machine, effects=(EFFECTS["cogging"].on(nominal().robot, amplitude=0.01, cycles=4.0),))
    again = replay(log, more, first)
    assert again.deflection is first.deflection
    np.testing.assert_allclose(again.torque, replay(log, more).torque, rtol=0, atol=1e-12)
    other = replay(log, behind, replay(log, nominal()))
    np.testing.assert_array_equal(other.deflection.angle, first.deflection.angle)


def test_a_light_link_behind_a_motor_that_trembles_sticks_after_a_motion():
    """Bristles that turn back within a step: steps with slopes about expected rates alone rang, at several rad/s."""
    robot, dt, n = nominal().robot.with_arm_share(SHARE), 0.002, 1500
    robot = replace(
        robot,
        drive=replace(
            robot.drive,
            joint_stiffness=0.1 * robot.drive.joint_stiffness,
            joint_damping=0.1 * robot.drive.joint_damping,
        ),
    )
    t, drive = dt * np.arange(n), robot.drive
    swing = 0.1 * (1 - np.cos(4 * np.pi * np.minimum(t, 1.5)))[:, None, None]
    angle = swing + 1e-6 * np.random.default_rng(0).standard_normal((n, 1, 2))
    speed, none = np.gradient(angle, dt, axis=0), np.zeros_like(angle)
    mass = 1e-5 * np.diag(drive.joint_stiffness)
    springs = Springs(
        mass=np.broadcast_to(mass, (n, 1, 2, 2)), stiffness=drive.joint_stiffness, damping=drive.joint_damping, dt=dt
    )
    given = {"time": t[:, None, None], "joint_angle": angle, "joint_speed": speed}
    state = State.of(robot, **given, deflection=none, deflection_rate=none)
    bent = flown(springs, state, [LinkFriction.of(robot)], -np.gradient(speed, dt, axis=0) @ mass, none[0], dt)
    assert np.abs(speed + bent.rate)[900:].max() < 0.01
