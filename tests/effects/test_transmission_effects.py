"""Effects between motor and link: energy, loops, gaps, and what a base does."""

import mujoco
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.nominal import example_logs
from ffgym.effects import EFFECTS, torques_along
from ffgym.paths import joint_reference, multisine
from ffgym.robot import ModelOptions, RigidArm
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Machine, Plant
from tests.effects.effect_samples import as_strong_as_plausible, state_of, torques_at


def resting(machine, q):
    """Deflections [rad] of a machine at rest, (N,)."""
    plant = Plant(machine, 1, n_threads=1)
    plant.rest(q[None])
    state = plant.state()
    return (state.link_position - machine.robot.drive.joint_angle(state.motor_position))[0]


@pytest.mark.parametrize("name", ["hardening", "backlash", "kinematic_error"])
def test_a_loop_through_motor_angle_and_deflection_takes_no_energy(name, irb4600):
    effect = as_strong_as_plausible(EFFECTS[name], irb4600)
    phase = np.linspace(0, 2 * np.pi, 20001)[:, None]
    deflection, angle = 1e-3 * np.sin(phase), 0.7 * np.sin(phase + 1.0)
    stiffness = irb4600.drive.joint_stiffness
    state = state_of(irb4600, deflection=deflection, motor_angle=angle, load=-stiffness * deflection)
    added = torques_at(effect, state)
    motor = np.zeros_like(state.load) if added.motor is None else added.motor
    work = np.trapezoid(added.spring, state.deflection, axis=0) + np.trapezoid(motor, state.motor_angle, axis=0)
    swing = np.ptp(added.spring, axis=0) * np.ptp(state.deflection, axis=0)
    assert np.all(np.abs(work) < 1e-6 * swing)


def test_the_loop_of_torsional_hysteresis_has_its_area_at_any_speed(irb4600):
    effect = EFFECTS["torsional_hysteresis"].on(irb4600, lost_motion=1e-4, width=3e-4)
    expected = 4 * irb4600.drive.joint_stiffness * 1e-4 * (1e-3 - 0.625 * 3e-4)
    for steps in (2000, 500):
        dt = 1.0 / steps
        t = np.arange(2 * steps + 1) * dt
        deflection = 1e-3 * np.sin(2 * np.pi * t)
        rate = np.diff(deflection, prepend=0.0) / dt
        memory, torque = np.zeros((6, 4)), []
        for bent, speed in zip(deflection, rate, strict=True):
            added, memory = effect.torques(state_of(irb4600, deflection=bent, deflection_rate=speed), memory, dt)
            torque.append(added.spring)
        loop = slice(steps, None)  # the second time around
        area = -np.trapezoid(np.array(torque)[loop], deflection[loop], axis=0)
        np.testing.assert_allclose(area, expected, rtol=0.01)
        assert np.abs(torque).max() <= irb4600.drive.joint_stiffness.max() * 1e-4 * (1 + 1e-12)


def test_a_loaded_joint_with_backlash_hangs_half_a_gap_lower(irb4600, corners):
    q = corners["p1"]
    tight = resting(irb4600_machine(irb4600), q)
    loose = resting(irb4600_machine(irb4600, backlash={"half_gap": 3e-4}), q)
    loaded = np.abs(tight) > 1e-6
    assert loaded[1:5].all()
    np.testing.assert_allclose((loose - tight)[loaded], 3e-4 * np.sign(tight[loaded]), rtol=2e-2)


def test_robots_find_their_rest_in_any_pose(irb4600, arm):
    low, high = irb4600.kinematics.range.T
    starts = [log.joint_array("reference.position")[0] for log in example_logs()]
    poses = np.random.default_rng(0).uniform(low, high, size=(400, 6))
    poses = np.concatenate([poses, irb4600.drive.joint_angle(np.array(starts))])
    plant = Plant(Machine(robot=irb4600), len(poses), n_threads=1)
    plant.rest(poses)
    state = plant.state()
    bent = state.link_position - poses
    _, bias = arm.equations_of_motion(state.link_position, np.zeros_like(poses), gravity=True)
    np.testing.assert_allclose(-irb4600.drive.joint_stiffness * bent, bias, rtol=1e-9, atol=1e-6)


def test_a_joint_that_hardly_carries_anything_hangs_within_its_backlash(irb4600, corners):
    gap = 3e-4
    machine = irb4600_machine(irb4600, backlash={"half_gap": [0, 0, 0, 0, 0, gap]})
    for q in corners.values():
        for turned in np.linspace(-0.002, 0.002, 9):
            bent = resting(machine, q + turned * np.eye(6)[5])
            assert abs(bent[5]) <= gap * (1 + 1e-3) + 1e-6


