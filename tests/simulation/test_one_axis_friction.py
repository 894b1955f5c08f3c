"""The one-axis test of the thesis (4.3.1): what each law removes, and where the static law leaves an error."""

import numpy as np
import pytest
from scipy.signal import find_peaks

from ffgym.core.errors import FFGymError
from ffgym.recordings.metrics import motor_error
from ffgym.studies import one_axis_study
from ffgym.studies.one_axis import SETTLED

FREQUENCIES = (1.0, 3.0)
WINDOW = 0.06
"""Time after a velocity reversal within which the static law's error lies [s]."""


@pytest.fixture(scope="module")
def study(one_axis):
    return one_axis_study(one_axis)


def result(study, agent, frequency):
    (found,) = (r for r in study.results if r.agent == agent and r.frequency_hz == frequency)
    return found


def settled_error(study, agent, frequency):
    """Times since the last velocity reversal [s] and |error| [rad], from SETTLED on."""
    recording = study.recordings[agent, frequency]
    rows = recording.t >= SETTLED
    since = np.mod(recording.t[rows] - 0.25 / frequency, 0.5 / frequency)
    return since, np.abs(motor_error(recording)[rows, 0])


@pytest.mark.parametrize("frequency", FREQUENCIES)
def test_dynamic_lugre_removes_more_than_95_percent_of_the_motor_error(study, frequency):
    assert result(study, "none", frequency).motor_rms_rad > 0.01
    assert result(study, "lugre_dynamic", frequency).reduction > 0.95


@pytest.mark.parametrize("frequency", FREQUENCIES)
def test_static_lugre_is_worse_than_dynamic_and_better_than_nothing(study, frequency):
    none, static, dynamic = (
        result(study, agent, frequency) for agent in ("none", "lugre_static", "lugre_dynamic")
    )  # fmt: skip
    assert dynamic.motor_rms_rad < 0.7 * static.motor_rms_rad
    assert static.motor_rms_rad < 0.2 * none.motor_rms_rad
    assert dynamic.motor_max_rad < 0.5 * static.motor_max_rad


@pytest.mark.parametrize("frequency", FREQUENCIES)
def test_static_lugre_leaves_one_peak_after_every_velocity_reversal(study, frequency):
    recording = study.recordings["lugre_static", frequency]
    error = np.abs(motor_error(recording)[:, 0])
    settled = error[recording.t >= SETTLED].max()
    peaks, _ = find_peaks(error, height=0.6 * settled, distance=round(0.25 / frequency / recording.dt))
    times = recording.t[peaks]
    count = int(2 * frequency * (recording.t[-1] - SETTLED))
    reversals = (0.25 + 0.5 * np.arange(4 * count)) / frequency
    reversals = reversals[(reversals >= SETTLED) & (reversals < recording.t[-1] - WINDOW)]
    assert len(reversals) >= count - 1
    for reversal in reversals:
        after = times[(times >= reversal) & (times < reversal + 0.5 / frequency)]
        assert len(after) == 1, f"{len(after)} peaks after the reversal at {reversal:.3f} s"
        assert after[0] - reversal < 0.75 * WINDOW


@pytest.mark.parametrize("frequency", FREQUENCIES)
def test_away_from_reversals_the_static_law_leaves_much_less(study, frequency):
    since, error = settled_error(study, "lugre_static", frequency)
    near, away = error[since < WINDOW], error[since >= WINDOW]
    assert away.max() < 0.4 * near.max()
    assert np.sqrt(np.mean(away**2)) < 0.35 * np.sqrt(np.mean(near**2))


@pytest.mark.parametrize("frequency", FREQUENCIES)
def test_dynamic_law_leaves_no_peak_at_reversals_of_the_size_that_the_static_law_does(study, frequency):
    since, static = settled_error(study, "lugre_static", frequency)
    _, dynamic = settled_error(study, "lugre_dynamic", frequency)
    assert dynamic[since < WINDOW].max() < 0.35 * static[since < WINDOW].max()


def test_more_than_one_joint_is_refused(irb4600):
    with pytest.raises(FFGymError, match="has 6 joints; the sine test is for one"):
        one_axis_study(irb4600)
