"""Sizes of causes, and the intervals that they lie in."""

from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.diagnosis.extended import extend_machine
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.result import Cause, Size
from ffgym.diagnosis.settings import settings
from ffgym.diagnosis.sizes import is_there, list_causes
from ffgym.effects import EFFECTS
from ffgym.simulation.plant import Machine

BLOCKS = 80
NORMAL = 1.645
"""Of a 90 % interval, in standard deviations."""


def fit_of(robot, noise, size=0.2):
    """A fit of one torque offset to blocks whose residuals are `noise`."""
    known = EFFECTS["torque_offset"].parameters()
    values = {name: np.array(size if p.role == "size" else p.neutral) for name, p in known.items()}
    one = Hypothesis(kind=EFFECTS["torque_offset"], joint=robot.joints[0], source=None, values=values)
    return SimpleNamespace(
        hypotheses=(one,),
        run=SimpleNamespace(robot=robot),
        equations=SimpleNamespace(gram=np.ones((BLOCKS, 1, 1)), moment=noise.reshape(-1, 1, 1)),
        priors=SimpleNamespace(precision=np.zeros(1), low=np.array([-np.inf]), high=np.array([np.inf])),
        n_nuisances=0,
    )


def size_of(fit, rng):
    (cause,) = list_causes(fit, (0.9,), SimpleNamespace(share=0.0), rng)
    (size,) = cause.parameters
    return size


def test_an_interval_is_that_of_resampled_blocks_and_half_as_wide_again(one_axis):
    rng = np.random.default_rng(1)
    noise = rng.normal(0, 0.05, BLOCKS)
    fit, widths = fit_of(one_axis, noise - noise.mean()), []
    (offset,) = fit.hypotheses[0].list_free()
    for _ in range(20):
        size = size_of(fit, rng)
        assert size.interval[0] < size.value < size.interval[1]
        widths.append(size.interval[1] - size.interval[0])
    rows = settings().intervals.widened * NORMAL * np.std(noise) / np.sqrt(BLOCKS) * offset.step
    assert np.mean(widths) == pytest.approx(2 * np.hypot(rows, settings().intervals.inexact * 0.2), rel=0.05)
    assert settings().intervals.widened > 1.1


def test_a_size_that_rows_know_exactly_is_no_better_known_than_the_model_around_it(one_axis):
    size = size_of(fit_of(one_axis, np.zeros(BLOCKS), size=0.3), np.random.default_rng(0))
    assert size.interval == pytest.approx(
        (0.3 * (1 - settings().intervals.inexact), 0.3 * (1 + settings().intervals.inexact))
    )
    assert settings().intervals.inexact > 0.01


def test_a_fit_that_stopped_where_rows_still_pull_lies_inside_its_interval(one_axis):
    noise = np.random.default_rng(2).normal(0, 0.05, BLOCKS)
    still, pulled = (
        size_of(fit_of(one_axis, noise + pull), np.random.default_rng(0)).interval for pull in (-noise.mean(), 0.5)
    )
    assert pulled == pytest.approx(still)


def test_a_size_that_stays_at_null_is_told_without_an_interval_and_the_extended_machine_has_it(one_axis):
    values = {"viscous": 0.02, "scale": 25.0, "coulomb": -0.005, "breakaway": 0.001, "reference": 20.0}
    full = {name: np.array(value) for name, value in values.items()}
    kind, joint = EFFECTS["temperature_friction"], one_axis.joints[0]
    slim = Hypothesis(kind=kind, joint=joint, source=None, values=full).fix_at_null("viscous").fix_at_null("breakaway")
    n = len(slim.list_free())
    fit = SimpleNamespace(
        hypotheses=(slim,),
        run=SimpleNamespace(robot=one_axis),
        equations=SimpleNamespace(gram=np.tile(np.eye(n), (BLOCKS, 1, 1)), moment=np.zeros((BLOCKS, n, 1))),
        priors=SimpleNamespace(precision=np.zeros(n), low=np.full(n, -np.inf), high=np.full(n, np.inf)),
        n_nuisances=0,
    )
    (cause,) = list_causes(fit, (0.9,), SimpleNamespace(share=0.0), np.random.default_rng(0))
    assert [size.name for size in cause.parameters] == ["coulomb"]
    assert {"viscous": 0.0, "breakaway": 0.0}.items() <= cause.fixed.items()
    (effect,) = extend_machine(Machine(robot=one_axis), (cause,)).effects
    assert (effect.coulomb[0], effect.viscous[0], effect.breakaway[0]) == (-0.005, 0.0, 0.0)


def cause(effect, **intervals):
    sizes = tuple(
        Size(name=name.replace("_of_", "."), value=sum(ends) / 2, unit="", interval=ends)
        for name, ends in intervals.items()
    )
    return Cause(effect=effect, code="", title="", joint="j1", parameters=sizes, fixed={}, held_out_gain=1.0)


@pytest.mark.parametrize(
    ("found", "there"),
    [
        (cause("flexible_load", inertia=(0.0, 1e-3)), False),
        (cause("flexible_load", inertia=(1e-4, 1e-3)), True),
        (cause("joint_stiffness", change=(-0.1, 0.02)), False),
        (cause("joint_stiffness", change=(-0.1, -0.02)), True),
        (cause("tool_frame", offset_of_x=(-1e-5, 1e-5), offset_of_y=(1e-5, 2e-5)), True),
        (cause("cogging", amplitude=(0.0, 0.01), cycles=(11.9, 12.1)), False),
    ],
)
def test_a_cause_is_there_if_any_of_its_sizes_is_surely_not_nothing(found, there):
    assert is_there(found) == there
