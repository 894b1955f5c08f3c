"""What a robot description amounts to: against other ways to compute it, and slips that it must notice."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from ffgym.core.errors import FFGymError
from ffgym.robot import ModelOptions, RigidArm, RobotDraft, builtin_robots, load_draft, resonances
from ffgym.simulation.plant import Plant
from ffgym.studies.robot_check import check_robot, skeleton
from ffgym.studies.robot_check.doubts import list_doubts
from ffgym.studies.robot_check.shape import poses_in_range, tips

IRB = "irb4600_60_205"


@pytest.fixture(scope="module")
def check():
    return check_robot(load_draft(IRB))


def changed(factors) -> RobotDraft:
    """Draft of the built-in robot with numbers multiplied, by entry."""
    draft = load_draft(IRB)
    quantities = dict(draft.quantities)
    for path, factor in factors.items():
        quantities[path] = replace(quantities[path], value=quantities[path].value * factor)
    return replace(draft, quantities=quantities)


def without(*groups) -> RobotDraft:
    draft = load_draft(IRB)
    return replace(draft, quantities={p: q for p, q in draft.quantities.items() if p.split(".")[0] not in groups})


def test_the_built_in_robot_is_whole_and_nothing_about_it_is_doubtful(check, irb4600):
    assert check.draft.missing == ()
    assert check.doubts == ()
    assert not any(check.lacks.values())
    assert check.mass == pytest.approx(irb4600.bodies.mass.sum() + irb4600.tool.mass)


@pytest.mark.parametrize("name", builtin_robots())
def test_every_robot_that_ships_passes_its_own_check(name):
    found = check_robot(load_draft(name))
    assert found.doubts == ()
    assert found.servo.stable
    assert all(place.q is not None for place in found.places)


def test_gravity_is_that_of_the_arm_and_no_pose_is_worse(check, arm, corners):
    for name, q in corners.items():
        np.testing.assert_allclose(check.gravity.places[name], arm.gravity_torque(q[None])[0], atol=1e-6)
    rng = np.random.default_rng(1)
    low, high = arm.robot.kinematics.range.T
    others = np.abs(arm.gravity_torque(rng.uniform(low, high, (2000, 6)))).max(axis=0)
    assert np.all(others <= 1.03 * check.gravity.worst + 1e-9)


def test_springs_between_links_carry_their_share_of_gravity():
    draft = load_draft("kuka_kr300_r2500")
    with_spring, without_spring = check_robot(draft), check_robot(replace(draft, springs=()))
    arm = RigidArm(draft.complete())
    for place in with_spring.places:
        share = with_spring.gravity.places[place.name] - without_spring.gravity.places[place.name]
        np.testing.assert_allclose(share, arm.spring_torque(place.q[None])[0], atol=1e-6)
        assert np.abs(share[1]) > 100


def test_hinges_that_can_turn_on_are_sampled_over_one_turn(arm):
    q = poses_in_range(arm.robot, 500)
    assert np.all(np.ptp(q, axis=0) <= 2 * np.pi)
    assert np.all(np.ptp(q, axis=0) > 0.99 * np.minimum(np.ptp(arm.robot.kinematics.range, axis=1), 2 * np.pi))


def test_resonances_and_condition_are_those_at_the_places(check, arm, corners):
    for place in check.places:
        np.testing.assert_allclose(place.q, corners[place.name], atol=1e-6)
        assert place.condition == pytest.approx(np.linalg.cond(arm.jacobian(corners[place.name][None])[0]), rel=1e-6)
        for motors in ("locked", "free"):
            found = getattr(check.resonances[place.name], motors)
            np.testing.assert_allclose(found, resonances(arm, corners[place.name], motors), rtol=1e-6)


def test_the_reach_is_that_of_the_data_sheet_with_the_tool(check, arm):
    assert 2.051 + 0.2 < check.reach.distance < 2.051 + 0.135 + 0.3  # wrist centre, plus wrist and tool
    q = poses_in_range(arm.robot, 50)
    np.testing.assert_allclose(tips(arm.robot, q), arm.tcp_position(q), atol=1e-12)
    assert np.all(q >= arm.robot.kinematics.range[:, 0] - 1e-12)
    assert np.all(q <= arm.robot.kinematics.range[:, 1] + 1e-12)


def test_a_joint_accelerates_as_the_margin_says(irb4600, check):
    """Peak torque less gravity and breakaway, on the rotor and its share of the links."""
    drive, margin = irb4600.drive, check.margin
    links = np.diag(RigidArm(irb4600).mass_matrix(irb4600.work_area.home[None])[0])
    torque = drive.gear_ratio * margin.acceleration * (drive.rotor_inertia + links / drive.gear_ratio**2)
    np.testing.assert_allclose(torque + margin.gravity + irb4600.friction.static, drive.peak_torque)


def test_the_ellipsoid_of_a_uniform_box_has_its_inertia(irb4600):
    bones = skeleton(irb4600, np.zeros(6))
    for mass, half_axes, turn, inertia in zip(
        bones.mass, bones.half_axes, bones.principal_axes, irb4600.bodies.inertia, strict=False
    ):
        moments = mass / 5 * (half_axes @ half_axes - half_axes**2)
        xx, yy, zz, xy, xz, yz = inertia
        expected = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        np.testing.assert_allclose((turn * moments) @ turn.T, expected, atol=1e-6 * expected.max())


def shaken(robot, seconds=1.0):
    """Motor angles [rad] after a nudge of every motor at home, without friction, shape (S, 6)."""
    plant = Plant(robot, 1, options=ModelOptions(friction=False, looks=False), n_threads=1)
    home = robot.work_area.home[None]
    plant.rest(home)
    plant.batch.qvel[:] += 1e-6
    controls = np.zeros((1, round(seconds / robot.physics_dt), 18))
    plant.split_controls(controls)[0][:] = robot.drive.motor_angle(home)
    qpos, qvel, act = plant.advance(controls)
    return plant.unpack(qpos, qvel, act).motor_position[0] - robot.drive.motor_angle(home)


def test_the_gain_margin_is_where_the_simulation_starts_to_swing_by_itself(irb4600, check):
    servo = irb4600.servo

    def amplitude(factor):
        gains = {name: factor * getattr(servo, name) for name in ("position_gain", "velocity_gain", "integral_gain")}
        return np.abs(shaken(replace(irb4600, servo=replace(servo, **gains))))[-200:].max()

    assert amplitude(0.97 * check.servo.gain_margin) < 1e-7
    assert amplitude(1.03 * check.servo.gain_margin) > 1e-5  # and no more, as the drive saturates


def test_the_least_damped_oscillation_is_the_one_that_rings_longest(irb4600, check):
    dt, ringing = irb4600.physics_dt, shaken(irb4600)[1000:]
    joint = np.abs(ringing).max(axis=0).argmax()
    crossings = np.flatnonzero(np.diff(np.signbit(ringing[:, joint] - ringing[:, joint].mean())))
    frequency = 1 / (2 * np.diff(crossings).mean() * dt)
    damped = check.servo.frequency * np.sqrt(1 - check.servo.damping**2)
    assert frequency == pytest.approx(damped, rel=0.25)


def test_an_arm_without_drives_still_has_reach_gravity_and_resonances_of_nothing():
    found = check_robot(without("drive", "friction", "servo"))
    assert found.reach is not None
    assert found.gravity.worst[1] > 1000
    assert found.gravity.motor_worst is None
    assert (found.margin, found.inertia, found.servo, found.resonances) == (None,) * 4
    assert "drive.gear_ratio" in found.lacks["motor_torque"]


def test_a_robot_without_work_area_rests_at_zero_or_as_near_as_its_ranges_let_it():
    plain = without("work_area")
    assert check_robot(plain).rest.name == "q = 0"
    ranges = plain.quantities["kinematics.range"]
    beyond = replace(ranges, value=np.where(np.arange(6)[:, None] == 3, [[-3.0, -0.1]], ranges.value))
    found = check_robot(replace(plain, quantities=plain.quantities | {"kinematics.range": beyond}))
    assert found.rest.name == "q nearest to 0"
    np.testing.assert_array_equal(found.rest.q, [0, 0, 0, -0.1, 0, 0])
    assert found.gravity.places.keys() == {"q nearest to 0"}


def test_an_empty_description_is_checked_too():
    empty = replace(load_draft(IRB), quantities={}, geoms=())
    found = check_robot(empty)
    assert found.reach is None
    assert found.places == ()
    assert found.mass is None
    assert found.doubts == ()


@pytest.mark.parametrize(
    ("change", "doubt"),
    [
        ({"links.com": 1000.0}, "links.com: the centre of mass of frame is 115 m from its joint"),
        ({"links.inertia": 1000.0}, "links.inertia: mass and inertia of"),
        ({"links.inertia": 1e-5}, "denser than gold"),
        ({"simulation.gravity": 0.1}, "simulation.gravity is 0.981 m/s^2"),
        ({"drive.rotor_inertia": 1e4}, "drive.rotor_inertia of j1"),
        ({"drive.rotor_inertia": 1e-5}, "drive.rotor_inertia of j1"),
        ({"kinematics.max_speed": 180 / np.pi}, "kinematics.max_speed of j1: its motor would turn at"),
        ({"drive.joint_stiffness": 1e-4}, "gives a resonance of 0.0"),
        ({"drive.joint_stiffness": 100.0}, "drive.joint_stiffness gives a resonance of 2.99e+03 Hz"),
        ({"drive.joint_damping": 100.0}, "drive.joint_damping of j1 is 0.08 s x stiffness"),
        ({"drive.peak_torque": 0.01}, "friction.static of j1, 0.563 N m, is 225% of drive.peak_torque, 0.25 N m"),
        ({"drive.peak_torque": 0.3}, "drive.peak_torque of j2, 12 N m, cannot hold gravity, 15.9 N m"),
        ({"friction.bristle_stiffness": 1e-3}, "friction.bristle_stiffness of j1: it slips after 7.7 rad"),
        ({"friction.bristle_stiffness": 1e4, "friction.bristle_damping": 0.0}, "on its bristles"),
        ({"friction.viscous": 3.0}, "friction.viscous of j6 takes 427% of drive.peak_torque at the speed limit"),
        ({"friction.bristle_damping": 100.0}, "what friction and servo damp the rotor of"),
        ({"servo.velocity_gain": 15.0}, "what friction and servo damp the rotor of"),
        ({"simulation.physics_dt": 16.0}, "simulation.physics_dt = 0.004 s is long for the resonance of 30"),
    ],
)
def test_a_slip_is_noticed_and_named(change, doubt):
    doubts = list_doubts(changed(change))
    assert any(doubt in sentence for sentence in doubts), doubts
    assert all(sentence.split()[0].rstrip(":").split(".")[0] in sentence for sentence in doubts)


@pytest.mark.parametrize(
    ("change", "doubt"),
    [
        ({"drive.joint_stiffness": 1e-4}, "servo: the robot does not rest at home."),
        ({"servo.velocity_gain": 60.0}, "the loop is unstable"),
        ({"servo.velocity_gain": 15.0}, "times the gains are unstable"),
        ({"work_area.positions.p1": 3.0}, "work_area.positions.p1 cannot be worked at"),
    ],
)
def test_a_servo_or_a_place_that_does_not_work_is_a_doubt(change, doubt):
    found = check_robot(changed(change))
    assert any(doubt in sentence for sentence in found.doubts), found.doubts


SCALED = [path for path in load_draft(IRB).quantities if path.split(".")[0] in ("links", "drive", "friction", "servo")]


@settings(max_examples=6)
@given(
    st.dictionaries(st.sampled_from(SCALED), st.floats(-6, 6), min_size=1, max_size=4), st.sets(st.sampled_from(SCALED))
)
def test_any_numbers_and_any_gaps_are_checked(powers, gaps):
    draft = changed({path: 10.0**power for path, power in powers.items()})
    draft = replace(draft, quantities={path: q for path, q in draft.quantities.items() if path not in gaps})
    try:
        draft.check()
    except FFGymError:
        assume(False)  # e.g. static below Coulomb friction
    found = check_robot(draft)
    assert set(found.draft.missing) == gaps
    assert (found.servo is None) == bool(gaps)
