"""Physics of exams: foreign equations vanish, take energy where friction does, and are none of the library's."""

import numpy as np
import pytest

from ffgym.effects import EFFECTS, NativeEffect, ResolverEffect
from ffgym.paths import joint_reference, multisine
from ffgym.robot import ModelOptions
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Climate, Machine
from scripts.exam.equations import OUTSIDERS, VARIANTS
from scripts.exam.equations.frame import lagging
from scripts.exam.equations.friction import (
    directional_efficiency,
    maxwell_slip,
    power_viscous,
    rate_and_state,
    tanh_stribeck,
    two_wave_friction,
    vogel_oil,
)
from scripts.exam.equations.joints import (
    dahl_hysteresis,
    quintic_spring,
    round_gap,
    smooth_cable,
    stepped_spring,
    two_lags,
    two_wave_gear_error,
    two_wave_resolver,
)
from scripts.exam.equations.outsiders import damaged_tooth, wandering_torque
from scripts.exam.hidden import drawn
from tests.effects.effect_samples import as_strong_as_plausible, state_of, without_effect

ALL = {**VARIANTS, **OUTSIDERS}
DT = 0.001

every = pytest.mark.parametrize("kind", ALL.values(), ids=ALL.keys())


def along(effect, states, dt=DT):
    """Torques of an effect at states in turn, and what it remembers in the end."""
    memory, found = effect.initial_memory(states[0]), []
    for state in states:
        torques, memory = effect.torques(state, memory, dt)
        found.append(torques)
    return found, memory


def chance_states(robot, rng, count=40):
    """States of a machine that moves by chance, (N,) each."""
    n = robot.n_joints
    return [
        state_of(
            robot,
            time=0.13 * k,
            motor_angle=rng.normal(scale=20, size=n),
            motor_speed=rng.normal(scale=8, size=n),
            joint_angle=rng.normal(size=n),
            joint_speed=rng.normal(size=n),
            deflection=rng.normal(scale=5e-4, size=n),
            deflection_rate=rng.normal(scale=5e-3, size=n),
            load=rng.normal(scale=300, size=n),
            load_at_motor=rng.normal(scale=3, size=n),
            friction_sign=np.tanh(rng.normal(scale=3, size=n)),
            motor_torque=rng.normal(scale=3, size=n),
            temperature=20.0 + 0.3 * k,
        )
        for k in range(count)
    ]


def added(effect, states):
    """All that an effect adds at states, as one array."""
    if isinstance(effect, ResolverEffect):
        errors = [effect.error(state.motor_angle, state.motor_speed) for state in states]
        return np.stack([[error.angle, error.speed] for error in errors])
    found, _ = along(effect, states)
    zero = np.zeros_like(states[0].motor_angle)
    parts = [[t.motor, t.spring, t.link] for t in found]
    return np.stack([[zero if part is None else part for part in row] for row in parts])


@every
def test_nothing_is_added_at_the_null_value(kind, irb4600, rng):
    null = without_effect(kind, irb4600)
    assert null.is_null
    if issubclass(kind, NativeEffect):
        changed = null.in_description(irb4600)
        np.testing.assert_array_equal(changed.drive.joint_stiffness, irb4600.drive.joint_stiffness)
    else:
        np.testing.assert_allclose(added(null, chance_states(irb4600, rng)), 0, atol=1e-15)


@every
def test_something_is_added_at_full_size(kind, irb4600, rng):
    strong = drawn(kind, irb4600, rng).effect
    if issubclass(kind, NativeEffect):
        assert np.any(strong.in_description(irb4600).drive.joint_stiffness != irb4600.drive.joint_stiffness)
    else:
        assert np.abs(added(strong, chance_states(irb4600, rng))).max() > 0


def test_no_equation_is_one_of_the_library():
    assert not set(ALL) & set(EFFECTS)
    assert not {kind.equation for kind in ALL.values()} & {kind.equation for kind in EFFECTS.values()}


def test_a_variant_is_of_an_effect_of_the_library():
    assert {kind.variant_of for kind in VARIANTS.values()} <= set(EFFECTS)
    assert len({kind.variant_of for kind in VARIANTS.values()}) >= 20


def test_machines_with_any_of_them_run(irb4600, corners):
    rng = np.random.default_rng(3)
    machines = [
        Machine(robot=irb4600, effects=(drawn(kind, irb4600, rng).effect,), climate=Climate(rise=np.full(6, 20.0)))
        for kind in ALL.values()
    ]
    path = multisine(corners["p1"], np.full((1, 6), 0.004), [2.0], np.zeros((1, 6)), 0.4, ramp=0.15, dwell=0.1)
    runs = [Run(reference=joint_reference(irb4600, path)) for _ in machines]
    coarse = ModelOptions(looks=False, physics_dt=0.001)
    for recording in simulate(runs, machine=machines, options=coarse, n_threads=1):
        e = recording.joint_array("reference.position") - recording.joint_array("motor.position")
        assert np.abs(e).max() < 0.5


