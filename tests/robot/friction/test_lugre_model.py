"""LuGre's equations: limits, bounds, dissipation, and the exact bristle step."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from ffgym.core.errors import FFGymError
from ffgym.robot.friction import LuGreParameters

speeds = st.floats(-30, 30, allow_subnormal=False)
parameters = st.builds(
    lambda coulomb, excess, viscous, slow, presliding, damping: LuGreParameters(
        coulomb=np.array([coulomb]),
        static=np.array([coulomb * (1 + excess)]),
        viscous=np.array([viscous * coulomb]),
        stribeck_velocity=np.array([slow]),
        bristle_stiffness=np.array([coulomb / presliding]),
        bristle_damping=np.array([damping * coulomb]),
    ),
    coulomb=st.floats(0.05, 5),
    excess=st.floats(0, 0.5),
    viscous=st.floats(0, 0.2),
    slow=st.floats(0.05, 1),
    presliding=st.floats(0.001, 0.02),
    damping=st.floats(0, 1.5),
)
steps = st.floats(1e-5, 0.01)


def one(value):
    return np.array([value])


@given(friction=parameters, v=speeds)
def test_stribeck_level_lies_between_coulomb_and_static(friction, v):
    level = friction.stribeck_level(one(v))
    assert friction.coulomb * (1 - 1e-15) <= level <= friction.static * (1 + 1e-15)


@given(friction=parameters, multiple=st.floats(-3, 3))
def test_stribeck_level_falls_as_a_bell_of_the_width_of_the_stribeck_velocity(friction, multiple):
    level = friction.stribeck_level(multiple * friction.stribeck_velocity)
    expected = friction.coulomb + (friction.static - friction.coulomb) * np.e ** -(multiple**2)
    np.testing.assert_allclose(level, expected, rtol=1e-12)


@given(friction=parameters, v=speeds.filter(lambda v: abs(v) > 0.01))
def test_bristles_at_their_steady_deflection_give_the_steady_torque(friction, v):
    z = friction.stribeck_level(one(v)) * np.sign(v) / friction.bristle_stiffness
    assert friction.bristle_rate(z, one(v))[0] == pytest.approx(0, abs=1e-12 * abs(v))
    np.testing.assert_allclose(friction.torque(z, one(v)), friction.steady_torque(one(v)), rtol=1e-12)


@given(friction=parameters, v=speeds.filter(lambda v: abs(v) > 0.01), start=st.floats(-1, 1))
def test_constant_speed_leads_to_the_steady_torque_from_any_start(friction, v, start):
    z = start * friction.static / friction.bristle_stiffness
    slip = friction.stribeck_level(one(v)) / friction.bristle_stiffness / abs(v)
    for _ in range(50):
        keep, gain = friction.exact_bristle_factors(one(v), float(slip[0]))
        z = keep * z + gain
    np.testing.assert_allclose(friction.torque(z, one(v)), friction.steady_torque(one(v)), rtol=1e-9)


@given(friction=parameters, v=speeds)
def test_steady_torque_is_odd(friction, v):
    np.testing.assert_array_equal(friction.steady_torque(one(-v)), -friction.steady_torque(one(v)))


@given(friction=parameters, v=speeds, start=st.floats(-1, 1), dt=steps)
def test_exact_step_solves_the_bristle_equation(friction, v, start, dt):
    z = float(start * friction.static[0] / friction.bristle_stiffness[0])
    keep, gain = friction.exact_bristle_factors(one(v), dt)
    truth = solve_ivp(
        lambda _, y: friction.bristle_rate(y, one(v)), (0, dt), [z], method="Radau", rtol=1e-9, atol=1e-14
    ).y[0, -1]
    limit = float(friction.static[0] / friction.bristle_stiffness[0])
    assert keep[0] * z + gain[0] == pytest.approx(truth, abs=1e-7 * limit)


@given(friction=parameters, v=speeds, start=st.floats(-1, 1), dt=steps)
def test_bent_bristles_are_those_of_the_exact_step(friction, v, start, dt):
    z = start * friction.coulomb / friction.bristle_stiffness
    keep, gain = friction.exact_bristle_factors(one(v), dt)
    bent = friction.bend_bristles(z, one(v), one(v), dt)
    limit = float(friction.static[0] / friction.bristle_stiffness[0])
    assert bent.bristle[0] == pytest.approx(keep[0] * z[0] + gain[0], abs=1e-12 * limit)
    torque = friction.torque(bent.bristle, one(v))
    assert bent.torque[0] == pytest.approx(torque[0], rel=1e-9, abs=1e-12)
    assert bent.torque_slope[0] >= 0


@pytest.mark.parametrize("v", [-0.4, 0.003, 2.0])
def test_slopes_of_bent_bristles_are_those_of_differences(v):
    friction = LuGreParameters(
        coulomb=one(0.5), static=one(0.5), viscous=one(0.01), stribeck_velocity=one(0.3),
        bristle_stiffness=one(60.0), bristle_damping=one(0.05),
    )  # fmt: skip

    def bent(more):
        return friction.bend_bristles(one(0.002), one(v + more / 2), one(v + more), 0.002)

    here, step = bent(0.0), 1e-6
    for value, slope in (("bristle", "bristle_slope"), ("torque", "torque_slope")):
        difference = (getattr(bent(step), value) - getattr(bent(-step), value)) / (2 * step)
        np.testing.assert_allclose(getattr(here, slope), difference, rtol=1e-2, atol=1e-9)


def test_bristles_of_several_motions_bend_as_each_joint_alone():
    numbers = {
        "coulomb": [0.5, 0.7], "static": [0.6, 0.9], "viscous": [0.01, 0.02], "stribeck_velocity": [0.3, 0.2],
        "bristle_stiffness": [60.0, 80.0], "bristle_damping": [0.05, 0.04],
    }  # fmt: skip
    friction = LuGreParameters(**{name: np.array(values) for name, values in numbers.items()})
    z, before, speed = np.random.default_rng(0).normal(size=(3, 3, 2)) * np.array([0.005, 0.4, 0.4])[:, None, None]
    together = friction.bend_bristles(z, 0.5 * (before + speed), speed, 0.002)
    for m, j in np.ndindex(z.shape):
        own = LuGreParameters(**{name: one(values[j]) for name, values in numbers.items()})
        alone = own.bend_bristles(one(z[m, j]), one(0.5 * (before[m, j] + speed[m, j])), one(speed[m, j]), 0.002)
        for name in ("bristle", "torque", "bristle_slope", "torque_slope"):
            assert getattr(together, name)[m, j] == pytest.approx(getattr(alone, name)[0], rel=1e-12)


@given(friction=parameters, v=speeds, dt=steps)
def test_two_exact_half_steps_are_one_whole_step(friction, v, dt):
    keep, gain = friction.exact_bristle_factors(one(v), dt)
    half_keep, half_gain = friction.exact_bristle_factors(one(v), dt / 2)
    np.testing.assert_allclose(keep, half_keep**2, rtol=1e-9)
    np.testing.assert_allclose(gain, half_keep * half_gain + half_gain, rtol=1e-9, atol=1e-18)


@given(friction=parameters, path=st.lists(st.tuples(speeds, steps), min_size=1, max_size=60))
def test_bristles_never_bend_further_than_breakaway(friction, path):
    z, limit = np.zeros(1), friction.static / friction.bristle_stiffness
    for v, dt in path:
        keep, gain = friction.exact_bristle_factors(one(v), dt)
        z = keep * z + gain
        assert abs(z[0]) <= limit[0] * (1 + 1e-12)


def test_at_rest_bristles_stay_and_do_not_divide_by_zero():
    friction = LuGreParameters(
        coulomb=one(0.5), static=one(0.6), viscous=one(0.04), stribeck_velocity=one(0.15),
        bristle_stiffness=one(70.0), bristle_damping=one(0.7),
    )  # fmt: skip
    keep, gain = friction.exact_bristle_factors(np.zeros(1), 0.004)
    assert (keep[0], gain[0]) == (1.0, 0.0)
    assert friction.torque(one(0.003), np.zeros(1))[0] == pytest.approx(0.21)


@given(
    friction=parameters,
    amplitudes=st.lists(st.floats(-4, 4), min_size=3, max_size=3).filter(lambda a: max(map(abs, a)) > 0.05),
    phases=st.lists(st.floats(0, 6.28), min_size=3, max_size=3),
    period=st.floats(0.5, 5),
)
def test_friction_takes_energy_over_a_cycle_of_any_periodic_motion(friction, amplitudes, phases, period):
    n, cycles = 400, 3
    time = np.arange(n) / n
    harmonics = np.arange(1, 4)
    v = np.sin(2 * np.pi * np.outer(time, harmonics) + phases) @ amplitudes
    keep, gain = friction.exact_bristle_factors(v[:, None], period / n)
    z, bent = np.zeros(1), np.empty((n, 1))
    for _ in range(cycles):
        for k in range(n):
            bent[k] = z
            z = keep[k] * z + gain[k]
    work = friction.torque(bent, v[:, None])[:, 0] * v
    assert work.mean() >= 0


@given(friction=parameters, bent=st.floats(-1, 1), v=st.floats(0.01, 30), sign=st.sampled_from([-1, 1]))
def test_slopes_of_the_bristle_rate_are_its_finite_differences(friction, bent, v, sign):
    v, z = one(sign * v), bent * friction.static / friction.bristle_stiffness
    by_dq, by_z = friction.bristle_rate_slopes(z, v)

    def difference(rate, step):
        return (rate(step) - rate(-step)) / (2 * step)

    step = 1e-4 * float(min(np.abs(v[0]), friction.stribeck_velocity[0]))
    numeric = difference(lambda h: friction.bristle_rate(z, v + h), step)
    np.testing.assert_allclose(by_dq, numeric, rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(by_z, difference(lambda h: friction.bristle_rate(z + h, v), 1.0), rtol=1e-9)


@given(friction=parameters, start=st.floats(-1, 1), v=speeds)
def test_sliding_friction_opposes_the_motion_once_it_is_steady(friction, start, v):
    assert friction.steady_torque(one(v))[0] * v >= 0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"coulomb": 0.0}, "coulomb = .* must be > 0"),
        ({"viscous": -0.1}, "viscous = .* must be >= 0"),
        ({"static": 0.1}, "static = .* must be >= coulomb"),
        ({"bristle_stiffness": [1.0, 2.0]}, "bristle_stiffness has shape"),
    ],
)
def test_impossible_parameters_are_named(one_axis, change, message):
    values = {name: getattr(one_axis.friction, name) for name in vars(one_axis.friction)}
    with pytest.raises(FFGymError, match=message):
        LuGreParameters(**(values | change))


def test_scaling_changes_what_is_named_and_nothing_else(one_axis):
    scaled = one_axis.friction.scale(viscous=2.0)
    np.testing.assert_array_equal(scaled.viscous, 2 * one_axis.friction.viscous)
    np.testing.assert_array_equal(scaled.coulomb, one_axis.friction.coulomb)
    with pytest.raises(FFGymError, match=r"\['coulombs'\]"):
        one_axis.friction.scale(coulombs=2.0)
