"""The periodogram over the motor angle."""

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.patterns import compute_turn_spectrum
from tests.diagnosis.patterns.pattern_samples import ELBOW, SHOULDER, only, residual_with


def test_a_pure_sine_is_explained_whole_at_its_frequency():
    residual = residual_with(lambda state, _: only(0, 50 * np.sin(4 * state.motor_angle[:, 0])))
    spectrum = compute_turn_spectrum(residual, "torque", SHOULDER, SHOULDER)
    assert spectrum.best == pytest.approx(4.0, abs=0.05)
    assert spectrum.share.max() == pytest.approx(1.0, abs=0.1)


def test_the_spectrum_is_what_least_squares_with_a_mean_for_each_motion_explains():
    residual = residual_with(lambda state, _: only(0, np.sin(1.7 * state.motor_angle[:, 0])))
    spectrum = compute_turn_spectrum(residual, "torque", SHOULDER, SHOULDER)
    values = np.concatenate(
        [m.residual["torque"][m.valid, 0] - m.residual["torque"][m.valid, 0].mean() for m in residual.motions]
    )
    for k in np.linspace(0, np.sum(spectrum.frequency < 3.0), 5).astype(int):
        phase = [spectrum.frequency[k] * m.state.motor_angle[m.valid, 0] for m in residual.motions]
        columns = np.concatenate([np.stack([f(p) - f(p).mean() for f in (np.cos, np.sin)], axis=1) for p in phase])
        left = values - columns @ np.linalg.lstsq(columns, values)[0]
        assert spectrum.share[k] == pytest.approx(1 - left @ left / (values @ values), abs=0.02)


def test_frequencies_rise_and_end_where_rows_show_nothing():
    spectrum = compute_turn_spectrum(residual_with(), "torque", ELBOW, SHOULDER)
    assert (np.diff(spectrum.frequency) > 0).all()
    assert spectrum.frequency[0] >= 0.5
    assert spectrum.frequency[-1] <= 72.0


def test_a_motor_that_hardly_turns_has_no_spectrum():
    residual = residual_with()
    for motion in residual.motions:
        motion.state.motor_angle[:] *= 1e-4
    assert compute_turn_spectrum(residual, "torque", SHOULDER, SHOULDER) is None


@pytest.mark.parametrize(("channel", "component", "joint"), [("tool", "x", SHOULDER), ("torque", "x", SHOULDER)])
def test_what_is_not_there_is_named(channel, component, joint):
    with pytest.raises(FFGymError, match=r"channel|component"):
        compute_turn_spectrum(residual_with(), channel, component, joint)
