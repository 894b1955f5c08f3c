"""What is enough to be adopted: a quarter from one joint, less from a machine whose components all agree."""

from types import SimpleNamespace

import pytest

from ffgym.diagnosis.fit.leftover import Removed
from ffgym.diagnosis.search import worth as module
from ffgym.diagnosis.search.worth import EXPLAINS, explains_most, is_worth


@pytest.mark.parametrize(
    ("joint", "heard", "share", "enough"),
    [
        ("j1", 1, 1.1 * EXPLAINS, True),
        ("j1", 4, 0.9 * EXPLAINS, False),
        ("", 4, 0.9 * EXPLAINS, True),
        ("", 4, 0.45 * EXPLAINS, False),
        ("", 1, 0.9 * EXPLAINS, False),
        ("", 0, 0.9 * EXPLAINS, False),
    ],
)
def test_a_cause_of_the_whole_machine_has_as_many_witnesses_as_components(monkeypatch, joint, heard, share, enough):
    gone = Removed(of_excess=share, of_all=share, excess=0.9, heard=heard, best=share)
    monkeypatch.setattr(module, "removed_by", lambda *fits: gone)
    before, after = SimpleNamespace(total=10.0), SimpleNamespace(total=5.0, hypothesis=SimpleNamespace(joint=joint))
    assert is_worth(None, None, before, after) == enough
    assert not is_worth(None, None, after, SimpleNamespace(total=6.0, hypothesis=after.hypothesis))


@pytest.mark.parametrize(("share", "best", "most"), [(0.6, 0.0, True), (0.3, 0.6, True), (0.3, 0.4, False)])
def test_causes_that_explain_no_component_well_are_none(monkeypatch, share, best, most):
    gone = Removed(of_excess=share, of_all=share, excess=0.9, heard=3, best=best)
    for name in ("loudness", "without_calibration", "touched"):
        monkeypatch.setattr(module, name, lambda *given: {})
    monkeypatch.setattr(module, "removed", lambda *given: gone)
    fit = SimpleNamespace(columns=())
    assert explains_most(None, SimpleNamespace(fit=fit), SimpleNamespace(fit=fit)) == most
