"""Friction behind the elasticity: own equations of motion, limit cases, energy balance, batches, files."""

from dataclasses import replace

import numpy as np
import pytest
import scipy

from ffgym.control import NoCompensation
from ffgym.core.errors import FFGymError
from ffgym.recordings.metrics import path_errors
from ffgym.robot import ModelOptions, RigidArm, compile_model, load_robot, physics_fingerprint
from ffgym.robot.reading.load import with_numbers
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Plant, PlantDistribution, Uniform
from ffgym.studies import circle_references
from scripts.engine.second.arm import PinocchioArm
from scripts.tables.physics import free_of_servo
from tests.simulation.plant.driving import controls

AMPLITUDE, FREQUENCY, DURATION = 0.6, 1.5, 1.0  # motor side [rad], [Hz], [s]


@pytest.fixture(scope="module")
def flexible_axis(one_axis):
    """The one-axis robot with a spring that swings at 12 Hz while the motor is locked."""
    drive = replace(one_axis.drive, joint_stiffness=np.array([40.0]), joint_damping=np.array([0.02]))
    return replace(one_axis, drive=drive)


def setpoint(t):
    """Motor position and speed: a sine that starts and stays smooth."""
    w = 2 * np.pi * FREQUENCY
    return AMPLITUDE * (1 - np.cos(w * t)) / 2, AMPLITUDE * w * np.sin(w * t) / 2


def own_solution(robot, times):
    """Motor and link positions (T, 2) of one flexible joint with losses on both sides, by a stiff solver.

    Written from the equations alone: J th'' = u - f(zm, th') - K (th / n - q) / n - ..., I q'' = K (th / n - q) + ...
    - n f(za, n q').
    """
    drive, friction, servo = robot.drive, robot.friction, robot.servo
    n, inertia = drive.gear_ratio[0], 2 * PinocchioArm(robot).kinetic_energy(np.zeros(1), np.ones(1))
    fc, fs, fv, vs, s0, s1 = (
        float(getattr(friction, name)[0])
        for name in ("coulomb", "static", "viscous", "stribeck_velocity", "bristle_stiffness", "bristle_damping")
    )
    share = float(friction.arm_share[0])

    def bristle(z, v):
        level = fc + (fs - fc) * np.exp(-((v / vs) ** 2))
        rate = v - s0 * abs(v) / level * z
        return s0 * z + s1 * rate + fv * v, rate

    def slope(t, x):
        theta, omega, q, dq, integral, zm, za = x
        wanted, speed = setpoint(t)
        u = servo.position_gain[0] * (wanted - theta) + servo.velocity_gain[0] * (speed - omega)
        u += servo.integral_gain[0] * integral
        motor, zm_rate = bristle(zm, omega)
        arm, za_rate = bristle(za, n * dq)
        spring = drive.joint_stiffness[0] * (theta / n - q) + drive.joint_damping[0] * (omega / n - dq)
        return [
            omega,
            (u - (1 - share) * motor - spring / n) / drive.rotor_inertia[0],
            dq,
            (spring - share * n * arm) / inertia,
            wanted - theta,
            zm_rate,
            za_rate,
        ]

    solved = scipy.integrate.solve_ivp(
        slope, (0, times[-1]), np.zeros(7), "Radau", times, rtol=1e-8, atol=1e-11, max_step=2e-3
    )
    return solved.y[[0, 2]].T


