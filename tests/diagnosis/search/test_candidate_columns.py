"""Columns of candidates beside nuisance parameters: their scale, bounds and groups."""

import numpy as np
import pytest

from ffgym.diagnosis.nuisance import NuisanceParameter
from ffgym.diagnosis.resampling import cut_blocks
from ffgym.diagnosis.search.candidates import build_candidates
from ffgym.diagnosis.sensitivity import Sensitivity
from ffgym.diagnosis.settings import settings
from ffgym.effects import EFFECTS

KEY = ("torque", 0)
ROWS = np.linspace(0.0, 1.0, 300)[:, None]


def column(name, parameter, rows, **of):
    return Sensitivity(effect=EFFECTS[name], joint="j1", parameter=parameter, parts={KEY: rows}, **of)


@pytest.fixture
def candidates():
    """One nuisance parameter, then a one-sided size, a size of both signs, and a wave of two phases."""
    blocks = cut_blocks(np.ones((300, 1), dtype=bool), 0.01)
    known = column("viscous_level", "change", ROWS)
    nuisance = NuisanceParameter(column=known, sigma=0.2, at=0.5)
    effects = [
        column("load_friction", "share", ROWS**2),
        column("coulomb_level", "change", ROWS**3),
        *(column("cogging", "amplitude", ROWS**k, span=k - 4, choice=3) for k in (4, 5)),
    ]
    return build_candidates([nuisance], effects, blocks, {KEY: np.array([2.0])})


def step(name, parameter):
    p = EFFECTS[name].parameters()[parameter]
    end = p.high if abs(p.high - p.neutral) >= abs(p.low - p.neutral) else p.low
    return settings().screening.step * abs(end - p.neutral)


def test_columns_are_in_standard_deviations_and_practical_steps(candidates):
    steps = [step("load_friction", "share"), step("coulomb_level", "change"), *[step("cogging", "amplitude")] * 2]
    np.testing.assert_allclose(candidates.scale, [0.2, *steps])
    weighted = [2.0 * s * ROWS[:, 0] ** k for k, s in enumerate(candidates.scale, start=1)]
    gram = candidates.design.gram.sum(axis=0)
    np.testing.assert_allclose(gram, [[one @ other for other in weighted] for one in weighted], rtol=1e-9)


def test_nuisance_parameters_have_priors_and_candidates_hardly_any(candidates):
    bound = settings().prior.bound
    low, high = candidates.priors.low, candidates.priors.high
    assert low[0] == max(-bound - 0.5, -1.0 / 0.2)
    assert high[0] == bound - 0.5
    assert np.all(low[1:] == -np.inf)
    assert np.all(high[1:] == np.inf)
    np.testing.assert_allclose(candidates.priors.precision, [1.0, *[0.01] * 4])


def test_what_spans_a_phase_is_one_candidate_and_a_size_that_only_adds_has_one_side(candidates):
    assert [group.columns.tolist() for group in candidates.groups] == [[1], [2], [3, 4]]
    assert [group.one_sided for group in candidates.groups] == [True, False, False]
    assert candidates.nuisance_places.tolist() == [0]
    assert candidates.first(candidates.groups[1]).effect is EFFECTS["coulomb_level"]
    assert [one.span for one in candidates.of(candidates.groups[2])] == [0, 1]
    assert all(one.parts == {} for one in candidates.columns)


def test_more_columns_are_candidates_behind_those_that_are_there(candidates):
    more = candidates.beside([column("viscous_level", "change", ROWS**6)])
    assert [group.columns.tolist() for group in more.groups] == [[1], [2], [3, 4], [5]]
    assert more.scale[5] == pytest.approx(step("viscous_level", "change"))
    assert len(more.priors.low) == len(more.priors.high) == len(more.priors.precision) == 6
    assert len(candidates.groups) == 3
