"""The one-axis study compares each law with the first, at each frequency."""

import numpy as np
import pytest

from ffgym.control import NoCompensation, StaticLuGre
from ffgym.core.errors import FFGymError
from ffgym.recordings.metrics import motor_error
from ffgym.studies import one_axis_study
from ffgym.studies.one_axis import AMPLITUDE, DURATION, FREQUENCIES, SETTLED


@pytest.fixture(scope="module")
def study(one_axis):
    return one_axis_study(one_axis)


def test_there_is_one_result_per_law_and_frequency(study):
    agents = ("none", "lugre_static", "lugre_dynamic")
    assert [(r.frequency_hz, r.agent) for r in study.results] == [(f, a) for f in FREQUENCIES for a in agents]
    assert study.recordings.keys() == {(a, f) for a in agents for f in FREQUENCIES}


def test_recordings_are_sines_of_the_thesis(study):
    assert (AMPLITUDE, FREQUENCIES, DURATION) == (1.0, (1.0, 3.0), 10.0)
    for (_, frequency), recording in study.recordings.items():
        wanted = AMPLITUDE * np.sin(2 * np.pi * frequency * recording.t)
        np.testing.assert_allclose(recording["reference.position.j1"], wanted, atol=2e-4)
        assert recording.t[-1] == pytest.approx(DURATION)


def test_results_are_the_motor_error_after_it_has_settled(study):
    for result in study.results:
        recording = study.recordings[result.agent, result.frequency_hz]
        error = motor_error(recording)[recording.t >= SETTLED, 0]
        assert result.motor_rms_rad == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-12)
        assert result.motor_max_rad == np.abs(error).max()


def test_reduction_is_relative_to_the_first_law(study):
    for result in study.results:
        (first,) = [r for r in study.results if r.frequency_hz == result.frequency_hz and r.agent == "none"]
        assert result.reduction == pytest.approx(1 - result.motor_rms_rad / first.motor_rms_rad)
        assert (result.reduction == 0) == (result.agent == "none")
        assert result.reduction == 0 or result.reduction > 0.5  # the thesis: most of the error is gone


def test_two_runs_are_equal(one_axis, study):
    again = one_axis_study(one_axis)
    assert again.results == study.results
    assert all(again.recordings[key].equals(recording) for key, recording in study.recordings.items())


def test_laws_and_frequencies_may_be_chosen(one_axis, study):
    laws = [NoCompensation(), StaticLuGre(one_axis.friction)]
    chosen = one_axis_study(one_axis, laws=laws, frequencies=[3.0])
    assert chosen.results == [r for r in study.results if r.frequency_hz == 3.0 and r.agent != "lugre_dynamic"]


def test_a_robot_with_six_axes_is_refused(irb4600):
    with pytest.raises(FFGymError, match="'irb4600_60_205' has 6 joints; the sine test is for one"):
        one_axis_study(irb4600)


@pytest.mark.parametrize("changes", [{"frequencies": [0.0]}, {"frequencies": []}, {"laws": []}, {"frequencies": [1e3]}])
def test_a_study_that_cannot_run_is_refused(one_axis, changes):
    with pytest.raises(FFGymError):
        one_axis_study(one_axis, **changes)


def test_two_laws_of_one_name_are_refused(one_axis):
    with pytest.raises(FFGymError, match="different names"):
        one_axis_study(one_axis, laws=[NoCompensation(), NoCompensation()])


def test_a_part_of_a_sine_test_keeps_its_results(study):
    part = study.only(laws=["none", "lugre_static"], frequencies=[3.0])
    assert part.results == [r for r in study.results if r.frequency_hz == 3.0 and r.agent != "lugre_dynamic"]
    assert list(part.recordings) == [("none", 3.0), ("lugre_static", 3.0)]
    with pytest.raises(FFGymError, match=r"The study has no frequency 2\.0"):
        study.only(frequencies=[2.0])
