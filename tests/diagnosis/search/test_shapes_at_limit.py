"""Shapes that a fit moved to the end of their range are told if they matter to the log."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.search import significance as module
from ffgym.diagnosis.search.significance import find_shapes_at_limit
from ffgym.diagnosis.settings import settings
from ffgym.effects import EFFECTS

KIND = EFFECTS["coulomb_drift"]
(SHAPE,) = (p for p in KIND.parameters().values() if p.role == "shape")
LIMITS = settings().significance
NEAR = LIMITS.at_range_end * (SHAPE.high - SHAPE.low)
MIDDLE = 0.5 * (SHAPE.low + SHAPE.high)


def at_limit(values, loud=1.01):
    """Shapes at the end of their range, of a cause that is as loud as given in units of what is seen."""
    cause = Hypothesis(
        kind=KIND, joint="j1", source=None, values={"share": np.array(0.1), SHAPE.name: np.array(values)}
    )
    rows = np.array([1.0, 2.0, 2.0])  # energy 9, or 4 times that as weights are 2
    quiet = {("torque", 0): np.zeros(3)}
    column = {("torque", 0): rows * np.sqrt(loud * LIMITS.seen_shape / 36)}
    free = [number.name for number in cause.list_free()]
    fit = SimpleNamespace(hypotheses=(cause,), columns=[column if name == SHAPE.name else quiet for name in free])
    problem = SimpleNamespace(weights={("torque", 0): 2.0})
    return [name for _, name in find_shapes_at_limit(problem, fit)]


@pytest.mark.parametrize(
    ("value", "found"),
    [
        (SHAPE.low, True),
        (SHAPE.low + 0.9 * NEAR, True),
        (SHAPE.low + NEAR, True),
        (SHAPE.low + 1.05 * NEAR, False),
        (MIDDLE, False),
        (SHAPE.high - 1.05 * NEAR, False),
        (SHAPE.high - NEAR, True),
        (SHAPE.high - 0.9 * NEAR, True),
        (SHAPE.high, True),
    ],
)
def test_a_shape_is_at_its_limit_near_either_end(value, found):
    assert at_limit(value) == [SHAPE.name] * found


def test_a_shape_that_is_not_heard_does_not_matter():
    assert at_limit(SHAPE.high, loud=0.99) == []


def test_a_shape_that_was_not_moved_from_its_default_is_where_it_was_put(monkeypatch):
    wide = SimpleNamespace(significance=SimpleNamespace(at_range_end=1.0, seen_shape=LIMITS.seen_shape))
    monkeypatch.setattr(module, "settings", lambda: wide)
    assert SHAPE.default not in (None, MIDDLE)
    assert at_limit(MIDDLE) == [SHAPE.name]
    assert at_limit(SHAPE.default) == []