def test_backlash_carries_nothing_within_its_gap(irb4600):
    effect = EFFECTS["backlash"].on(irb4600, half_gap=2e-4)
    stiffness, damping = irb4600.drive.joint_stiffness, irb4600.drive.joint_damping
    for bent, carried in ((1.9e-4, 0.0), (-1.9e-4, 0.0), (3e-4, 1e-4), (-3e-4, -1e-4)):
        state = state_of(irb4600, deflection=bent, deflection_rate=0.01)
        inner = -stiffness * bent - damping * 0.01 + torques_at(effect, state).spring
        expected = -stiffness * carried - (damping * 0.01 if carried else 0.0)
        np.testing.assert_allclose(inner, expected, atol=1e-9)


def test_a_hardening_joint_sags_to_the_root_of_its_cubic(irb4600, corners):
    linear = resting(irb4600_machine(irb4600), corners["p1"])
    growth = 2e6
    hard = resting(irb4600_machine(irb4600, hardening={"growth": growth}), corners["p1"])
    # the load hardly depends on the sag of some tenths of a milliradian
    np.testing.assert_allclose(hard * (1 + growth * hard**2), linear, rtol=5e-3, atol=1e-8)
    assert abs(hard[1]) < 0.98 * abs(linear[1])


def test_sag_is_inverse_to_stiffness(irb4600, corners):
    nominal = resting(irb4600_machine(irb4600), corners["p1"])
    soft = resting(irb4600_machine(irb4600, joint_stiffness={"change": -0.3}), corners["p1"])
    np.testing.assert_allclose(soft[1:5], nominal[1:5] / 0.7, rtol=5e-3)


def test_the_friction_of_one_motor_brakes_another(irb4600):
    share = np.zeros((6, 6))
    share[4, 3] = 0.2  # row: braked, column: turning
    effect = EFFECTS["wrist_coupling"].on(irb4600, share=share)
    speed = np.array([9.0, 9.0, 9.0, -2.0, 0.0, 9.0])
    torque = torques_at(effect, state_of(irb4600, motor_speed=speed, friction_sign=np.sign(speed))).motor
    friction = irb4600.friction
    np.testing.assert_allclose(torque[4], 0.2 * (friction.coulomb[3] + 2.0 * friction.viscous[3]))
    assert not np.delete(torque, 4).any()


def test_a_motor_that_brakes_itself_through_another_is_refused(irb4600):
    with pytest.raises(FFGymError, match="diagonal"):
        EFFECTS["wrist_coupling"].on(irb4600, share=0.1)


def test_what_swings_on_a_link_follows_its_equation(irb4600):
    frequency, damping, dt = 11.0, 0.03, 0.001
    omega, t = 2 * np.pi * frequency, np.arange(0, 1.0, dt)
    effect = EFFECTS["flexible_load"].on(irb4600, inertia=1.5, frequency=frequency, damping=damping)
    angle = 1e-2 * (1 - np.cos(2 * np.pi * 7.0 * t))
    speed = 1e-2 * 2 * np.pi * 7.0 * np.sin(2 * np.pi * 7.0 * t)
    states = state_of(irb4600, joint_angle=angle[:, None], joint_speed=speed[:, None])

    def rate(time, x):
        acceleration = 1e-2 * (2 * np.pi * 7.0) ** 2 * np.cos(2 * np.pi * 7.0 * time)
        return [x[1], -acceleration - 2 * damping * omega * x[1] - omega**2 * x[0]]

    exact = solve_ivp(rate, (0, t[-1]), [0.0, 0.0], t_eval=t, rtol=1e-9, atol=1e-12).y
    expected = 1.5 * (omega**2 * exact[0] + 2 * damping * omega * exact[1])
    found = torques_along(effect, states, dt).link
    np.testing.assert_allclose(found[:, 2], expected, atol=1e-3 * np.abs(expected).max())


def test_what_swings_adds_its_inertia_to_slow_motions(irb4600):
    t = np.arange(0, 4.0, 0.001)
    speed = 0.1 * np.sin(2 * np.pi * 0.25 * t) ** 2
    states = state_of(irb4600, joint_speed=speed[:, None])
    effect = EFFECTS["flexible_load"].on(irb4600, inertia=1.5, frequency=20.0, damping=0.1)
    slow = -1.5 * np.gradient(speed, 0.001)
    np.testing.assert_allclose(torques_along(effect, states, 0.001).link[:, 0], slow, atol=0.03 * np.abs(slow).max())


