"""Feed-forward laws against a stiff ODE solver, the thesis' own code, and limits."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.integrate import solve_ivp

from ffgym.control import CausalLaw, DynamicLuGreEuler, DynamicLuGreExact, NoCompensation, StaticLuGre, Window
from ffgym.core.errors import FFGymError
from ffgym.paths import joint_reference, joint_sine
from ffgym.studies import circle_references

EXACT_AGREES = {"1 Hz": 1e-4, "3 Hz": 2e-3, "10 mm/s": 2e-4, "40 mm/s": 2e-3, "100 mm/s": 0.03}
"""Largest error of DynamicLuGreExact, relative to the breakaway torque."""
EULER_AGREES = {"1 Hz": 0.05, "3 Hz": 0.02, "10 mm/s": 0.003, "40 mm/s": 0.02, "100 mm/s": 0.1}
"""The same for the thesis' 40 Euler steps."""
MOTIONS = tuple(EXACT_AGREES)


@pytest.fixture(scope="module")
def motions(one_axis, arm):
    """References of the thesis: the sines of the one-axis test, and the smallest circle at three speeds."""
    sines = {f"{f:g} Hz": joint_reference(one_axis, joint_sine([1.0], f, 1.0)) for f in (1.0, 3.0)}
    circles = circle_references(arm, ["p1"], radii=(0.001,))
    return sines | {f"{speed * 1e3:g} mm/s": reference for (_, speed), reference in circles.items()}


@pytest.fixture(scope="module")
def truths(motions):
    """Friction torque by Radau's method on the piecewise linear motor speed, (T, N) per motion."""
    return {name: stiff_torque(reference) for name, reference in motions.items()}


def stiff_torque(reference):
    friction, t, motor_dq = reference.robot.friction, reference.t, reference.motor_dq
    z = np.stack([stiff_bristle(friction, j, t, motor_dq[:, j]) for j in range(friction.n_joints)], axis=1)
    return friction.torque(z, motor_dq)


def stiff_bristle(friction, j, t, speed):
    coulomb, excess = float(friction.coulomb[j]), float(friction.static[j] - friction.coulomb[j])
    stiffness, slow, dt = float(friction.bristle_stiffness[j]), float(friction.stribeck_velocity[j]), float(t[1])
    samples = speed.tolist()

    def at(time):
        k = min(int(time / dt), len(samples) - 2)
        return samples[k] + (samples[k + 1] - samples[k]) * (time / dt - k)

    def decay(v):
        return stiffness * abs(v) / (coulomb + excess * math.exp(-((v / slow) ** 2)))

    solution = solve_ivp(
        lambda time, z: [at(time) - decay(at(time)) * z[0]],
        (0.0, float(t[-1])),
        [0.0],
        jac=lambda time, z: [[-decay(at(time))]],
        method="Radau",
        rtol=1e-7,
        atol=1e-11,
        max_step=dt,
        t_eval=t,
    )
    return solution.y[0]


def worst(law, reference, truth):
    """Largest error relative to breakaway [1]."""
    return (np.abs(law.torque(reference) - truth) / reference.robot.friction.static).max()


@pytest.mark.parametrize("motion", MOTIONS)
def test_exact_law_agrees_with_a_stiff_solver(motions, truths, motion):
    reference = motions[motion]
    assert worst(DynamicLuGreExact(reference.robot.friction), reference, truths[motion]) < EXACT_AGREES[motion]


@pytest.mark.parametrize("motion", MOTIONS)
def test_exact_law_with_more_sub_steps_is_within_two_thousandths_of_breakaway(motions, truths, motion):
    reference = motions[motion]
    assert worst(DynamicLuGreExact(reference.robot.friction, 32), reference, truths[motion]) < 0.002


@pytest.mark.parametrize("motion", MOTIONS)
def test_forty_euler_steps_agree_with_a_stiff_solver(motions, truths, motion):
    reference = motions[motion]
    assert worst(DynamicLuGreEuler(reference.robot.friction), reference, truths[motion]) < EULER_AGREES[motion]


