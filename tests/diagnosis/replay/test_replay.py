"""A replay of a simulated log gives what was simulated."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.replay import predict, replay
from ffgym.diagnosis.replay.states import deflect, flown, state_of
from ffgym.diagnosis.residual_rows import filter_measured, find_valid_rows
from ffgym.diagnosis.settings import settings
from ffgym.effects import EFFECTS, TorqueEffect
from ffgym.effects.along import torques_along
from ffgym.simulation.plant import Machine
from tests.diagnosis.replay.replay_samples import left, nominal, recorded, small, with_effect


@pytest.fixture(scope="module")
def recording():
    return recorded({"nominal": nominal()})["nominal"]


@pytest.fixture(scope="module")
def log(recording):
    return assemble_log(nominal().robot, [recording])


@pytest.mark.parametrize(("channel", "share"), [("torque", 5e-3), ("tool", 1e-3), ("link", 1e-3), ("servo", 0.15)])
def test_the_nominal_machine_leaves_hardly_anything_of_its_own_motion(channel, share, recording):
    log, rest = left([recording], nominal())
    inside = find_valid_rows(log)
    signal = filter_measured(log)[channel][inside]
    size = np.sqrt(np.mean((signal - signal.mean(axis=0)) ** 2))
    assert np.sqrt(np.mean(rest[channel][inside] ** 2)) < share * size


def test_what_another_replay_shares_changes_nothing(log):
    robot = nominal().robot
    first = replay(log, nominal())
    for name in ("coulomb_level", "backlash", "payload", "resolver_ripple"):
        machine = with_effect(small(EFFECTS[name], robot, share=0.3))
        alone, helped = replay(log, machine), replay(log, machine, first)
        np.testing.assert_allclose(alone.torque, helped.torque, rtol=0, atol=1e-10, err_msg=name)
        np.testing.assert_allclose(alone.link_q, helped.link_q, rtol=0, atol=1e-12, err_msg=name)


def test_masses_that_are_a_little_off_are_replayed_beside_the_described_ones(log):
    machine = with_effect(small(EFFECTS["payload"], nominal().robot, share=0.02))
    first = replay(log, nominal())
    alone, helped = replay(log, machine), replay(log, machine, first, beside=first)
    change = np.abs(alone.torque - first.torque).max()
    assert 0 < np.abs(alone.torque - helped.torque).max() < 1e-3 * change


def test_other_springs_are_replayed_with_shared_poses_of_the_links_to_second_order(log):
    machine = with_effect(small(EFFECTS["joint_stiffness"], nominal().robot, share=0.3))
    first = replay(log, nominal())
    alone, helped = replay(log, machine), replay(log, machine, first)
    change = np.abs(alone.torque - first.torque).max()
    assert 0 < np.abs(alone.torque - helped.torque).max() < 0.05 * change


def test_noise_of_the_motion_shows_alike_where_links_are_taken_from_the_motion_without_noise(log):
    near = replay(log, nominal())
    trembling = 1e-5 * np.random.default_rng(2).normal(size=log.q.shape)
    noisy = replace(log, q=log.q + trembling, ddq=log.ddq + 3e5 * trembling)
    alone, helped = replay(noisy, nominal()), replay(noisy, nominal(), nearby=near)
    assert helped.links is near.links
    change = np.abs(alone.torque - near.torque).max()
    assert 0 < np.abs(alone.torque - helped.torque).max() < 0.01 * change


def test_delay_and_lag_of_described_drives_are_replayed_as_those_of_the_effect():
    robot = nominal().robot
    path = {"torque_delay": np.full(2, 5e-4), "torque_lag": np.full(2, 2e-4)}
    real = replace(nominal(), robot=replace(robot, drive=replace(robot.drive, **path)))
    effect = with_effect(EFFECTS["torque_delay"].on(robot, delay=5e-4, lag=2e-4))
    recording = recorded({"real": real})["real"]
    sizes = {}
    for name, machine in (("ideal", nominal()), ("real", real), ("effect", effect)):
        log, rest = left([recording], machine)
        sizes[name] = np.sqrt(np.mean(rest["torque"][find_valid_rows(log)] ** 2))
    assert sizes["real"] == sizes["effect"]
    assert sizes["real"] < 0.3 * sizes["ideal"]


def test_an_effect_without_size_changes_nothing(log):
    exact = predict(replay(log, nominal()))
    for name in ("load_friction", "backlash", "torque_ripple", "tracker_clock", "payload"):
        null = small(EFFECTS[name], nominal().robot, share=0.0)
        for channel, rows in predict(replay(log, with_effect(null))).items():
            np.testing.assert_allclose(rows, exact[channel], rtol=0, atol=1e-9, err_msg=name)


def test_motions_side_by_side_are_replayed_as_each_alone(recording, log):
    shorter = recording.slice(end=0.8)
    other = replace(shorter, header=replace(shorter.header, segment="short"))
    both = replay(assemble_log(nominal().robot, [recording, other], like=log), nominal())
    np.testing.assert_allclose(both.torque[:, 0], replay(log, nominal()).torque[:, 0], atol=1e-9)


def test_an_arm_in_a_gap_begins_where_the_plant_lets_it_hang():
    for name, share in (("hardening", 0.3), ("backlash", 0.5)):
        machine = with_effect(small(EFFECTS[name], nominal().robot, share=share))
        log = assemble_log(nominal().robot, [recorded({name: machine})[name]])
        assert log.link is not None
        hangs = log.link[0, 0] - log.q[0, 0]
        run = replay(log, machine)
        np.testing.assert_allclose(run.deflection.angle[0, 0], hangs, atol=2e-2 * np.abs(hangs).max(), err_msg=name)


def test_a_payload_lowers_the_tool_and_takes_torque(log):
    laden = Machine(robot=log.robot, effects=(EFFECTS["payload"].on(log.robot, mass=2.0),))
    empty, full = predict(replay(log, nominal())), predict(replay(log, laden))
    first = int(np.argmax(find_valid_rows(log)[:, 0]))
    assert full["tool"][first, 0, 2] < empty["tool"][first, 0, 2]
    assert np.abs(full["torque"]).mean() > np.abs(empty["torque"]).mean()


def test_effects_that_follow_the_motor_do_not_see_how_joints_bend(log):
    """As each of them says of itself, which spares going from sample to sample."""
    state = replay(log, nominal()).state
    further = state.with_values(deflection=state.deflection + 1e-4, deflection_rate=state.deflection_rate + 1e-3)
    behind = {kind for kind in EFFECTS.values() if issubclass(kind, TorqueEffect) and kind.side == "link"}
    for kind in behind:
        effect = small(kind, nominal().robot, share=0.3)
        added, other = (torques_along(effect, one, log.dt) for one in (state, further))
        parts = [(x, y) for x, y in ((added.spring, other.spring), (added.link, other.link)) if x is not None]
        assert parts, kind.name
        assert all(np.array_equal(x, y) for x, y in parts) == kind.follows_motor, kind.name
    assert any(kind.follows_motor for kind in behind)


def test_a_joint_bends_at_once_as_sample_by_sample_under_what_follows_its_motor():
    robot = nominal().robot
    log = assemble_log(
        robot, [recorded({"nominal": nominal()}, sample_dt=settings().replay.spring_step)["nominal"]]
    )  # a step of springs per sample
    effects = [small(EFFECTS[name], robot, share=0.5) for name in ("kinematic_error", "hardening")]
    run = replay(log, nominal())
    state = state_of(log, nominal(), run.bristles)
    load, start = -run.links.torque(log.ddq), run.deflection.angle[0]
    for some in (effects[:1], effects):
        at_once = deflect(run.springs, state, some, load, start, log.dt)
        each = flown(run.springs, state, some, load, start, log.dt)
        for part in ("angle", "rate", "acceleration"):
            one, other = getattr(at_once, part), getattr(each, part)
            np.testing.assert_allclose(one, other, rtol=0, atol=1e-9 * np.abs(other).max(), err_msg=part)


def test_an_exact_replay_balances_links_where_they_bend_to_the_square_of_what_slopes_leave(recording):
    robot = nominal().robot
    drive = replace(robot.drive, joint_stiffness=0.05 * robot.drive.joint_stiffness)
    soft, missed = replace(nominal(), robot=replace(robot, drive=drive)), []
    log = assemble_log(soft.robot, [recording])
    for exact in (False, True):
        run = replay(log, soft, exact=exact)
        load = -(drive.joint_stiffness * run.deflection.angle + drive.joint_damping * run.deflection.rate)
        missed.append(np.abs(run.own_link_torque - load)[50:].max() / np.abs(load).max())
    assert missed[0] > 1e-3
    assert missed[1] < 0.1 * missed[0]
