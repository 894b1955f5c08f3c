"""The spring between motor and arm, solved along samples: against solutions that are known.

Friction averaged around samples: momentum, steady state, and a step like the whole.

What elastic feed-forward leaves on a motion that begins far from where it works: the sag of its start, turned.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.polynomial import Polynomial

from ffgym.agents.elastic import elastic_law
from ffgym.agents.flexible_joints import friction_along, lead_between, step_friction
from ffgym.control import DynamicLuGreExact
from ffgym.paths.motions import load_motion
from ffgym.robot import RigidArm, static_deflection
from ffgym.simulation import Run, simulate

DT = 0.004


def samples_of(curve, reach):
    return curve(np.arange(-reach, reach + 1) * DT)[:, None]


@given(coefficients=arrays(float, 5, elements=st.floats(-1, 1)), relaxation=st.floats(0, DT))
def test_the_lead_is_exact_where_it_is_a_polynomial(coefficients, relaxation):
    lead = Polynomial(coefficients / DT ** np.arange(5) * 1e-3)  # every term counts within the samples
    bend = lead + relaxation * lead.deriv()
    found = lead_between(samples_of(bend, 2), np.array([relaxation]), DT)
    for value, order in ((found.angle, 0), (found.speed, 1), (found.acceleration, 2)):
        np.testing.assert_allclose(value * DT**order, lead.deriv(order)(0.0) * DT**order, atol=1e-14)


@pytest.mark.parametrize("reach", [1, 2, 3])
def test_each_derivative_of_a_swinging_lead_is_found_with_its_order(reach):
    omega, at = 100.0, 0.003  # as on r = 1 mm at 100 mm/s

    def errors(dt):
        t, relaxation = at + np.arange(-reach, reach + 1) * dt, 0.2 * dt
        bend = np.sin(omega * t) + relaxation * omega * np.cos(omega * t)
        found = lead_between(bend[:, None], np.array([relaxation]), dt)
        angle, speed = np.sin(omega * at), omega * np.cos(omega * at)
        truth = angle, speed, -(omega**2) * angle
        values = (found.angle, found.speed, found.acceleration)
        return np.abs([value[0] - true for value, true in zip(values, truth, strict=True)])

    observed = np.log2(errors(DT / 4) / errors(DT / 8))
    np.testing.assert_allclose(observed, 2 * reach + 1 - np.arange(3), atol=0.4)


def test_a_rigid_joint_has_no_lead():
    lead = lead_between(np.ones((5, 1)) / np.inf, np.array([0.0]), DT)
    assert not np.any([lead.angle, lead.speed, lead.acceleration])


def test_a_constant_bend_is_the_lead():
    lead = lead_between(np.full((5, 1), 0.001), np.array([8e-4]), DT)
    np.testing.assert_allclose([lead.angle, lead.speed, lead.acceleration], [[0.001], [0], [0]], atol=1e-13)


def test_every_row_has_the_bits_that_it_has_alone():
    bend = np.random.default_rng(0).normal(size=(7, 5, 6))
    relaxation = np.full(6, 8e-4)
    together = lead_between(bend, relaxation, DT)
    for row in range(7):
        np.testing.assert_array_equal(lead_between(bend[row], relaxation, DT).acceleration, together.acceleration[row])


@pytest.fixture(scope="module")
def law(one_axis):
    return DynamicLuGreExact(one_axis.friction)


def reversal(late):
    """Motor speed [rad/s] that turns round within 8 ms, `late` [s] after a sample, and is constant before and after."""
    return np.clip(1000.0 * (np.arange(60) * DT - 0.16 - late), -4.0, 4.0)[:, None]


def fine_friction(law, speed, n=200):
    """Friction [N m] at the middle of `n` parts of each step, (T - 1, n)."""
    shares = (np.arange(n) + 0.5) / n
    fine = speed[:-1] + (speed[1:] - speed[:-1]) * shares
    keep, gain = law.friction.exact_bristle_factors(fine, DT / n)
    z, middles = 0.0, np.empty_like(fine)
    for k, i in np.ndindex(fine.shape):
        next_z = keep[k, i] * z + gain[k, i]
        middles[k, i], z = 0.5 * (z + next_z), next_z
    return law.friction.torque(middles, fine)


def test_straight_lines_between_averages_give_the_momentum_that_friction_takes(law):
    misses = []
    for late in (0.0, 0.001, 0.002, 0.003):
        speed = reversal(late)
        last = np.full((1, 1), law.friction.steady_torque(speed[-1])[0])
        averaged = np.concatenate([friction_along(law, speed, DT), last])
        taken = fine_friction(law, speed)[20:].mean(axis=1).sum() * DT  # by then the bristles have bent
        misses.append([abs(np.trapezoid(torque[20:, 0], dx=DT) - taken) for torque in (averaged, law.along(speed, DT))])
    worst_averaged, worst_sampled = np.max(misses, axis=0)
    assert worst_averaged < 0.01 * worst_sampled


@given(v=st.floats(0.5, 20), sign=st.sampled_from([-1, 1]))
def test_steady_friction_is_shared_equally_by_both_ends(law, v, sign):
    dq = np.array([sign * v])
    z = law.friction.stribeck_level(dq) / law.friction.bristle_stiffness * sign
    start, end, next_z = step_friction(law, z, dq, dq, DT)
    np.testing.assert_allclose(start, 0.5 * law.friction.steady_torque(dq), rtol=1e-9)
    np.testing.assert_allclose(end, start, rtol=1e-9)
    np.testing.assert_allclose(next_z, z, rtol=1e-9)


def test_the_parts_of_a_step_add_up_to_its_mean_friction(law):
    speed = reversal(0.001)[:40]
    fine, z = fine_friction(law, speed), np.zeros(1)
    for k in range(len(speed) - 1):
        start, end, z = step_friction(law, z, speed[k], speed[k + 1], DT)
        np.testing.assert_allclose(start + end, fine[k].mean(), atol=1e-3 * law.friction.static[0])


def test_steps_one_by_one_give_the_whole(law):
    speed, z, before, torques = reversal(0.001), np.zeros(1), np.zeros(1), []
    for k in range(len(speed) - 1):
        start, end, z = step_friction(law, z, speed[k], speed[k + 1], DT)
        torques.append(before + start)
        before = end
    np.testing.assert_allclose(friction_along(law, speed, DT), torques, atol=1e-12)


def test_far_from_the_start_nothing_but_its_turned_sag_is_left(arm):
    reference = load_motion(arm, "cut_bracket").reference
    model = RigidArm(reference.robot)
    (recording,) = simulate([Run(reference=reference, law=elastic_law(model))], arm=model, record_dt=0.004)
    error = np.stack(
        [recording[f"tcp.position.{axis}"] - recording[f"tcp_reference.position.{axis}"] for axis in "xyz"], axis=1
    )
    bent = reference.q + static_deflection(model, reference.q[:1])
    sag = model.tcp_position(bent) - model.tcp_position(reference.q)
    left = np.linalg.norm((error - error[0]) - (sag - sag[0]), axis=1)
    assert np.linalg.norm(sag - sag[0], axis=1).max() > 0.2e-3  # the joints stay bent as at the start
    assert np.sqrt(np.mean(left**2)) < 5e-6