@pytest.mark.parametrize("motion", ["1 Hz", "40 mm/s", "100 mm/s"])
def test_error_of_euler_falls_in_proportion_to_its_sub_step(motions, truths, motion):
    reference = motions[motion]
    friction = reference.robot.friction
    errors = [worst(DynamicLuGreEuler(friction, n), reference, truths[motion]) for n in (100, 200, 400)]
    np.testing.assert_allclose(np.log2(errors[:-1]) - np.log2(errors[1:]), 1.0, atol=0.15)


@pytest.mark.parametrize("motion", ["1 Hz", "3 Hz", "100 mm/s"])
def test_one_euler_step_of_four_milliseconds_diverges_as_the_thesis_found_and_the_exact_law_does_not(motions, motion):
    reference = motions[motion]
    friction = reference.robot.friction
    with pytest.raises(FFGymError, match=r"diverges at sample \d+.*Use more n_substeps"):
        DynamicLuGreEuler(friction, 1).torque(reference)
    torque = DynamicLuGreExact(friction, 1).torque(reference)
    speed = np.abs(reference.motor_dq)  # |z| < f_s / sigma_0, so that |dz/dt| < |v| (1 + f_s / f_c)
    bound = friction.static + friction.bristle_damping * speed * (1 + friction.static / friction.coulomb)
    assert np.all(np.abs(torque - friction.viscous * reference.motor_dq) <= bound * (1 + 1e-12))


def thesis_appendix_a1(vin, h, s0, s1, fc, fs, vs, sig_v, sample):
    """Matlab function dynLuGre_upsample of appendix A.1, line by line."""
    m = len(vin)
    v = np.interp(np.arange((m - 1) * sample + 1) / sample, np.arange(m), vin)
    gv = fc + (fs - fc) * np.exp(-((v / vs) ** 2))
    z, f = np.zeros(m + 1), np.zeros(m)
    for i in range(m):
        zdot = vin[i] - s0 * abs(vin[i]) / gv[i * sample] * z[i]
        f[i] = s0 * z[i] + s1 * zdot + sig_v * vin[i]
        if i == m - 1:
            break
        z_it = z[i] + h / sample * zdot
        for j in range(1, sample):
            idx = i * sample + j
            zdot = v[idx] - s0 * abs(v[idx]) / gv[idx] * z_it
            z_it = z_it + h / sample * zdot
        z[i + 1] = z_it
    return f


@pytest.mark.parametrize("motion", MOTIONS)
def test_euler_law_is_the_code_of_the_thesis(motions, motion):
    reference = motions[motion]
    p = reference.robot.friction
    literal = np.stack(
        [
            thesis_appendix_a1(
                reference.motor_dq[:, j], 0.004, p.bristle_stiffness[j], p.bristle_damping[j],
                p.coulomb[j], p.static[j], p.stribeck_velocity[j], p.viscous[j], 40,
            )
            for j in range(p.n_joints)
        ],
        axis=1,
    )  # fmt: skip
    np.testing.assert_allclose(DynamicLuGreEuler(p).torque(reference), literal, atol=1e-12)


@pytest.mark.parametrize("law", [DynamicLuGreEuler, DynamicLuGreExact])
@pytest.mark.parametrize("motion", ["3 Hz", "100 mm/s"])
def test_steps_in_a_loop_give_the_bits_of_the_whole_recording(motions, law, motion):
    reference = motions[motion]
    member, dq = law(reference.robot.friction), reference.motor_dq
    windows = Window.along(reference, member.preview)
    memory = member.initial_memory(windows[0])
    stepped = [member.friction.torque(memory, dq[0])]
    for k in range(len(dq) - 1):
        torque, memory = member.step(memory, windows[k])
        stepped.append(torque)
    np.testing.assert_array_equal(np.array(stepped), member.along(dq, 0.004))