def test_a_soft_base_tilts_by_the_moment_of_the_arm(irb4600, corners):
    machine = irb4600_machine(irb4600, base_flexibility={"compliance": np.array([3e-7, 3e-7, 0.0])})
    plant = Plant(machine, 1, n_threads=1)
    plant.rest(corners["p1"][None])
    data = mujoco.MjData(plant.batch.get_model(0))
    data.qpos[:] = plant.batch.qpos[0]
    mujoco.mj_forward(plant.batch.get_model(0), data)
    np.testing.assert_allclose(data.qpos[:2], -3e-7 * data.qfrc_bias[:2], rtol=1e-9)
    assert data.qpos[1] > 1e-4  # forwards


def test_the_recorded_tool_moves_with_the_base(irb4600, corners):
    machine = irb4600_machine(irb4600, base_flexibility={"compliance": 3e-7})
    swing = multisine(corners["p1"], np.full((1, 6), 2e-3), [2.0], np.zeros((1, 6)), 0.3, ramp=0.1, dwell=0.05)
    reference = joint_reference(irb4600, swing)
    soft = simulate([Run(reference=reference)], machine=machine, n_threads=1)[0]
    on_rock = RigidArm(irb4600).tcp_position(soft.joint_array("link.position"))
    tilt = soft.vector("tcp.position")[0] - on_rock[0]
    assert 3e-4 < np.linalg.norm(tilt) < 3e-3
    assert tilt[2] < 0


def test_stiff_and_loose_transmissions_stay_stable_when_shaken(irb4600, corners):
    effects = ("hardening", "torsional_hysteresis", "backlash", "kinematic_error", "cable_pull")
    machine = Machine(robot=irb4600, effects=tuple(as_strong_as_plausible(EFFECTS[name], irb4600) for name in effects))
    swing = multisine(corners["p1"], np.full((1, 6), 0.01), [4.0], np.zeros((1, 6)), 0.3, ramp=0.1, dwell=0.1)
    recording = simulate([Run(reference=joint_reference(irb4600, swing))], machine=machine, n_threads=1)[0]
    assert np.abs(recording.joint_array("motor.velocity")[-20:]).max() < 0.5
    finer = simulate(
        [Run(reference=joint_reference(irb4600, swing))],
        machine=machine,
        options=ModelOptions(physics_dt=0.000125, looks=False),
        n_threads=1,
    )[0]
    moved = np.ptp(recording.joint_array("link.position"), axis=0)
    difference = np.abs(finer.joint_array("link.position") - recording.joint_array("link.position")).max(axis=0)
    assert np.all(difference < 0.02 * moved)


def irb4600_machine(robot, **effects):
    """The robot with effects by name."""
    return Machine(robot=robot, effects=tuple(EFFECTS[name].on(robot, **values) for name, values in effects.items()))


def test_shares_of_friction_behind_the_elasticity_add_up_to_less_than_all(irb4600):
    half, third = (EFFECTS["arm_friction"].on(irb4600, "j2", share=share) for share in (0.5, 1 / 3))
    both = third.in_description(half.in_description(irb4600))
    np.testing.assert_allclose(both.arm_share, [0, 1 - 0.5 * 2 / 3, 0, 0, 0, 0])
    assert EFFECTS["arm_friction"].on(irb4600, share=0.0).in_description(irb4600).friction.arm_share is None


def test_load_friction_behind_the_elasticity_goes_from_step_to_step_as_along_all_samples(irb4600):
    effect, dt = EFFECTS["arm_load_friction"].on(irb4600, share=0.1), 0.002
    t = dt * np.arange(400)[:, None]
    speed, load = 0.02 * np.sin(9 * t + np.arange(6)), 300 * np.cos(3 * t) * np.ones(6)
    states = state_of(irb4600, time=t, link_speed=speed, load=load)
    at_once, memory = (
        effect.torques_over(states, dt).link,
        effect.initial_memory(state_of(irb4600, link_speed=speed[0])),
    )
    for k in range(400):
        added, memory = effect.torques(state_of(irb4600, link_speed=speed[k], load=load[k]), memory, dt)
        np.testing.assert_allclose(added.link, at_once[k], atol=1e-9)
    # it takes energy, and comes to the lost share of the load
    assert np.all(np.trapezoid(at_once * speed, dx=dt, axis=0) < 0)
    assert np.all(np.abs(at_once) <= 0.1 * np.abs(load))
    assert np.median(np.abs(at_once) / np.abs(load)) > 0.095


@pytest.mark.parametrize(
    ("effect", "name", "value", "words"),
    [
        ("arm_friction", "share", 1.5, r"arm_friction.share = \[1.5, .*, 1.5\] must be at most 1\.$"),
        ("backlash", "half_gap", -1e-5, r"backlash.half_gap = \[-1e-05, .*\] rad must be at least 0 rad\.$"),
    ],
)
def test_a_number_out_of_its_range_is_told_with_its_unit_if_it_has_one(irb4600, effect, name, value, words):
    with pytest.raises(FFGymError, match=words):
        EFFECTS[effect].on(irb4600, **{name: value})
