"""Given sines, speed ladders and triangles: derivatives, limits and where they return to."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from path_differences import central

from ffgym.core.errors import FFGymError
from ffgym.paths.excitations import (
    SpeedStep,
    joint_sine,
    multisine,
    schroeder_phases,
    speed_ladder,
    speed_steps,
    triangle,
)

few = settings(max_examples=20)
sizes = st.floats(0.01, 2.0)


def check_motion(path, jerk):
    """Derivatives are derivatives, jerk is bounded, both ends are at rest."""
    dt = path.t[1]
    np.testing.assert_allclose(central(path.q, dt), path.dq[1:-1], atol=jerk * dt**2 + 1e-9)
    np.testing.assert_allclose(central(path.dq, dt), path.ddq[1:-1], atol=jerk * dt + 1e-9)
    assert np.abs(np.diff(path.ddq, axis=0)).max() <= jerk * dt * (1 + 1e-6) + 1e-9
    np.testing.assert_array_equal(path.dq[[0, -1]], 0)
    assert path.phases[0].kind == path.phases[-1].kind == "standstill"


@few
@given(amplitude=st.lists(sizes, min_size=2, max_size=2), frequency=st.floats(0.2, 2), ramp=st.floats(0.1, 1.0))
def test_a_multisine_is_the_sum_of_its_sines_between_its_fades(amplitude, frequency, ramp):
    frequencies, size = frequency * np.array([1.0, 2.0, 3.0]), np.tile(amplitude, (3, 1))
    phases = schroeder_phases(3, 2)
    path = multisine([0.5, -1], size, frequencies, phases, 2 * ramp + 2.0, ramp=ramp, dwell=0.2, dt=1e-3)
    omega = 2 * np.pi * frequencies[-1] + 6 / ramp
    check_motion(path, 20 * max(amplitude) * omega**3)
    inside = (path.t > 0.2 + ramp) & (path.t < 0.2 + ramp + 2.0)
    angle = 2 * np.pi * frequencies[:, None] * (path.t[inside] - 0.2)[:, None, None] + phases
    np.testing.assert_allclose(path.q[inside], np.array([0.5, -1]) + (size * np.sin(angle)).sum(axis=1), atol=1e-9)
    np.testing.assert_array_equal(path.q[[0, -1]], [[0.5, -1]] * 2)


def test_schroeder_phases_keep_the_peak_low_and_joints_apart():
    n, t = 20, np.linspace(0, 1, 5000, endpoint=False)[:, None, None]
    angle = 2 * np.pi * np.arange(1, n + 1)[:, None] * t
    waves = np.sin(angle + schroeder_phases(n, 3)).sum(axis=1)
    aligned = np.cos(angle).sum(axis=1)
    assert np.abs(waves).max() < 0.45 * np.abs(aligned).max()
    likeness = np.abs(np.corrcoef(waves.T) - np.eye(3)).max()
    assert likeness < 0.1
    np.testing.assert_allclose(np.roll(waves[:, 1], -5000 // 3), waves[:, 0], atol=0.05 * np.abs(waves).max())


@few
@given(amplitude=st.lists(st.floats(-1, 1), min_size=2, max_size=2).filter(any), period=st.floats(1.0, 8.0))
def test_a_triangle_reaches_its_amplitude_at_constant_speed(amplitude, period):
    ramp, size = 0.2, np.array(amplitude)
    path = triangle([0.3, 0], size, period, 3, ramp=ramp, dwell=0.1, dt=1e-3)
    speed = np.abs(path.dq).max()
    check_motion(path, 12 * speed / ramp**2)
    np.testing.assert_allclose(np.abs(path.q - [0.3, 0]).max(axis=0), np.abs(size), rtol=1e-4, atol=1e-9)
    np.testing.assert_allclose(path.q[[0, -1]], [[0.3, 0]] * 2, atol=1e-12)
    turns = [p.start + ramp / 2 for p in path.phases if p.label == "reversal"]
    np.testing.assert_allclose(np.diff(turns), period / 2, rtol=1e-9)
    slopes = [p for p in path.phases if p.label.startswith("slope")]
    for phase in slopes:
        rows = (path.t > phase.start + 1e-9) & (path.t < phase.end - 1e-9)
        assert np.ptp(path.dq[rows], axis=0).max() == 0


@few
@given(speeds=st.lists(st.floats(0.05, 1), min_size=1, max_size=3), travel=st.floats(0.1, 0.5))
def test_a_ladder_runs_each_joint_forwards_and_back_at_each_speed(speeds, travel):
    steps = np.column_stack([speeds, np.zeros(len(speeds)), speeds])
    path = speed_ladder([0.0, 1, 2], steps, np.full(3, travel), longest=2.0, dt=1e-3)
    check_motion(path, 12 * max(speeds) / 0.2**2)
    np.testing.assert_allclose(path.q[-1], [0, 1, 2], atol=1e-12)
    np.testing.assert_array_equal(path.q[:, 1], 1)
    assert not np.any((path.dq[:, 0] != 0) & (path.dq[:, 2] != 0))
    runs = [p for p in path.phases if p.label.endswith(("forwards", "back"))]
    assert len(runs) == 4 * len(speeds)
    for i, phase in enumerate(runs):
        rows = (path.t > phase.start + 1e-9) & (path.t < phase.end - 1e-9)
        speed = (1 if i % 2 == 0 else -1) * speeds[(i // 2) % len(speeds)]
        np.testing.assert_array_equal(path.dq[rows].sum(axis=1), speed)
        assert phase.end - phase.start == pytest.approx(min(travel / abs(speed), 2.0))


def test_speeds_may_follow_each_other_without_a_rest():
    steps = [SpeedStep(velocity=np.array([v]), duration=0.5, label=f"{v}") for v in (0.1, 0.3, -0.2)]
    path = speed_steps(np.zeros(1), steps, ramp=0.2, dwell=0.1, dt=1e-3, name="steps")
    check_motion(path, 12 * 0.5 / 0.2**2)
    assert path.q[-1, 0] == pytest.approx(0.5 * 0.2 + 0.2 * (0.05 + 0.2 + 0.05 - 0.1))
    assert [p.kind for p in path.phases][1:3] == ["lead_in", "motion"]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: multisine([0.0], np.ones((1, 1)), [0.0], np.zeros((1, 1)), 2.0), "frequencies"),
        (lambda: multisine([0.0], np.ones((2, 1)), [1.0], np.zeros((1, 1)), 2.0), "amplitude"),
        (lambda: multisine([0.0], np.ones((1, 1)), [1.0], np.zeros((1, 1)), 0.5), "duration"),
        (lambda: joint_sine([1.0], 1e308, 2.0), "below half the sample rate, which is 125 Hz"),
        (lambda: joint_sine([1.0], 1.0, 2.0, dt=0.0), "dt = 0.0 s is out of range"),
        (lambda: triangle([0.0], [0.0], 2.0), "amplitude is zero"),
        (lambda: triangle([0.0], [1.0], 0.8), "period"),
        (lambda: triangle([0.0], [1.0], 2.0, 0), "n_periods"),
        (lambda: speed_ladder([0.0], np.zeros((1, 1)), [1.0]), "A ladder needs speeds"),
        (lambda: speed_ladder([0.0], -np.ones((1, 1)), [1.0]), "A ladder needs speeds"),
        (lambda: speed_ladder([0.0], np.ones((1, 1)), [0.0]), "travel"),
    ],
)
def test_excitations_that_make_no_sense_are_refused(call, message):
    with pytest.raises(FFGymError, match=message):
        call()
