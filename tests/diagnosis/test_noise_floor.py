"""How large residuals of a faultless machine are, motion by motion."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis import noise as module
from ffgym.diagnosis.noise import Faultless


@pytest.mark.parametrize(("channel", "least"), [("torque", 0.3), ("servo", 1.0)])
def test_no_motion_has_much_less_noise_than_all_though_an_encoder_shows_none_while_it_stands(
    monkeypatch, channel, least
):
    """A thousand rows of motion with noise of 2, a thousand at rest without."""
    valid = np.ones((1000, 2), dtype=np.bool_)
    monkeypatch.setattr(module, "valid_rows", lambda log: valid)
    draws = np.zeros((1000, 2, 1, 1))
    draws[:, 0] = 2.0
    floor = Faultless(draws={channel: draws}).floor(SimpleNamespace())[channel]
    overall = np.sqrt(2.0)
    assert floor[0, 0] == pytest.approx(2.0)
    assert floor[1, 0] == pytest.approx(least * overall)