@given(v=st.floats(0.001, 8) | st.floats(-8, -0.001))
def test_dynamic_laws_settle_at_the_steady_torque(one_axis, v):
    friction = one_axis.friction
    slip = friction.static[0] / friction.bristle_stiffness[0] / abs(v)
    samples = np.full((int(40 * slip / 0.004) + 50, 1), v)
    for law in (DynamicLuGreEuler(friction), DynamicLuGreExact(friction)):
        np.testing.assert_allclose(law.along(samples, 0.004)[-1], friction.steady_torque(samples[-1]), rtol=1e-9)


@given(speeds=arrays(float, (30, 1), elements=st.floats(-20, 20)))
def test_dynamic_law_is_odd_in_the_motion(one_axis, speeds):
    law = DynamicLuGreExact(one_axis.friction)
    np.testing.assert_array_equal(law.along(-speeds, 0.004), -law.along(speeds, 0.004))


@given(v=st.floats(-30, 30))
def test_static_law_is_odd_and_zero_at_rest(one_axis, v):
    law = StaticLuGre(one_axis.friction)
    np.testing.assert_array_equal(law.at_speed(np.array([-v])), -law.at_speed(np.array([v])))
    assert law.at_speed(np.zeros(1))[0] == 0


@given(v=st.floats(4, 100), sign=st.sampled_from([-1, 1]))
def test_static_law_is_the_steady_torque_away_from_zero(one_axis, v, sign):
    law, dq = StaticLuGre(one_axis.friction), np.array([sign * v])
    np.testing.assert_allclose(law.at_speed(dq), one_axis.friction.steady_torque(dq), rtol=1e-15)


@given(v=st.floats(-4, 4), w=st.floats(1, 50))
def test_static_law_never_exceeds_the_steady_torque_and_opposes_the_motion(one_axis, v, w):
    torque = StaticLuGre(one_axis.friction, w).at_speed(np.array([v]))[0]
    assert abs(torque) <= abs(one_axis.friction.steady_torque(np.array([v]))[0])
    assert torque * v >= 0


def test_static_law_reads_the_motor_speed_of_the_reference(motions):
    reference = motions["40 mm/s"]
    law = StaticLuGre(reference.robot.friction)
    np.testing.assert_array_equal(law.torque(reference), law.at_speed(reference.dq * reference.robot.drive.gear_ratio))


class OwnLaw(CausalLaw):
    """A law that returns whatever it is told to."""

    name = "own"
    n_joints = 1

    def __init__(self, answer):
        self.answer = answer

    def step(self, memory, window):
        return self.answer(memory, window.motor_dq[..., 1, :])


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (lambda memory, speed: speed, "step of law 'own' must return torque and memory, got ndarray"),
        (lambda memory, speed: None, "step of law 'own' must return torque and memory, got NoneType"),
        (lambda memory, speed: (speed[..., None], memory), r"of a step of law 'own' has shape \(\d+, 1, 1\), must be"),
        (lambda memory, speed: (0.0, memory), r"of a step of law 'own' has shape \(\), must be \(\d+, 1\)"),
    ],
)
def test_a_step_that_does_not_return_torque_and_memory_is_refused(one_axis, answer, message):
    reference = joint_reference(one_axis, joint_sine([0.5], 1.0, 0.5))
    with pytest.raises(FFGymError, match=message):
        OwnLaw(answer).torque(reference)


def test_no_compensation_adds_nothing(motions):
    assert not NoCompensation().torque(motions["10 mm/s"]).any()


@pytest.mark.parametrize("law", [StaticLuGre, DynamicLuGreEuler, DynamicLuGreExact])
def test_friction_of_another_robot_is_refused(motions, one_axis, law):
    with pytest.raises(FFGymError, match="for 1 joints does not fit robot"):
        law(one_axis.friction).torque(motions["10 mm/s"])


@pytest.mark.parametrize("law", [DynamicLuGreEuler, DynamicLuGreExact])
def test_sub_steps_must_be_positive(one_axis, law):
    with pytest.raises(FFGymError, match="n_substeps = 0"):
        law(one_axis.friction, 0)
