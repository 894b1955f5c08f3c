"""What is enough to be adopted: a quarter from one joint, less from a machine whose components all agree."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.fit.fit import ExplainedVariance
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.nuisance import NuisanceParameter
from ffgym.diagnosis.search import significance as module
from ffgym.diagnosis.search.significance import (
    compute_explained_by_newest,
    explains_most,
    is_significant,
    is_sizeable,
    is_within_prior,
)
from ffgym.diagnosis.settings import settings
from ffgym.effects import EFFECTS


@pytest.fixture(autouse=True)
def plausible(monkeypatch):
    """No shape is at the end of its range, all sizes are of note, and no cause is a number of the model."""
    monkeypatch.setattr(module, "find_shapes_at_limit", lambda setting, fit: ())
    monkeypatch.setattr(module, "is_within_prior", lambda setting, newest: False)
    monkeypatch.setattr(module, "is_sizeable", lambda cause: True)


@pytest.mark.parametrize(
    ("joint", "heard", "share", "enough"),
    [
        ("j1", 1, 1.1 * settings().significance.explains, True),
        ("j1", 4, 0.9 * settings().significance.explains, False),
        ("", 4, 0.9 * settings().significance.explains, True),
        ("", 4, 0.45 * settings().significance.explains, False),
        ("", 1, 0.9 * settings().significance.explains, False),
        ("", 0, 0.9 * settings().significance.explains, False),
    ],
)
def test_a_cause_of_the_whole_machine_has_as_many_witnesses_as_components(monkeypatch, joint, heard, share, enough):
    gone = ExplainedVariance(of_excess=share, of_all=share, excess=0.9, n_loud=heard, best=share)
    monkeypatch.setattr(module, "compute_explained_by_newest", lambda *fits: gone)
    assert is_significant(None, None, fitted(10.0, 10.0), fitted(5.0, 5.0, joint), chance=0.0) == enough


@pytest.mark.parametrize(("held_out", "holds"), [(5.0, True), (8.0, True), (9.5, False), (11.0, False)])
def test_a_cause_must_hold_on_rows_that_it_was_not_fitted_to(monkeypatch, held_out, holds):
    """It removes half of the energy in a fit to all rows."""
    monkeypatch.setattr(
        module,
        "compute_explained_by_newest",
        lambda *fits: ExplainedVariance(of_excess=0.9, of_all=0.5, excess=0.9, n_loud=1, best=0.9),
    )
    assert is_significant(None, None, fitted(10.0, 10.0), fitted(held_out, 5.0), chance=0.0) == holds
    assert not is_significant(None, None, fitted(10.0, 10.0), fitted(held_out, 5.0, is_unphysical=True), chance=0.0)


@pytest.mark.parametrize(
    ("held_out", "of_all", "numbers", "enough"),
    [
        (1.1 * settings().significance.clear, 1.1 * settings().significance.mostly, 3, True),
        (0.9 * settings().significance.clear, 1.1 * settings().significance.mostly, 3, False),
        (1.1 * settings().significance.clearer, 0.9 * settings().significance.mostly, 3, False),
        (1.1 * settings().significance.clearer, 1.1 * settings().significance.explains, 1, True),
        (0.9 * settings().significance.clearer, 1.1 * settings().significance.explains, 1, False),
        (1.1 * settings().significance.clearer, 0.9 * settings().significance.explains, 1, False),
    ],
)
def test_a_cause_below_the_noise_floor_must_explain_most_of_what_is_there_or_have_no_shape(
    monkeypatch, held_out, of_all, numbers, enough
):
    """The floor allows for what may be there: with quiet sensors, a tenth of it is."""
    gone = ExplainedVariance(of_excess=1.0, of_all=of_all, excess=0.0, n_loud=1, best=1.0)
    monkeypatch.setattr(module, "compute_explained_by_newest", lambda *fits: gone)
    monkeypatch.setattr(module, "find_touched", lambda setting, columns: {TORQUES[0]})
    before, after = fitted(100.0, 100.0), fitted(100.0 - held_out, 100.0 - held_out, numbers=numbers)
    setting = SimpleNamespace(certain=lambda component: 0.6)
    assert is_significant(setting, None, before, after, chance=1.0) == enough
    doubted = SimpleNamespace(certain=lambda component: 0.02)
    assert not is_significant(doubted, None, before, after, chance=1.0)  # as where an arm swings when its log begins


@pytest.mark.parametrize(
    ("effect", "values", "sizeable"),
    [
        ("servo_gains", {"position": -0.001, "velocity": 0.0, "integral": 0.0001}, False),
        ("servo_gains", {"position": -0.001, "velocity": 0.1, "integral": 0.0}, True),
        ("load_friction", {"share": 0.016}, True),
        ("stribeck_exponent", {"exponent": 2.02}, False),
        ("stribeck_exponent", {"exponent": 1.8}, True),
    ],
)
def test_a_thousandth_of_what_is_plausible_is_no_cause_below_the_floor(effect, values, sizeable):
    numbers = {name: np.array(value) for name, value in values.items()}
    assert is_sizeable(Hypothesis(kind=EFFECTS[effect], joint="j1", source=None, values=numbers)) == sizeable


def fitted(total, left, joint="j1", is_unphysical=False, numbers=1):
    """Energy that is left on rows that were not used, and by a fit to all rows."""
    newest = SimpleNamespace(joint=joint, list_free=lambda: [None] * numbers, is_unphysical=is_unphysical)
    return SimpleNamespace(rss=total, fit=SimpleNamespace(left=left, columns=({},)), hypothesis=newest)


@pytest.mark.parametrize(
    ("loud", "whose", "is_of_note", "enough"),
    [
        (1.1, "newest", True, False),
        (settings().significance.quiet + 0.1, "newest", True, True),
        (1.1, "another", True, True),
        (1.1, "another", False, False),
        (settings().significance.quiet + 0.1, "another", False, True),
    ],
)
def test_what_a_clean_log_may_have_is_no_cause_with_a_shape_at_the_end_of_its_range_or_without_a_size_of_note(
    monkeypatch, loud, whose, is_of_note, enough
):
    """Noise of the readings of a motor that restarts looked like breakaway that is overcome within no way at all.

    What half a per cent of each number leaves of a quiet tracker looked like a sixtieth of a base that gives way.
    """
    monkeypatch.setattr(module, "is_sizeable", lambda cause: is_of_note)
    after = fitted(5.0, 5.0)
    gone = ExplainedVariance(of_excess=0.9, of_all=0.9, excess=0.9, n_loud=1, best=0.9)
    monkeypatch.setattr(module, "compute_explained_by_newest", lambda *fits: gone)
    monkeypatch.setattr(module, "subtract_nuisances", lambda setting, fit: {})
    monkeypatch.setattr(module, "loudness", lambda setting, rest: {TORQUES[0]: loud, TORQUES[1]: 9.0})
    monkeypatch.setattr(module, "find_touched", lambda setting, columns: {TORQUES[0]})
    bent = after.hypothesis if whose == "newest" else SimpleNamespace()
    monkeypatch.setattr(module, "find_shapes_at_limit", lambda setting, fit: ((bent, "slip"),))
    assert is_significant(None, None, fitted(10.0, 10.0), after, chance=0.0) == enough


LIMIT = settings().significance
"""Limits that a cause must exceed: at them it is none."""


@pytest.mark.parametrize("more", [0.0, 1e-9])
@pytest.mark.parametrize("which", ["explains", "floor", "holds", "quiet", "is_physical"])
def test_a_cause_above_the_floor_must_exceed_each_limit(monkeypatch, which, more):
    def of(name, limit, otherwise):
        return limit + more if which == name else otherwise

    gone = ExplainedVariance(
        of_excess=of("explains", LIMIT.explains, 0.9), of_all=of("floor", LIMIT.floor, 0.9),
        excess=0.9, n_loud=1, best=0.9,
    )  # fmt: skip
    monkeypatch.setattr(module, "compute_explained_by_newest", lambda *fits: gone)
    monkeypatch.setattr(module, "is_sizeable", lambda cause: which != "quiet")
    monkeypatch.setattr(module, "subtract_nuisances", lambda setting, fit: {})
    monkeypatch.setattr(module, "loudness", lambda setting, rest: {TORQUES[0]: LIMIT.quiet + more})
    monkeypatch.setattr(module, "find_touched", lambda setting, columns: {TORQUES[0]})
    before = fitted(128.0, 64.0)
    after = fitted(128.0 - of("holds", 64.0 * LIMIT.holds, 64.0), 0.0)
    after.hypothesis.is_unphysical = which == "is_physical" and not more
    assert is_significant(None, None, before, after, chance=0.0) == (more > 0)


def test_what_a_fit_makes_worse_must_at_least_not_be_worse_on_rows_left_out(monkeypatch):
    gone = ExplainedVariance(of_excess=0.9, of_all=0.9, excess=0.9, n_loud=1, best=0.9)
    monkeypatch.setattr(module, "compute_explained_by_newest", lambda *fits: gone)
    for held_out, enough in ((-0.5, False), (0.0, False), (1e-9, True)):
        assert is_significant(None, None, fitted(10.0, 1.0), fitted(10.0 - held_out, 4.0), chance=0.0) == enough


@pytest.mark.parametrize("more", [0.0, 1e-9])
@pytest.mark.parametrize("which", ["clear", "mostly", "clearer", "explains", "certain", "sizeable"])
def test_a_cause_below_the_floor_must_exceed_each_limit(monkeypatch, which, more):
    """By its share of all it has three numbers, without a shape one."""
    by_share = which not in ("clearer", "explains")

    def of(name, limit, otherwise):
        return limit + more if which == name else otherwise

    held_out = of("clear", LIMIT.clear, of("clearer", LIMIT.clearer, 90.0))
    of_all = of("mostly", LIMIT.mostly, of("explains", LIMIT.explains, 0.9 if by_share else 0.9 * LIMIT.mostly))
    gone = ExplainedVariance(of_excess=0.9, of_all=of_all, excess=LIMIT.floor, n_loud=1, best=0.9)
    monkeypatch.setattr(module, "compute_explained_by_newest", lambda *fits: gone)
    monkeypatch.setattr(module, "is_sizeable", lambda cause: which != "sizeable" or more > 0)
    monkeypatch.setattr(module, "_imitates", lambda *given: False)
    monkeypatch.setattr(module, "find_touched", lambda setting, columns: set(TORQUES[:2]))
    certain = {TORQUES[0]: 0.9, TORQUES[1]: of("certain", LIMIT.certain, 0.9)}
    after = fitted(128.0 - held_out, 128.0 - held_out, numbers=3 if by_share else 1)
    setting = SimpleNamespace(certain=certain.__getitem__)
    assert is_significant(setting, None, fitted(128.0, 128.0), after, chance=1.0) == (more > 0)


def test_a_cause_just_above_the_floor_need_not_be_clear_below_it(monkeypatch):
    for excess, enough in ((LIMIT.floor, False), (LIMIT.floor + 1e-9, True)):
        gone = ExplainedVariance(of_excess=0.9, of_all=0.9, excess=excess, n_loud=1, best=0.9)
        monkeypatch.setattr(module, "compute_explained_by_newest", lambda *fits, gone=gone: gone)
        assert is_significant(None, None, fitted(10.0, 10.0), fitted(5.0, 5.0), chance=10.0) == enough


def test_the_newest_numbers_tell_where_a_cause_below_the_floor_acts(monkeypatch):
    gone = ExplainedVariance(of_excess=0.9, of_all=0.9, excess=0.0, n_loud=1, best=0.9)
    monkeypatch.setattr(module, "compute_explained_by_newest", lambda *fits: gone)
    after, asked = fitted(10.0, 10.0, numbers=2), []
    after.fit.columns = ({"old": 0}, {"new": 1}, {"new": 2})
    monkeypatch.setattr(module, "find_touched", lambda setting, columns: asked.append(columns) or {TORQUES[0]})
    setting = SimpleNamespace(certain=lambda key: 0.9)
    assert is_significant(setting, None, fitted(100.0, 100.0), after, chance=1.0)
    assert asked == [[{"new": 1}, {"new": 2}]]


def test_a_cause_that_acts_nowhere_is_none_below_the_floor(monkeypatch):
    gone = ExplainedVariance(of_excess=0.9, of_all=0.9, excess=0.0, n_loud=1, best=0.9)
    monkeypatch.setattr(module, "compute_explained_by_newest", lambda *fits: gone)
    monkeypatch.setattr(module, "find_touched", lambda setting, columns: set())
    assert not is_significant(None, None, fitted(100.0, 100.0), fitted(5.0, 5.0), chance=1.0)


def test_what_acts_on_nothing_that_is_read_may_be_imitated(monkeypatch):
    """Without a size of note, and no component where it is loud."""
    gone = ExplainedVariance(of_excess=0.9, of_all=0.9, excess=0.9, n_loud=1, best=0.9)
    monkeypatch.setattr(module, "compute_explained_by_newest", lambda *fits: gone)
    monkeypatch.setattr(module, "is_sizeable", lambda cause: False)
    for name in ("subtract_nuisances", "loudness"):
        monkeypatch.setattr(module, name, lambda *given: {})
    monkeypatch.setattr(module, "find_touched", lambda setting, columns: set())
    assert not is_significant(None, None, fitted(10.0, 10.0), fitted(5.0, 5.0), chance=0.0)


@pytest.mark.parametrize("more", [0.0, 1e-9])
@pytest.mark.parametrize("which", ["of_excess", "best"])
def test_causes_that_explain_as_much_as_the_limit_are_enough(monkeypatch, which, more):
    shares = {"of_excess": 0.0, "best": 0.0} | {which: LIMIT.together - more}
    gone = ExplainedVariance(of_all=0.9, excess=0.9, n_loud=3, **shares)
    for name in ("loudness", "subtract_nuisances", "find_touched"):
        monkeypatch.setattr(module, name, lambda *given: {})
    monkeypatch.setattr(module, "compute_explained", lambda *given: gone)
    fit = SimpleNamespace(columns=())
    assert explains_most(None, SimpleNamespace(fit=fit), SimpleNamespace(fit=fit)) == (not more)


@pytest.mark.parametrize(("share", "sizeable"), [(1.0, False), (1 + 1e-9, True), (-1.0, False), (-1 - 1e-9, True)])
def test_a_size_of_note_is_more_than_a_share_of_what_is_plausible(monkeypatch, share, sizeable):
    monkeypatch.setattr(module, "is_sizeable", is_sizeable)
    (p,) = EFFECTS["viscous_level"].parameters().values()
    change = np.array(p.neutral + share * LIMIT.sizeable * (p.high - p.low))
    one = Hypothesis(kind=EFFECTS["viscous_level"], joint="j1", source=None, values={p.name: change})
    assert module.is_sizeable(one) == sizeable


@pytest.mark.parametrize(("share", "best", "most"), [(0.6, 0.0, True), (0.3, 0.6, True), (0.3, 0.4, False)])
def test_causes_that_explain_no_component_well_are_none(monkeypatch, share, best, most):
    gone = ExplainedVariance(of_excess=share, of_all=share, excess=0.9, n_loud=3, best=best)
    for name in ("loudness", "subtract_nuisances", "find_touched"):
        monkeypatch.setattr(module, name, lambda *given: {})
    monkeypatch.setattr(module, "compute_explained", lambda *given: gone)
    fit = SimpleNamespace(columns=())
    assert explains_most(None, SimpleNamespace(fit=fit), SimpleNamespace(fit=fit)) == most


TORQUES = [("torque", k) for k in range(3)]
LINK = ("link", 0)


def removed_from(monkeypatch, first, loud, then, where, *, known=(), by_channel=(), inexact=0.0):
    """What is credited to a new cause on j1, of three torques and a link encoder; energies by component.

    It changes components `where` most, and those `by_channel` most of their channel; other numbers leave `inexact`.
    """
    setting = SimpleNamespace(inexact=lambda key: inexact)
    given = {False: where, True: {*where, *by_channel}}
    tables = iter([loud, then, first])
    monkeypatch.setattr(module, "subtract_nuisances", lambda setting, fit: {})
    monkeypatch.setattr(
        module, "loudness", lambda setting, rest: dict(zip([*TORQUES, LINK], next(tables), strict=True))
    )
    monkeypatch.setattr(module, "find_touched", lambda setting, columns, by_channel=False: given[by_channel])
    new = SimpleNamespace(key=("cogging", "j1", None), list_free=lambda: [None])
    before = SimpleNamespace(fit=SimpleNamespace(hypotheses=[SimpleNamespace(key=place) for place in known]))
    after = SimpleNamespace(fit=SimpleNamespace(columns=[{}]), hypothesis=new)
    return compute_explained_by_newest(setting, before, after, SimpleNamespace(fit=None))


@pytest.mark.parametrize(("loud", "exceeds"), [(1.0, False), (3.0, False), (3.0 + 1e-9, True)])
def test_what_is_above_the_noise_exceeds_what_is_allowed_above_it(loud, exceeds):
    energies, allowed = {TORQUES[0]: 1.0, TORQUES[1]: loud}, {TORQUES[0]: 0.5, TORQUES[1]: 2.0}
    assert module._exceeds_allowance(energies, set(TORQUES[:2]), allowed) == exceeds


def test_a_little_in_one_joint_is_what_ails_a_loud_one_until_it_is_much(monkeypatch):
    loud = (151.0, 1.5, 11.0, 1.0)
    little = removed_from(monkeypatch, loud, loud, (151.0, 1.0, 11.0, 1.0), {TORQUES[1]})
    assert little.of_excess == 0.0  # half a noise, beside a hundred and fifty
    much = removed_from(monkeypatch, loud, loud, (151.0, 1.5, 1.0, 1.0), {TORQUES[2]})
    assert much.of_excess == pytest.approx(1 - 150 * settings().significance.leaks / 10)


def test_nothing_leaks_from_a_joint_whose_cause_is_adopted(monkeypatch):
    gone = removed_from(monkeypatch, (151.0, 1.5, 1.0, 1.0), (1.5, 1.5, 1.0, 1.0), (1.5, 1.0, 1.0, 1.0), {TORQUES[1]})
    assert gone.of_excess == pytest.approx(1 - settings().significance.leaks)


@pytest.mark.parametrize(("inexact", "share"), [(0.0, 1.0), (2.0, 0.5), (6.0, 0.0)])
def test_what_numbers_that_moved_may_leave_is_no_cause(monkeypatch, inexact, share):
    loud = (5.0, 1.0, 1.0, 1.0)
    gone = removed_from(monkeypatch, loud, loud, (1.0, 1.0, 1.0, 1.0), {TORQUES[0]}, inexact=inexact)
    assert gone.of_excess == pytest.approx(min(share, 1 - settings().significance.leaks))


def test_what_is_loud_in_one_channel_does_not_leak_into_another(monkeypatch):
    loud = (1.0, 6.0, 1.0, 1e5)
    gone = removed_from(monkeypatch, loud, loud, (1.0, 1.0, 1.0, 1e5), {TORQUES[1]})
    assert gone.of_excess == pytest.approx(1 - settings().significance.leaks)


def test_a_cause_is_judged_by_torque_where_a_loud_encoder_has_no_more_than_an_inexact_cause_would_leave(monkeypatch):
    """A late encoder explained 99 % of its channel; a spring on the same joint shows in what is left, and in torque."""
    first, loud, then = (101.0, 1.0, 1.0, 1e6), (101.0, 1.0, 1.0, 5e4), (11.0, 1.0, 1.0, 1e4)
    late = [("link_clock", "", None)]
    gone = removed_from(monkeypatch, first, loud, then, {LINK}, known=late, by_channel=TORQUES[:1])
    assert gone.of_excess == pytest.approx(0.9 - settings().significance.leaks)
    alone = removed_from(monkeypatch, first, loud, then, {LINK}, known=late)
    assert alone.of_excess == 0.0


@pytest.mark.parametrize(
    ("known", "share"), [(("kinematic_error", "j1", None), (9 - 8) / 10), (("cogging", "j1", None), (9 - 0.2) / 10)]
)
def test_another_wave_of_a_cause_is_credited_with_what_inexact_causes_would_leave(monkeypatch, known, share):
    first, loud, then = (91.0, 1.0, 1.0, 1.0), (11.0, 1.0, 1.0, 1.0), (2.0, 1.0, 1.0, 1.0)
    gone = removed_from(monkeypatch, first, loud, then, {TORQUES[0]}, known=[known])
    assert gone.of_excess == pytest.approx(share)


@pytest.mark.parametrize(
    ("effect", "joint", "sigmas", "at", "known"),
    [
        ("joint_stiffness", "j1", 0.9 * settings().prior.bound, 0.0, True),
        ("joint_stiffness", "j1", -0.9 * settings().prior.bound, 0.0, True),
        ("joint_stiffness", "j1", settings().prior.bound, 0.0, True),
        ("joint_stiffness", "j1", 1.1 * settings().prior.bound, 0.0, False),
        ("joint_stiffness", "j1", 0.9 * settings().prior.bound, 0.5, False),
        ("joint_stiffness", "j2", 0.1 * settings().prior.bound, 0.0, False),
        ("rotor_inertia", "j1", 0.1 * settings().prior.bound, 0.0, False),
    ],
)
def test_a_number_within_its_calibration_is_no_cause(effect, joint, sigmas, at, known):
    """Of another joint, or another number, the calibration of this one says nothing."""
    column = SimpleNamespace(effect=EFFECTS["joint_stiffness"], joint="j1", parameter="change")
    setting = SimpleNamespace(
        nuisances=(NuisanceParameter(column=column, sigma=0.0625, at=at),),
        log=SimpleNamespace(robot=SimpleNamespace(n_joints=2)),
    )
    newest = Hypothesis(kind=EFFECTS[effect], joint=joint, source=None, values={"change": np.array(0.0625 * sigmas)})
    assert is_within_prior(setting, newest) == known