@pytest.mark.parametrize("share", [0.4, 0.9])
def test_a_stiff_solver_with_own_equations_gives_the_same_motion(flexible_axis, share):
    robot = flexible_axis.with_arm_share(share)
    dt = 2e-5
    plant = Plant(robot, 1, options=ModelOptions(physics_dt=dt, looks=False))
    plant.rest(np.zeros((1, 1)))
    steps = round(DURATION / dt)
    position, speed = setpoint(np.arange(steps) * dt)
    state = plant.unpack(*plant.advance(controls(plant, position[None, :, None], speed[None, :, None])))
    every = 50
    ours = np.stack([state.motor_position[0, :, 0], state.link_position[0, :, 0]], axis=1)[every - 1 :: every]
    times = np.arange(1, len(ours) + 1) * every * dt
    own = own_solution(robot, times)
    wanted = np.stack([setpoint(times)[0], setpoint(times)[0] / robot.drive.gear_ratio[0]], axis=1)
    # errors of motor and link, and the deflection that arm friction brings about
    for found, known in ((ours - wanted, own - wanted), (_bend(robot, ours), _bend(robot, own))):
        difference = np.sqrt(np.mean((found - known) ** 2, axis=0))
        assert np.all(difference < 1e-3 * np.sqrt(np.mean(known**2, axis=0)))


def _bend(robot, motion):
    return motion[:, :1] / robot.drive.gear_ratio[0] - motion[:, 1:]


def test_arm_friction_bends_the_spring_by_what_coulomb_friction_asks_for(flexible_axis):
    """At a slow constant speed the deflection differs between both directions by 2 n share f / K."""
    robot = flexible_axis.with_arm_share(0.5)
    plant = Plant(robot, 2, options=ModelOptions(looks=False))
    plant.rest(np.zeros((2, 1)))
    speed = np.array([2.0, -2.0])[:, None, None]
    t = np.arange(8000)[None, :, None] * plant.physics_dt
    state = plant.unpack(*plant.advance(controls(plant, speed * t, np.broadcast_to(speed, (2, 8000, 1)))))
    n = robot.drive.gear_ratio[0]
    bent = (state.motor_position / n - state.link_position)[:, -1, 0]
    friction = 0.5 * robot.friction.steady_torque(np.array([2.0]))[0] * n
    assert bent[0] == pytest.approx(friction / robot.drive.joint_stiffness[0], rel=1e-3)
    assert bent[1] == pytest.approx(-bent[0], rel=1e-3)


def test_without_a_share_the_model_keeps_its_bits(irb4600):
    for share in (None, 0.0):
        friction = replace(irb4600.friction, arm_share=None if share is None else np.zeros(6))
        model = compile_model(replace(irb4600, friction=friction))
        assert physics_fingerprint(model) == physics_fingerprint(compile_model(irb4600))


def test_behind_a_stiff_spring_all_friction_on_the_arm_equals_all_on_the_motor(irb4600, corners):
    """Path errors of a joint motion at share 1 approach those at share 0 as springs stiffen."""
    stiff = replace(
        irb4600, physics_dt=0.0001, servo=irb4600.servo,
        drive=replace(irb4600.drive, joint_stiffness=30 * irb4600.drive.joint_stiffness,
                      joint_damping=30 * irb4600.drive.joint_damping),
    )  # fmt: skip
    ends = []
    for share in (0.0, 1.0):
        robot = stiff.with_arm_share(share)
        arm = RigidArm(robot)
        (reference,) = circle_references(arm, ["p2"], [0.04], radii=[0.003]).values()
        (recording,) = simulate([Run(reference=reference, law=NoCompensation())], arm=arm)
        ends.append(recording)
    errors = [path_errors(recording)[0].rms for recording in ends]
    assert errors[1] == pytest.approx(errors[0], rel=0.02)
    motors = [np.stack([r[f"motor.effort.{j}"] for j in irb4600.joints]) for r in ends]
    assert np.sqrt(np.mean((motors[1] - motors[0]) ** 2)) < 0.05 * np.std(motors[0])


def test_a_rigid_joint_has_all_friction_on_its_one_side(one_axis):
    assert physics_fingerprint(compile_model(one_axis.with_arm_share(0.7))) == physics_fingerprint(
        compile_model(one_axis)
    )


