"""Torque loops of drives: lag and rate limit as their equations say, what is refused, and old models without them."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.control import NoCompensation
from ffgym.core.errors import FFGymError
from ffgym.robot import RigidArm, build_spec, load_robot, mjcf_text
from ffgym.robot.drive import loop_decay, next_torque
from ffgym.robot.model.names import servo_actuator
from ffgym.simulation import Run, simulate
from ffgym.simulation.export import export_run
from ffgym.simulation.export.play import main as play
from ffgym.simulation.plant import Plant
from ffgym.studies import circle_references
from tests.simulation.plant.driving import controls

DT = 0.00025
LAG = 4e-4
RATE = 800.0


def with_loop(robot, **numbers):
    """The robot with the same numbers of its torque loop on all joints."""
    full = {name: np.full(robot.n_joints, value) for name, value in numbers.items()}
    return replace(robot, drive=replace(robot.drive, **full))


def without_servo(robot):
    """A motor that gets its feed-forward torque alone."""
    none = np.zeros(robot.n_joints)
    return replace(robot, servo=replace(robot.servo, position_gain=none, velocity_gain=none, integral_gain=none))


def torques(robot, commands):
    """Torques that servos give for commanded torques (T, N), (T, N): each over its physics step."""
    plant = Plant(robot, 1)
    plant.rest(np.zeros((1, robot.n_joints)))
    force = plant.batch.bind("actuator_force")
    servos = [plant.model.actuator(servo_actuator(joint)).id for joint in robot.joints]
    found = []
    for row in controls(plant, torque=commands):
        plant.drive(row[None, None])
        found.append(force[0, servos].copy())
    return np.array(found)


@pytest.fixture(scope="module")
def joint():
    return without_servo(load_robot("one_axis"))


def test_a_torque_step_is_answered_by_the_exponential_of_the_lag(joint):
    given = torques(with_loop(joint, torque_lag=LAG), np.ones((40, 1)))
    t = np.arange(1, 41) * DT
    np.testing.assert_allclose(given[:, 0], 1 - np.exp(-t / LAG), rtol=1e-12)


def test_a_sine_at_the_bandwidth_is_down_by_3_db_and_45_degrees(joint):
    lag = 1 / (2 * np.pi * 100.0)
    t = np.arange(8000) * DT
    given = torques(with_loop(joint, torque_lag=lag), np.sin(2 * np.pi * 100 * t)[:, None])[4000:, 0]
    phase = np.exp(-2j * np.pi * 100 * t[4000:])
    response = 2 * np.mean(given * phase) * 1j
    # commands are held over a step, which is half a step of delay; the force is that at the step's end
    expected = np.exp(1j * 2 * np.pi * 100 * DT / 2) / (1 + 1j)
    assert abs(response - expected) < 0.01


def test_a_torque_rate_is_what_a_large_step_rises_by(joint):
    peak = joint.drive.peak_torque[0]
    given = torques(with_loop(joint, torque_rate=RATE), np.full((40, 1), 2 * peak))
    np.testing.assert_allclose(given[:, 0], np.minimum(RATE * DT * np.arange(1, 41), peak), rtol=1e-9)


def test_lag_and_rate_are_one_equation_for_engine_and_effects(joint):
    rng = np.random.default_rng(1)
    commands = np.cumsum(rng.normal(scale=0.3, size=(400, 1)), axis=0)
    peak, expected, torque = joint.drive.peak_torque, [], np.zeros(1)
    for command in np.clip(commands, -peak, peak):
        torque = next_torque(torque, command, loop_decay(np.array([LAG]), DT), np.array([RATE * DT]))
        expected.append(torque)
    given = torques(with_loop(joint, torque_lag=LAG, torque_rate=RATE), commands)
    np.testing.assert_allclose(given, expected, atol=1e-9)
    steps = np.abs(np.diff(given, axis=0))
    assert 0.05 < np.mean(steps > 0.999 * RATE * DT) < 0.95, "both the lag and the limit act"


def test_a_torque_loop_leaves_its_peak_as_soon_as_the_command_does(joint):
    peak = joint.drive.peak_torque[0]
    commands = np.r_[np.full(40, 5 * peak), np.zeros(10)][:, None]
    given = torques(with_loop(joint, torque_lag=LAG), commands)[40:, 0]
    np.testing.assert_allclose(given, peak * np.exp(-np.arange(1, 11) * DT / LAG), rtol=1e-6)


def test_a_loop_that_changes_nothing_is_none_and_the_old_model(irb4600):
    ideal = with_loop(irb4600, torque_lag=0.0, torque_rate=np.inf)
    assert ideal.drive.torque_lag is None
    assert ideal.drive.torque_rate is None
    assert Plant(ideal, 1).fingerprint() == Plant(irb4600, 1).fingerprint()
    assert Plant(with_loop(irb4600, torque_lag=LAG), 1).fingerprint() != Plant(irb4600, 1).fingerprint()


def test_one_joint_may_have_a_loop_and_another_none(irb4600):
    lag = np.array([0.0, LAG, 0.0, 0.0, 0.0, LAG])
    commands = np.ones((1, 6))
    given = torques(without_servo(replace(irb4600, drive=replace(irb4600.drive, torque_lag=lag))), commands)
    np.testing.assert_allclose(given[0], [1, 1 - np.exp(-DT / LAG), 1, 1, 1, 1 - np.exp(-DT / LAG)], rtol=1e-9)


def test_a_short_lag_leaves_the_motion_nearly_as_it_is(irb4600, arm):
    run = Run(reference=circle_references(arm, ["p1"], [0.1], [0.001])["p1", 0.1], law=NoCompensation())
    old, tiny, slow = (
        simulate([run], arm=arm, machine=robot)[0].joint_array("motor.position")
        for robot in (irb4600, with_loop(irb4600, torque_rate=1e9), with_loop(irb4600, torque_lag=LAG))
    )
    assert np.abs(tiny - old).max() < 1e-9
    assert np.abs(slow - old).max() > 1e-5


def test_robots_with_other_loops_do_not_share_a_batch(irb4600):
    plant = Plant(irb4600, 2)
    with pytest.raises(FFGymError, match=r"torque loops.*a batch of its own"):
        plant.become([1], [with_loop(irb4600, torque_lag=LAG)])
    one, other = (
        replace(irb4600, drive=replace(irb4600.drive, torque_lag=np.where(np.arange(6) == j, LAG, 0.0))) for j in (0, 5)
    )
    with pytest.raises(FFGymError, match="torque loops"):
        Plant(one, 2).become([1], [other])


def test_robots_of_a_batch_have_their_own_lags(irb4600, arm):
    run = Run(reference=circle_references(arm, ["p1"], [0.1], [0.001])["p1", 0.1], law=NoCompensation())
    robots = [with_loop(irb4600, torque_lag=lag) for lag in (LAG, 2 * LAG)]
    together = simulate([run, run], arm=arm, machine=robots)
    alone = [simulate([run], arm=arm, machine=robot)[0] for robot in robots]
    for one, other in zip(together, alone, strict=True):
        np.testing.assert_array_equal(one.joint_array("motor.position"), other.joint_array("motor.position"))


def test_a_robot_with_a_loop_starts_at_rest(irb4600):
    plant = Plant(with_loop(irb4600, torque_lag=LAG, torque_rate=RATE), 1)
    home = irb4600.work_area.home
    plant.rest(home[None])
    before = plant.state().link_position
    plant.drive(np.tile(controls(plant, irb4600.drive.motor_angle(home)), (1, 400, 1)))
    assert np.abs(plant.state().link_position - before).max() < 1e-12


@pytest.mark.parametrize(
    "numbers", [{"torque_lag": LAG}, {"torque_rate": RATE}, {"torque_lag": LAG, "torque_rate": RATE}]
)
def test_an_exported_loop_is_the_same_model_and_plays_the_same_motion(irb4600, arm, numbers, tmp_path, capsys):
    robot = with_loop(irb4600, **numbers)
    assert "dcmotor" in mjcf_text(build_spec(robot))  # which raises if the text is another model
    reference = circle_references(RigidArm(robot), ["p1"], [0.1], [0.001])["p1", 0.1]
    export_run(tmp_path / "out", Run(reference=reference, law=NoCompensation()))
    assert play(tmp_path / "out") == 0, capsys.readouterr().out


@pytest.mark.parametrize("name", ["torque_lag", "torque_rate"])
def test_impossible_numbers_of_a_loop_are_one_error(irb4600, name):
    with pytest.raises(FFGymError, match=rf"drive.{name} .*joint"):
        with_loop(irb4600, **{name: -1.0})
    with pytest.raises(FFGymError, match=rf"drive.{name}"):
        with_loop(irb4600, **{name: np.nan})
