"""Stability of learning: the map is the network's own update, and its predictions hold in simulation."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array

from ffgym.agents import learned_motion
from ffgym.agents.bspline import ExtendedBSN, StaticBSN
from ffgym.agents.stability import STABLE_GROWTH, LearningMap, LearningStability, learning_curves
from ffgym.agents.trials import Lesson, SimulatedTrial
from ffgym.core.errors import FFGymError
from ffgym.paths import Reference, joint_reference, joint_sine
from ffgym.paths.excitations import joint_path
from ffgym.paths.motion import standstill
from ffgym.robot import RigidArm
from ffgym.simulation import Run
from ffgym.studies import circle_references


@pytest.fixture(scope="module")
def axis(one_axis) -> RigidArm:
    return RigidArm(one_axis)


@pytest.fixture(scope="module")
def sines(one_axis) -> dict[float, Reference]:
    """Sines of 1 and 3 Hz."""
    return {f: joint_reference(one_axis, joint_sine([1.0], f, 2.0, name=f"sine {f:g} Hz")) for f in (1.0, 3.0)}


@pytest.fixture(scope="module")
def circles(arm) -> dict[float, Reference]:
    """The smallest circle at p1, by speed [m/s]."""
    return {speed: reference for (_, speed), reference in circle_references(arm, ["p1"], radii=[0.001]).items()}


def resting(robot) -> Reference:
    """A motion that is none."""
    return joint_reference(robot, joint_path("rest", [standstill("rest", np.zeros(robot.n_joints), 0.1)], 0.004))


def one_iteration(matrix) -> LearningMap:
    """A map with L = matrix."""
    matrix = np.asarray(matrix, dtype=float)
    return LearningMap(average=csr_array(np.eye(len(matrix))), loss=matrix, signal=np.ones(len(matrix)))


@pytest.mark.parametrize(
    ("matrix", "limit"),
    [
        ([[0.5]], 2 / 0.5),
        ([[0.5, 0.0], [0.0, 1.25]], 2 / 1.25),
        ([[0.6, -0.8], [0.8, 0.6]], 2 * 0.6),  # 2 Re / |lambda|^2
        ([[0.0]], np.inf),
    ],
)
def test_the_largest_rate_is_twice_the_real_part_over_the_square_of_the_worst_eigenvalue(matrix, limit):
    assert one_iteration(matrix).largest_rate == pytest.approx(limit, rel=2e-3)


def test_a_pattern_that_learning_drives_the_wrong_way_leaves_only_the_slowest_rates():
    each = one_iteration([[1.0, 0.0], [0.0, -0.01]])
    assert each.largest_rate == pytest.approx((STABLE_GROWTH - 1) / 0.01, rel=1e-3)
    assert each.growth(0.5) == pytest.approx(1.005)
    assert each.fastest(0.5) == pytest.approx(-0.01)


@given(st.lists(st.complex_numbers(min_magnitude=0.01, max_magnitude=2), min_size=1, max_size=5))
def test_at_the_largest_rate_the_fastest_pattern_just_does_not_grow(pairs):
    blocks = [np.array([[x.real, -x.imag], [x.imag, x.real]]) for x in pairs]
    matrix = np.zeros((2 * len(blocks), 2 * len(blocks)))
    for i, block in enumerate(blocks):
        matrix[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = block
    each = one_iteration(matrix)
    assert each.growth(each.largest_rate) == pytest.approx(STABLE_GROWTH, rel=1e-9)
    assert each.growth(0.9 * each.largest_rate) < STABLE_GROWTH < each.growth(1.1 * each.largest_rate)


def test_what_a_map_averages_is_the_update_of_the_network_over_all_motions(axis, sines):
    references = list(sines.values())
    recordings = SimulatedTrial(arm=axis, n_threads=1)([Run(reference=reference) for reference in references], 0)
    lessons = [Lesson.of(*pair) for pair in zip(references, recordings, strict=True)]
    update = ExtendedBSN.zero(1).adapt(lessons, rate=1.0).coefficients.ravel()
    (each,) = LearningStability.of(ExtendedBSN.zero(1), axis, references).maps
    signal = np.concatenate([lesson.signal[lesson.moving, 0] for lesson in lessons])
    np.testing.assert_allclose(each.average @ signal, update[update != 0], rtol=1e-9)


def test_on_the_robot_too_rows_are_those_of_lessons(arm, circles):
    reference = circles[0.1]
    (recording,) = SimulatedTrial(arm=arm, record_dt=0.002, n_threads=1)([Run(reference=reference)], 0)
    lesson = Lesson.of(reference, recording)
    update = StaticBSN.zero(6).adapt([lesson], rate=1.0).coefficients[:, 0]
    for joint, each in enumerate(LearningStability.of(StaticBSN.zero(6), arm, [reference], record_dt=0.002).maps):
        expected = update[joint][update[joint] != 0]
        np.testing.assert_allclose(each.average @ lesson.signal[lesson.moving, joint], expected, rtol=1e-9)


@pytest.mark.parametrize("kind", [StaticBSN, ExtendedBSN])
@pytest.mark.parametrize("frequency", [1.0, 3.0])
def test_on_one_axis_learning_goes_as_predicted_below_and_above_the_limit(axis, sines, kind, frequency):
    trial = SimulatedTrial(arm=axis, n_threads=1)
    limit = float(LearningStability.of(kind.zero(1), axis, [sines[frequency]]).largest_rate[0])
    (curves,) = learning_curves(kind.zero(1), trial, sines[frequency], [0.5 * limit, 1.5 * limit], 8)
    assert curves.largest_rate == limit
    assert curves.simulated[0, -1] < 0.2 * curves.simulated[0, 0]
    assert curves.simulated[1, -1] > 4 * curves.simulated[1].min()
    np.testing.assert_allclose(np.sqrt(curves.predicted[:, :5]), np.sqrt(curves.simulated[:, :5]), rtol=0.15, atol=0.03)


def test_without_normalisation_learning_goes_as_predicted_at_rates_as_small_as_sums_are_large(axis, sines):
    """Thesis (3.16): the limit falls by about the sum of the best-fed spline, and is the simulated one."""
    trial, network = SimulatedTrial(arm=axis, n_threads=1), StaticBSN.zero(1, normalised=False)
    study = LearningStability.of(network, axis, [sines[1.0]])
    limit = float(study.largest_rate[0])
    assert limit < 0.1
    (curves,) = learning_curves(network, trial, sines[1.0], [0.9 * limit, 1.5 * limit], 8)
    assert curves.simulated[0, -1] < 0.5 * curves.simulated[0, 0]
    assert curves.simulated[1, -1] > 4 * curves.simulated[1].min()
    np.testing.assert_allclose(np.sqrt(curves.predicted[:, :5]), np.sqrt(curves.simulated[:, :5]), rtol=0.15, atol=0.03)
    assert "is above the largest stable one" in str(study.warning(0.8))


def test_on_the_robot_learning_falls_below_the_limit_and_grows_above_it(arm, circles):
    trial = SimulatedTrial(arm=arm, n_threads=2)
    curves = learning_curves(ExtendedBSN.zero(6), trial, circles[0.01], [0.95, 3.0], 10)
    for each in (curves[0], curves[3], curves[5]):  # a base joint, and two of the wrist
        assert 0.95 < each.largest_rate < 3.0
        assert each.simulated[0, -1] < 0.5 * each.simulated[0, 0]
        assert each.simulated[1, -1] > 4 * each.simulated[1].min()
        predicted, simulated = (np.sqrt(part[:, 1] / part[:, 0]) for part in (each.predicted, each.simulated))
        np.testing.assert_allclose(predicted, simulated, rtol=0.3)


def test_rows_between_samples_make_fast_learning_drift_and_samples_alone_do_not(arm, circles):
    network = StaticBSN.zero(6)
    drifting = LearningStability.of(network, arm, [circles[0.04]], record_dt=0.001)
    steady = LearningStability.of(network, arm, [circles[0.04]], record_dt=0.004)
    assert drifting.largest_rate.min() < 0.5
    assert "samples of the reference alone" in str(drifting.warning(0.95))
    assert steady.largest_rate.min() > 1.2
    assert steady.warning(0.95) is None


def test_a_warning_advises_only_what_is_not_done_yet(axis, sines):
    def warning(signal, record_dt):
        study = LearningStability.of(StaticBSN.zero(1), axis, [sines[1.0]], signal=signal, record_dt=record_dt)
        return str(study.warning(0.8))

    for record_dt in (0.001, 0.004):  # the angle lags behind the torque, so that some patterns learn the wrong way
        assert warning("e_p", record_dt).endswith("a lower rate only slows it down, learning from u_p may stop it")
        assert warning("u_p", record_dt) == "None"
    grown = LearningStability(joints=("j1",), maps=(one_iteration([[-0.1]]),))
    assert str(grown.warning(0.8)).endswith("a lower rate only slows it down")


def test_without_friction_a_damped_servo_guarantees_a_rate_on_any_motion(one_axis, sines):
    servo = replace(one_axis.servo, velocity_gain=2 * one_axis.servo.velocity_gain)
    friction = one_axis.friction.scale(bristle_stiffness=1e-9, bristle_damping=0, viscous=0)
    robot = replace(one_axis, servo=servo, friction=friction)
    inertia = robot.drive.rotor_inertia + robot.bodies.inertia[:, 2]
    lag = inertia * servo.position_gain / servo.velocity_gain**2
    slow = servo.integral_gain * servo.velocity_gain / servo.position_gain**2
    guaranteed = float(2 * (1 - np.maximum(lag, slow))[0])
    assert guaranteed > 1
    for frequency in (0.5, 1.0, 3.0):
        reference = joint_reference(robot, joint_sine([1.0], frequency, 2.0))
        for kind in (StaticBSN, ExtendedBSN):
            study = LearningStability.of(kind.zero(1), RigidArm(robot), [reference], record_dt=0.004)
            assert study.largest_rate[0] > 0.99 * guaranteed


def test_weights_that_compensate_friction_leave_little_to_learn(axis, sines):
    friction = axis.robot.friction
    bare = StaticBSN.zero(1)
    knowing = bare.with_curve(lambda dq: friction.stribeck_level(dq) * np.tanh(5 * dq) + friction.viscous * dq)
    first = [LearningStability.of(each, axis, [sines[1.0]]).mean_squares(0.8, 0)[0, 0] for each in (bare, knowing)]
    assert first[1] < 0.1 * first[0]


def test_finer_steps_of_the_model_change_limits_by_less_than_half_a_percent(arm, circles, monkeypatch):
    limits = []
    for steps in (4, 16):
        monkeypatch.setattr(learned_motion, "_STEPS", steps)
        limits.append(LearningStability.of(ExtendedBSN.zero(6), arm, [circles[0.1]], record_dt=0.004).largest_rate)
    np.testing.assert_allclose(limits[0], limits[1], rtol=5e-3)
    assert np.abs(limits[0] - limits[1]).max() > 0  # the steps were taken


def test_the_torque_of_a_weight_begins_at_zero(axis, sines):
    (each,) = LearningStability.of(StaticBSN.zero(1), axis, [sines[1.0]]).maps
    begins = each.loss[4].argmax()  # the spline at the speed at which the sine starts
    assert 0 < each.loss[1, begins] < 0.1 * each.loss[4, begins]  # a ramp grows as t^2, a step would as t


def test_a_warning_names_rate_joint_and_growth(axis, sines):
    study = LearningStability.of(StaticBSN.zero(1), axis, [sines[1.0]])
    assert study.warning(0.8) is None
    growth = study.growth(2.2)[0] - 1
    assert growth > 0.1
    assert f"learning rate 2.2 is above the largest stable one (j1 {study.largest_rate[0]:.2g})" in study.warning(2.2)
    assert f"on j1 a pattern of weights grows by {growth:.1%} in each iteration; lower the rate" in study.warning(2.2)


def test_what_cannot_be_predicted_is_refused(axis, arm, sines, one_axis):
    network, still = StaticBSN.zero(1), resting(one_axis)
    with pytest.raises(FFGymError, match="nothing moves"):
        LearningStability.of(network, axis, [still])
    with pytest.raises(FFGymError, match=r"record_dt = 0.003 s must divide control_dt = 0.004 s"):
        LearningStability.of(network, axis, [sines[1.0]], record_dt=0.003)
    with pytest.raises(FFGymError, match="does not fit robot"):
        LearningStability.of(StaticBSN.zero(6), axis, [sines[1.0]])
    with pytest.raises(FFGymError, match="learning rate"):
        LearningStability.of(network, axis, [sines[1.0]]).growth(-0.1)