def test_energy_of_six_axes_falls_by_the_work_of_friction_on_both_sides(irb4600, corners):
    """Mechanical energy plus the work of recorded friction stays, of an arm that is let go with bent springs."""
    loose = replace(free_of_servo(irb4600), drive=replace(irb4600.drive, joint_damping=np.zeros(6)))
    robot = loose.with_arm_share(0.6)
    dt, n = 1.25e-5, 16000
    plant = Plant(robot, 1, options=ModelOptions(physics_dt=dt, looks=False))
    plant.rest(corners["p2"][None])
    plant.batch.qpos[:, plant.addresses.deflection_qpos] += 2e-3
    state = plant.unpack(*plant.advance(np.zeros((1, n, plant.model.nu))))
    at = {name: getattr(state, name)[0] for name in vars(state)}
    drive, lugre = robot.drive, robot.friction
    motor = 0.4 * lugre.torque(at["bristle"], at["motor_velocity"])
    arm_speed = drive.gear_ratio * at["link_velocity"]
    arm = 0.6 * lugre.torque(at["arm_bristle"], arm_speed)
    power = (motor * at["motor_velocity"]).sum(axis=1), (arm * arm_speed).sum(axis=1)
    lost = [np.cumsum(p) * dt for p in power]
    rows, own = slice(None, None, 200), PinocchioArm(robot)
    deflection = at["link_position"] - at["motor_position"] / drive.gear_ratio
    mechanical = 0.5 * (drive.rotor_inertia * at["motor_velocity"][rows] ** 2).sum(axis=1)
    mechanical += [
        own.kinetic_energy(q, dq) for q, dq in zip(at["link_position"][rows], at["link_velocity"][rows], strict=True)
    ]
    mechanical += [own.potential_energy(q) for q in at["link_position"][rows]]
    mechanical += 0.5 * (drive.joint_stiffness * deflection[rows] ** 2).sum(axis=1)
    total = mechanical + lost[0][rows] + lost[1][rows]
    assert min(lost[0][-1], lost[1][-1]) > 1.0  # both sides lose joules
    assert np.abs(total - total[0]).max() < 2e-3 * (lost[0][-1] + lost[1][-1])


def test_robots_of_a_batch_have_arm_friction_on_the_same_joints(irb4600):
    plant = Plant(irb4600.with_arm_share([0.5, 0, 0, 0, 0, 0]), 1)
    with pytest.raises(FFGymError):
        plant.become([0], [irb4600.with_arm_share([0, 0.5, 0, 0, 0, 0])])
    plant.become([0], [irb4600.with_arm_share([0.7, 0, 0, 0, 0, 0])])


def test_draws_take_a_share_and_leave_other_draws_alone(irb4600):
    plain, drawn = (
        PlantDistribution(arm_share=share).draw(irb4600, np.random.default_rng(4))
        for share in (None, Uniform(0.2, 0.9))
    )
    assert plain.friction.arm_share is None
    assert np.all((drawn.friction.arm_share > 0.2) & (drawn.friction.arm_share < 0.9))
    np.testing.assert_array_equal(plain.friction.viscous, drawn.friction.viscous)


def test_a_drawn_share_is_on_the_joints_that_have_one():
    robot = load_robot("irb4600_60_205_arm_losses")
    drawn = PlantDistribution(arm_share=Uniform(0.2, 0.9)).draw(robot, np.random.default_rng(4))
    np.testing.assert_array_equal(drawn.friction.arm_share > 0, robot.friction.arm_share > 0)
    Plant(robot, 1).become([0], [drawn])
    assert not np.allclose(drawn.friction.arm_share, robot.friction.arm_share)


def test_a_parameter_file_gives_a_share(irb4600):
    table = {"value": [0.5] * 6, "unit": "1", "side": "link", "origin": "chosen", "source": "a test"}
    robot = with_numbers(irb4600, {"friction": {"arm_share": table}})
    np.testing.assert_array_equal(robot.arm_share, 0.5)
    assert robot.friction.scale(viscous=2.0).arm_share is robot.friction.arm_share
    with pytest.raises(FFGymError, match="friction arm_share"):
        irb4600.with_arm_share([0.5, 0.5])
    with pytest.raises(FFGymError, match="from 0 to 1"):
        irb4600.with_arm_share(1.2)
