"""Regressors as data: what they count, and what makes none."""

import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.identification.narx import Regressors, lags_of


def test_regressors_say_how_many_they_are_and_what_must_be_remembered():
    everything = Regressors(speed_lags=(0, 40), slip_widths=(0.002, 0.008), output_lags=(1, 5))
    assert (everything.n_inputs, everything.count) == (4, 6)
    assert (everything.n_past_speeds, everything.n_past_outputs) == (40, 5)
    assert Regressors(slip_widths=(0.01,)).n_past_speeds == 1  # an element needs the way since the last sample
    assert Regressors(speed_lags=(0,), output_lags=()).n_past_outputs == 0


def test_lags_can_be_given_in_time():
    assert lags_of([0.0, 0.0005, 0.02], 0.0005) == (0, 1, 40)
    with pytest.raises(FFGymError, match="fall on one sample"):
        lags_of([0.0, 0.001], 0.004)


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"speed_lags": (-1,)}, "speed_lags = -1"),
        ({"output_lags": (0,)}, "output_lags = 0"),
        ({"slip_widths": (0.0,)}, "slip_widths = 0.0"),
        ({"speed_lags": (0, 0)}, "names one regressor twice"),
        ({"speed_lags": ()}, "both empty"),
    ],
)
def test_what_no_network_can_see_is_refused(wrong, told):
    with pytest.raises(FFGymError, match=told):
        Regressors(**wrong)
