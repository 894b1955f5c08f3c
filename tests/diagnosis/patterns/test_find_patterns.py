"""Something is put into residuals, and what it depends on is found; in noise nothing is."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from ffgym.diagnosis.patterns import find_patterns
from ffgym.diagnosis.settings import settings
from tests.diagnosis.patterns.pattern_samples import ELBOW, NOISY, SHOULDER, only, residual_with

LINE, CYCLES = 17.0, 2.0


def bump(state, travel):
    """A spot of the gear that rubs, in either direction."""
    return only(1, 6 * state.friction_sign[:, 1] * np.exp(-0.5 * (state.motor_angle[:, 1] - 5.0) ** 2))


PUT_IN = {
    "a vibration in time": (
        lambda state, travel: only(0, 2 * np.sin(2 * np.pi * LINE * state.time[:, 0] + 1)),
        (SHOULDER, "line", "time"),
    ),
    "a sine of the motor angle": (
        lambda state, travel: only(0, 2 * np.sin(CYCLES * state.motor_angle[:, 0] + 0.3)),
        (SHOULDER, "periodic", "motor angle"),
    ),
    "a worn spot": (bump, (ELBOW, "sign-locked function", "motor angle")),
    "friction with the load": (
        lambda state, travel: only(0, 6 * np.abs(state.load_at_motor[:, 0]) * state.friction_sign[:, 0]),
        (SHOULDER, "sign-locked function", "load"),
    ),
    "a peak after reversals": (
        lambda state, travel: only(0, 4 * np.exp(-travel[:, 0] / 0.1) * state.friction_sign[:, 0]),
        (SHOULDER, "sign-locked function", "travel since the last reversal"),
    ),
    "drag of either direction": (
        lambda state, travel: only(0, 3 * (state.motor_speed[:, 0] / 20.0) ** 2),
        (SHOULDER, "function", "size of the motor speed"),
    ),
    "a program of the motion's clock": (
        lambda state, travel: only(0, 1.5 * np.sign(np.sin(state.time[:, 0] ** 1.7))),
        (SHOULDER, "function", "time"),
    ),
    "another joint's inertia": (
        lambda state, travel: only(1, np.gradient(state.motor_speed[:, 0], 0.008) / 20),
        (ELBOW, "function", f"motor acceleration of {SHOULDER}"),
    ),
    "friction that another joint's speed brings": (
        lambda state, travel: only(1, 4 * state.friction_sign[:, 1] * np.abs(state.motor_speed[:, 0]) / 20),
        (ELBOW, "sign-locked function", f"size of the motor speed of {SHOULDER}"),
    ),
    "another joint's friction": (
        lambda state, travel: only(1, 1.5 * state.friction_sign[:, 0]),
        (ELBOW, "sign-locked function", f"motor speed of {SHOULDER}"),
    ),
}


def found(torque, seed):
    return find_patterns(residual_with(torque, seed=seed), np.random.default_rng(seed))


def name(pattern):
    return pattern.component, pattern.kind, pattern.variable


@pytest.mark.parametrize("case", PUT_IN)
def test_the_strongest_pattern_is_what_was_put_in(case):
    torque, expected = PUT_IN[case]
    strongest = [found(torque, seed)[0] for seed in range(3)]
    assert [name(pattern) for pattern in strongest] == [expected] * 3
    assert all(pattern.share > 0.3 for pattern in strongest)


@pytest.mark.slow
@pytest.mark.parametrize("case", PUT_IN)
def test_it_is_so_in_four_of_five_logs_when_it_is_weaker_than_the_noise(case):
    torque, expected = PUT_IN[case]
    strongest = [found(lambda *motion: 0.6 * torque(*motion), seed)[:1] for seed in range(20)]
    assert sum([name(p) for p in patterns] == [expected] for patterns in strongest) >= 16


def strongest_of(torque):
    """The strongest pattern of a residual with something in it."""
    return find_patterns(residual_with(torque), np.random.default_rng(1))[0]


def test_a_vibration_has_its_frequency_and_its_amplitude():
    (pattern,) = found(PUT_IN["a vibration in time"][0], 0)
    assert pattern.frequency == pytest.approx(LINE, abs=0.01)
    assert pattern.amplitude == pytest.approx(2 * NOISY, rel=0.1)
    assert pattern.message.startswith(f"torque of {SHOULDER}: vibration at 17.00 Hz, whatever moves")


def test_a_brake_that_drags_in_time_turns_over_with_the_direction():
    def drags(state, travel):
        time = np.broadcast_to(state.time, state.motor_speed.shape)[:, 0]
        return only(0, 3 * np.sign(state.motor_speed[:, 0]) * np.sin(2 * np.pi * 7.3 * time))

    found = strongest_of(drags)
    assert found.kind == "line"
    assert found.frequency == pytest.approx(7.3, abs=0.05)
    assert f"turned over with the direction of {SHOULDER}" in found.message


def test_what_goes_with_power_is_a_function_of_it():
    """Of a torque that has a rhythm of its own."""
    residual = residual_with()
    motions = []
    for motion in residual.motions:
        torque = np.sin(3.1 * motion.t)[:, None] * np.ones(2)
        power = (motion.state.motor_speed * torque)[:, 1]
        measured = motion.measured["torque"] + only(1, 3 * NOISY * power / power.std())
        state = motion.state.with_values(motor_torque=torque)
        motions.append(replace(motion, state=state, measured={"torque": measured}))
    found = find_patterns(replace(residual, motions=tuple(motions)), np.random.default_rng(1))[0]
    assert (found.component, found.variable, found.kind) == (ELBOW, "speed times torque", "function")


def test_what_grows_with_the_way_is_a_function_of_it():
    def way(state, travel):
        gone = np.cumsum(np.abs(np.diff(state.motor_angle[:, 1], prepend=state.motor_angle[0, 1])))
        return only(1, 4 * np.sin(gone / gone[-1] * 2 * np.pi))

    assert strongest_of(way).variable in ("way since the motion began", "time")


@pytest.mark.parametrize("cycles", [0.9, 2.0, 6.5, 21.0])
def test_a_period_has_its_cycles_per_turn_within_a_tenth(cycles):
    (pattern,) = found(lambda state, _: only(0, 2 * np.sin(cycles * state.motor_angle[:, 0])), 1)
    assert pattern.frequency == pytest.approx(cycles, abs=0.1)
    assert f"{cycles:.1f} cycles per turn, amplitude independent of torque" in pattern.message


def slow_misfit(seed, ripple):
    """Torque of a slow misfit of no form, ten times as loud as noise, and ripple that is as loud as noise."""

    def torque(state, travel):
        rng = np.random.default_rng((seed, len(travel)))
        slow = gaussian_filter1d(rng.standard_normal(len(travel)), 25.0)
        return only(0, 10 * slow / slow.std() + ripple * np.sin(6.5 * state.motor_angle[:, 0]))

    return [p for p in found(torque, seed) if p.kind == "periodic"]


def test_ripple_is_found_beside_a_slow_misfit_that_is_much_louder():
    for seed in range(3):
        (pattern,) = slow_misfit(seed, 1.5)
        assert pattern.component == SHOULDER
        assert pattern.frequency == pytest.approx(6.5, abs=0.1)


def test_a_slow_misfit_has_no_ripple_of_its_own():
    assert sum(len(slow_misfit(seed, 0.0)) for seed in range(20)) == 0


def test_a_period_says_what_its_amplitude_goes_with():
    def swing(gain):
        return found(lambda state, _: only(0, gain(state) * np.sin(3 * state.motor_angle[:, 0])), 2)[0].message

    assert "turned over with the direction" in swing(lambda state: 3 * state.friction_sign[:, 0])
    assert "square of the speed" in swing(lambda state: (state.motor_speed[:, 0] / 10.0) ** 2)


def test_the_second_pattern_is_what_the_first_leaves():
    line, period = PUT_IN["a vibration in time"], PUT_IN["a sine of the motor angle"]
    patterns = found(lambda *motion: 2 * line[0](*motion) + period[0](*motion), 0)
    assert [name(pattern) for pattern in patterns] == [line[1], period[1]]
    assert patterns[0].share > patterns[1].share > settings().patterns.least_share


def test_offsets_between_motions_are_no_dependence():
    level = {0.4: 1.0, 25.0: -2.0, 5.0: 3.0}  # by the largest speed of the motion
    patterns = found(
        lambda state, _: np.full_like(state.motor_speed, level[round(float(state.motor_speed.max()), 1)]), 0
    )
    assert patterns == ()


def test_what_no_form_describes_is_a_dependence_without_one():
    def loud(state, travel):
        return only(0, np.random.default_rng(5).normal(size=len(travel)) * 6 * (state.motor_speed[:, 0] > 1.0))

    (pattern,) = found(loud, 0)
    assert (pattern.kind, pattern.variable, pattern.share) == ("dependence", "motor speed", 0.0)
    assert "depends on the motor speed" in pattern.message


def found_in_noise(seed):
    """Patterns in noise that the floor is half of, so that nothing but the tests themselves holds them back."""
    residual = residual_with(seed=seed)
    underrated = replace(residual, floor={channel: 0.5 * rms for channel, rms in residual.floor.items()})
    return find_patterns(underrated, np.random.default_rng(seed))


def test_nothing_is_found_in_filtered_noise():
    assert [patterns for seed in range(5) if (patterns := found_in_noise(seed))] == []


def test_what_wanders_with_nothing_is_said_to_wander_with_time():
    def drift(state, travel):
        knots = np.random.default_rng(round(float(state.motor_speed.max()))).normal(size=60)  # others in each motion
        return only(0, 2 * np.interp(state.time[:, 0], 0.25 * np.arange(60), knots))

    (pattern,) = found(drift, 0)
    assert (pattern.kind, pattern.variable) == ("dependence", "time")
    assert "wanders with time" in pattern.message


def test_nothing_is_looked_for_in_what_the_floor_explains():
    torque, _ = PUT_IN["a vibration in time"]
    residual = residual_with(torque)
    as_loud = replace(residual, floor={"torque": 2 * residual.floor["torque"]})
    assert find_patterns(as_loud, np.random.default_rng(0)) == ()


@pytest.mark.slow
def test_noise_shows_a_pattern_in_one_log_of_a_hundred_at_most():
    assert sum(bool(found_in_noise(seed)) for seed in range(300)) <= 8  # 3 expected; more than 8 has a chance of 0.4 %


def test_the_same_residual_gives_the_same_patterns():
    torque = PUT_IN["a sine of the motor angle"][0]
    assert found(torque, 3) == found(torque, 3)


def test_a_short_log_gives_no_pattern():
    residual = residual_with(PUT_IN["a vibration in time"][0])
    for motion in residual.motions:
        motion.valid[60:] = False
    assert find_patterns(residual, np.random.default_rng(0)) == ()