FRICTION = [
    tanh_stribeck(share=0.4, width=1.0),
    power_viscous(share=0.3, exponent=0.9, speed=20.0),
    rate_and_state(share=0.3, time=0.1, slip=0.02),
    directional_efficiency(share=0.1, ratio=1.6, slow=0.4),
    damaged_tooth(share=0.5, place=0.005, width=0.01),
    maxwell_slip(share=0.8, travel=0.04),
    two_wave_friction(share=0.2, cycles=20.0, phase=1.0),
]
INSTEAD = (maxwell_slip, two_wave_friction)
"""These change friction that is there, and give back at times what they took before."""


@pytest.mark.parametrize("effect", FRICTION, ids=lambda effect: effect.name)
def test_friction_of_a_motor_that_swings_takes_energy(effect, irb4600):
    phase = np.arange(0, 4 * np.pi, 2e-3)
    angle, speed = 2.0 * np.sin(phase), 4.0 * np.cos(phase)
    states = [
        state_of(
            irb4600,
            motor_angle=np.full(6, x),
            joint_angle=np.full(6, x / 120),
            motor_speed=np.full(6, v),
            friction_sign=np.tanh(np.full(6, 50 * v)),
            load_at_motor=np.full(6, 2 * np.sin(3 * x)),
        )
        for x, v in zip(angle, speed, strict=True)
    ]
    found, _ = along(effect, states)
    torque = np.array([torques.motor[1] for torques in found])
    if isinstance(effect, INSTEAD):
        torque = torque - irb4600.friction.coulomb[1] * np.tanh(50 * speed)
    assert isinstance(effect, INSTEAD) or np.all(torque * speed <= 0)
    assert torque @ speed < 0


def test_maxwell_slip_carries_what_bristles_carry_once_all_elements_slip(irb4600):
    effect = maxwell_slip.on(irb4600, "j1", share=0.5, travel=0.04)
    states = [state_of(irb4600, motor_speed=np.full(6, 1.0), friction_sign=np.ones(6)) for _ in range(60)]
    found, _ = along(effect, states)
    assert found[1].motor[0] > 0.1 * irb4600.friction.coulomb[0]  # softer at first
    assert found[-1].motor[0] == pytest.approx(0, abs=1e-12)


def test_contacts_age_with_the_logarithm_of_time_and_slip_renews_them(irb4600):
    effect = rate_and_state.on(irb4600, share=0.3, time=0.1, slip=0.01)
    sliding, resting = (state_of(irb4600, motor_speed=np.full(6, v), friction_sign=np.ones(6)) for v in (0.5, 0.0))
    old, memory = along(effect, [sliding] * 400)
    full = 0.3 * irb4600.friction.static
    np.testing.assert_allclose(-old[0].motor, full)
    np.testing.assert_allclose(memory[..., 0], 0.01 / 0.5, rtol=1e-3)  # age of steady sliding: slip over speed
    ages = []
    for seconds in (1.0, 10.0):
        _, memory = effect.torques(resting, memory, seconds)
        ages.append(memory[0, 0])
    grown = np.log1p(np.array(ages) / 0.1) / np.log1p(100.0)
    assert 0.4 < grown[0] < grown[1] < 1.05


def test_dahl_is_the_same_loop_at_any_step():
    phase = np.linspace(0, 4 * np.pi, 4001)
    way = 3e-4 * np.sin(phase)
    fine = coarse = np.zeros(1)
    for k in range(4000):
        fine = lagging(fine, np.diff(way)[[k]], np.array([1e-4]))
    for a, b in zip(way[:-1:10], way[10::10], strict=True):
        coarse = lagging(coarse, np.array([b - a]), np.array([1e-4]))
    assert coarse[0] == pytest.approx(fine[0], abs=1e-6)
    assert abs(fine[0]) <= 1


@pytest.mark.parametrize("kind", [dahl_hysteresis, smooth_cable], ids=lambda kind: kind.name)
def test_hysteresis_loses_energy_in_every_loop(kind, irb4600):
    effect = as_strong_as_plausible(kind, irb4600)
    phase = np.arange(0, 6 * np.pi, 0.01)
    rate = 0.05 * np.cos(phase)
    angle = np.cumsum(rate) * DT
    states = [
        state_of(
            irb4600,
            deflection=np.full(6, x),
            deflection_rate=np.full(6, v),
            joint_angle=np.full(6, x),
            joint_speed=np.full(6, v),
        )
        for x, v in zip(angle, rate, strict=True)
    ]
    found, _ = along(effect, states)
    torque = np.array([(t.spring if t.spring is not None else t.link)[0] for t in found])
    last = slice(-round(2 * np.pi / 0.01), None)
    assert torque[last] @ rate[last] < 0


