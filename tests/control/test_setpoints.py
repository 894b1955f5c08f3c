"""Set-points between control samples: cubic Hermite positions, their derivative as speed, straight torques."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ffgym.control import Setpoints
from ffgym.control.setpoints import torque_at_rows
from ffgym.core.errors import FFGymError

DT = 0.004
numbers = st.floats(-100, 100, allow_subnormal=False)
samples = arrays(float, (2, 5, 3), elements=numbers)
ONLY = np.array([0])
BOTH = np.arange(2)


@given(coefficients=arrays(float, (4, 3), elements=st.floats(-10, 10)))
def test_cubics_are_exact_in_position_and_velocity(coefficients):
    t = np.arange(6) * DT
    cubic = np.polynomial.Polynomial

    def value(time, derivative=0):
        polynomials = [cubic(c).deriv(derivative) if derivative else cubic(c) for c in coefficients.T]
        return np.stack([p(time * 100) * 100**derivative for p in polynomials], axis=-1)

    setpoints = Setpoints(position=value(t)[None], velocity=value(t, 1)[None], torque=np.zeros((1, 6, 3)), dt=DT)
    fractions = np.array([0.0, 0.1, 0.5, 0.75])
    position, velocity, _ = setpoints.between(ONLY, 0, 5, fractions)
    times = t[:5, None] + fractions * DT
    np.testing.assert_allclose(position[0], value(times), atol=1e-10)
    np.testing.assert_allclose(velocity[0], value(times, 1), atol=1e-8)


@given(position=samples, velocity=samples, torque=samples)
def test_curves_pass_through_the_samples_and_join_without_a_jump(position, velocity, torque):
    setpoints = Setpoints(position=position, velocity=velocity, torque=torque, dt=DT)
    parts = setpoints.between(BOTH, 0, 4, np.array([0.0, 1.0]))
    for part, wanted, scale in zip(parts, (position, velocity, torque), (1, 1 / DT, 1), strict=True):
        np.testing.assert_allclose(part[:, :, 0], wanted[:, :-1], atol=1e-12 * 100 * scale)
        np.testing.assert_allclose(part[:, :, 1], wanted[:, 1:], atol=1e-12 * 100 * scale)


@given(position=samples, velocity=samples)
def test_velocity_is_the_derivative_of_position(position, velocity):
    setpoints = Setpoints(position=position, velocity=velocity, torque=np.zeros_like(position), dt=DT)
    x, step = np.array([0.2, 0.5, 0.9]), 1e-4
    around = [setpoints.between(BOTH, 0, 4, x + k * step)[0] for k in (-1, 1)]
    middle = setpoints.between(BOTH, 0, 4, x)[1]
    # a cubic's central difference is off by exactly step^2 / 6 of its third derivative
    np.testing.assert_allclose((around[1] - around[0]) / (2 * step * DT), middle, atol=0.02)


@given(torque=samples)
def test_torque_runs_straight_from_sample_to_sample(torque):
    setpoints = Setpoints(position=torque, velocity=torque, torque=torque, dt=DT)
    middle = setpoints.between(BOTH, 0, 4, np.array([0.25]))[2][:, :, 0]
    np.testing.assert_allclose(middle, 0.75 * torque[:, :-1] + 0.25 * torque[:, 1:], atol=1e-12)


@given(position=samples, velocity=samples, torque=samples)
def test_a_robot_and_a_stretch_have_the_same_bits_alone_and_together(position, velocity, torque):
    setpoints = Setpoints(position=position, velocity=velocity, torque=torque, dt=DT)
    fractions = np.arange(16) / 16
    together = setpoints.between(BOTH, 0, 4, fractions)
    alone = setpoints.between(np.array([1]), 2, 3, fractions)
    for whole, part in zip(together, alone, strict=True):
        np.testing.assert_array_equal(whole[1:2, 2:3], part)


@given(position=samples, velocity=samples, torque=samples)
def test_rows_of_a_recording_have_the_bits_that_the_drive_gets(position, velocity, torque):
    setpoints = Setpoints(position=position, velocity=velocity, torque=torque, dt=DT)
    rows = setpoints.at_rows(4)
    sent = setpoints.between(BOTH, 0, 4, np.arange(16) / 16)
    for recorded, part in zip(rows, sent, strict=True):
        np.testing.assert_array_equal(recorded[:, :-1], part[:, :, ::4].reshape(2, -1, 3))
    for recorded, last in zip(rows, (position, velocity, torque), strict=True):
        np.testing.assert_array_equal(recorded[:, -1], last[:, -1])
    np.testing.assert_array_equal(torque_at_rows(torque[0], 4), rows[2][0])


def test_samples_of_unequal_shape_are_refused():
    with pytest.raises(FFGymError, match="set-point velocity has shape"):
        Setpoints(position=np.zeros((1, 5, 2)), velocity=np.zeros((1, 4, 2)), torque=np.zeros((1, 5, 2)), dt=DT)
