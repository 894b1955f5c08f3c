"""Where fits of springs begin."""

import numpy as np
import pytest

from ffgym.diagnosis.fit import refine as module
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.effects import EFFECTS

ALONG = [(float(best), 1.3) for best in np.geomspace(0.5, 25.0, 18)]
"""Sizes up to 25 times that of a linear fit: fits of springs come from a third more or less."""


@pytest.mark.parametrize(("best", "within"), [*ALONG, (200.0, 9.0)])
def test_a_spring_begins_near_its_size_however_much_larger_that_is_than_a_linear_fit_says(best, within, monkeypatch):
    """What it leaves is least at `best` times the linear fit."""
    one = Hypothesis(kind=EFFECTS["hardening"], joint="j3", source=None, values={"growth": np.array(1e4)})
    tries = []

    def left(setting, hypotheses):
        tries.append(float(hypotheses[-1].values["growth"]) / 1e4)
        return abs(np.log(tries[-1] / best))

    monkeypatch.setattr(module, "compute_rss", left)
    (begun,) = module._choose_start(None, [one])
    size = float(begun.values["growth"]) / 1e4
    assert 1 / within < size / best < within
    assert len(tries) <= len(module._SIZES) + module._FURTHER