def test_springs_push_back_more_the_further_they_are_wound(irb4600):
    bent = np.linspace(-2e-3, 2e-3, 401)
    for effect in (
        quintic_spring.on(irb4600, growth=0.4),
        stepped_spring.on(irb4600, growth=0.8, width=2e-4),
        round_gap.on(irb4600, half_gap=2e-4),
    ):
        states = [state_of(irb4600, deflection=np.full(6, x)) for x in bent]
        found, _ = along(effect, states)
        k = irb4600.drive.joint_stiffness[0]
        total = k * bent - np.array([torques.spring[0] for torques in found])
        assert np.all(np.diff(total) > -1e-12 * k), effect.name
        np.testing.assert_allclose(total, -total[::-1], atol=1e-9 * k)  # the same both ways


def test_a_round_gap_is_free_in_its_middle_and_a_spring_beyond(irb4600):
    effect, k = round_gap.on(irb4600, half_gap=1e-4), irb4600.drive.joint_stiffness[0]
    inside, outside = (
        k * x - along(effect, [state_of(irb4600, deflection=np.full(6, x))])[0][0].spring[0] for x in (1e-5, 1e-3)
    )
    assert inside < 0.01 * k * 1e-5
    assert outside == pytest.approx(k * (1e-3 - 1e-4), rel=1e-6)


def test_a_gear_error_of_two_waves_makes_no_energy(irb4600):
    effect = two_wave_gear_error.on(irb4600, "j1", amplitude=2e-5, cycles=1.0, phase=0.4)
    phase = np.linspace(0, 2 * np.pi, 20001)[:, None]
    deflection, angle = 1e-3 * np.sin(phase), 0.7 * np.sin(phase + 1.0)
    k = irb4600.drive.joint_stiffness
    drive = {"motor_angle": angle, "deflection": deflection, "load": -k * deflection, "joint_damping": np.zeros(6)}
    state = state_of(irb4600, **{name: value + np.zeros(6) for name, value in drive.items()})
    torques, _ = effect.torques(state, effect.initial_memory(state), DT)
    on_spring = np.trapezoid(torques.spring[:, 0], deflection[:, 0])
    on_motor = np.trapezoid(torques.motor[:, 0], angle[:, 0])
    assert abs(on_spring) > 1e-4
    assert on_motor == pytest.approx(-on_spring, rel=1e-5)


def test_a_resolver_reads_the_speed_of_the_angle_that_it_reads(irb4600):
    effect = two_wave_resolver.on(irb4600, amplitude=5e-4, cycles=1.0, phase=0.3)
    t = np.linspace(0.0, 1.0, 10001)[:, None] + np.zeros(6)
    error = effect.error(5.0 * np.sin(3.0 * t), 15.0 * np.cos(3.0 * t))
    rate = np.gradient(error.angle[:, 0], t[:, 0])
    np.testing.assert_allclose(error.speed[1:-1, 0], rate[1:-1], atol=1e-5)


def test_two_lags_end_at_the_command_and_are_late_by_both(irb4600):
    effect, dt = two_lags.on(irb4600, lag=4e-4), 2.5e-5
    ramp = [state_of(irb4600, motor_torque=np.full(6, 10.0 * dt * k)) for k in range(400)]
    found, _ = along(effect, ramp, dt)
    behind = -found[-1].motor[0] / 10.0
    assert behind == pytest.approx(2 * 4e-4, rel=0.05)
    held, _ = along(effect, [*ramp, *[ramp[-1]] * 400], dt)
    assert held[-1].motor[0] == pytest.approx(0, abs=1e-9)


def test_warm_oil_is_thinner_and_the_description_holds_in_a_cold_room(irb4600):
    effect = vogel_oil.on(irb4600, share=0.8, vogel=900.0)
    braking = [
        -along(effect, [state_of(irb4600, motor_speed=np.full(6, 5.0), temperature=t)])[0][0].motor[0]
        for t in (15.0, 20.0, 35.0)
    ]
    assert braking[0] > braking[1] == 0 > braking[2] > -0.8 * irb4600.friction.viscous[0] * 5.0


def test_a_torque_that_wanders_is_smooth_bounded_and_without_order(irb4600):
    effect = wandering_torque.on(irb4600, share=0.2, draw=0.37)
    t = np.arange(0, 50, DT)[:, None]
    state = state_of(irb4600, time=t + np.zeros(6))
    torque = effect.torques(state, effect.initial_memory(state), DT)[0].motor[:, 0] / irb4600.friction.coulomb[0]
    assert np.abs(torque).max() <= 0.2
    assert np.abs(np.diff(torque)).max() < 0.2 * 2 * 1.5 * DT / 0.25 * 1.01
    values = torque[::250] / 0.2
    assert abs(np.corrcoef(values[1:], values[:-1])[0, 1]) < 0.3
    assert values.std() == pytest.approx(1 / np.sqrt(3), rel=0.2)


@pytest.mark.parametrize("kind", OUTSIDERS.values(), ids=OUTSIDERS.keys())
def test_an_effect_outside_the_library_says_what_must_be_found(kind, irb4600, rng):
    hidden = drawn(kind, irb4600, rng)
    clue = hidden.clue(irb4600)
    assert hidden.answer == ""
    assert clue.words or clue.frequency


@pytest.fixture
def rng():
    return np.random.default_rng(11)
