"""Learning from another motion in every trial: products of maps, and what simulation makes of them."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.agents.bspline import ExtendedBSN, StaticBSN
from ffgym.agents.changing_motions import ChangingMotions
from ffgym.agents.stability import STABLE_GROWTH, LearningStability
from ffgym.agents.trials import Lesson, SimulatedTrial
from ffgym.core.errors import FFGymError
from ffgym.paths import joint_reference, joint_sine
from ffgym.robot import RigidArm
from ffgym.simulation import Run


@pytest.fixture(scope="module")
def axis(one_axis):
    return RigidArm(one_axis)


@pytest.fixture(scope="module")
def sines(one_axis):
    """Sines of other amplitudes and frequencies: each meets some splines that another does not."""
    pairs = ((1.0, 1.0), (0.5, 1.0), (1.0, 2.0), (0.3, 3.0))
    return [joint_reference(one_axis, joint_sine([a], f, 2.0, name=f"{a} rad, {f} Hz")) for a, f in pairs]


def of_steps(*steps):
    """Maps of one joint with these I - L."""
    return ChangingMotions(joints=("j1",), maps=(np.stack([np.eye(len(step)) - step for step in steps]),))


def test_motions_that_are_stable_alone_may_grow_in_turn():
    """Shears to either side: every eigenvalue is 0.9, their product grows; the bound tells, and one order is found."""
    to_one, to_other = np.array([[0.9, 1.0], [0.0, 0.9]]), np.array([[0.9, 0.0], [1.0, 0.9]])
    pair = of_steps(to_one, to_other)
    growth, [order] = pair.worst(1.0)
    expected = np.sqrt(np.abs(np.linalg.eigvals(to_one @ to_other)).max())
    assert order == (0, 1)
    assert growth[0] == pytest.approx(expected)
    assert growth[0] > 1.4
    assert pair.bound(1.0)[0] == pytest.approx(np.linalg.norm(to_one, 2))
    assert growth[0] == pytest.approx(pair.bound(1.0)[0])  # one step is the other's transpose: the bound is reached
    assert 1.1 < pair.drawn(1.0, np.random.default_rng(0))[0] < growth[0]


def test_symmetric_steps_have_a_norm_in_common_so_that_no_order_grows():
    rng = np.random.default_rng(2)
    halves = rng.normal(size=(3, 4, 4))
    steps = ChangingMotions(joints=("j1",), maps=(np.stack([half @ half.T for half in halves]),))
    limit = 2 / max(np.linalg.norm(half @ half.T, 2) for half in halves)
    assert steps.safe_rate[0] == pytest.approx(limit, rel=2e-3)
    assert steps.worst(0.9 * limit)[0][0] <= 1
    assert steps.worst(1.1 * limit)[0][0] > 1


def test_one_motion_alone_is_the_map_of_that_motion(axis, sines):
    network = ExtendedBSN.zero(1)
    study = LearningStability.of(network, axis, sines[:1])
    changing = ChangingMotions.of(network, axis, sines[:1])
    for rate in (0.8, 2.5):
        growth, [order] = changing.worst(rate)
        assert growth[0] == pytest.approx(study.growth(rate)[0], rel=1e-6)
        assert order == (0,)


def test_in_simulation_learnings_that_start_apart_part_as_predicted_though_each_motion_alone_is_stable(axis, sines):
    """The normalised update at a rate that every motion bears, in the order that is predicted to grow most."""
    network, rate = ExtendedBSN.zero(1), 1.15
    changing = ChangingMotions.of(network, axis, sines, record_dt=0.004)
    alone = [LearningStability.of(network, axis, [sine], record_dt=0.004) for sine in sines]
    assert min(study.largest_rate[0] for study in alone) > rate
    growth, [order] = changing.worst(rate)
    assert growth[0] > 1.01
    assert len(set(order)) > 1
    assert changing.drawn(rate, np.random.default_rng(0))[0] < growth[0] <= changing.bound(rate)[0]

    # pattern of weights that the order makes grow, and learnings without it and with a little of it
    steps = np.eye(changing.maps[0].shape[1]) - rate * changing.maps[0]
    whole = np.linalg.multi_dot([steps[motion] for motion in reversed(order)])
    values, vectors = np.linalg.eig(whole)
    pattern = np.zeros(network.coefficients.size)
    met = np.unique(np.concatenate([study.maps[0].splines for study in alone]))
    pattern[met] = vectors[:, np.abs(values).argmax()].real
    pattern *= 0.02 / np.abs(pattern).max()
    trial = SimulatedTrial(arm=axis, record_dt=0.004, n_threads=1)
    pair = [network, replace(network, coefficients=network.coefficients + pattern.reshape(network.coefficients.shape))]
    pair = learn_in_turn(pair, [sines[motion] for motion in order * 3], trial, rate)  # until friction is compensated
    shift = pattern.reshape(network.coefficients.shape)
    pair = [pair[0], replace(pair[0], coefficients=pair[0].coefficients + shift)]
    cycles = 4
    after = learn_in_turn(pair, [sines[motion] for motion in order * cycles], trial, rate)
    apart = np.linalg.norm(after[1].coefficients - after[0].coefficients) / np.linalg.norm(pattern)
    assert apart ** (1 / (cycles * len(order))) == pytest.approx(growth[0], abs=0.01)
    assert apart > 1


def learn_in_turn(networks, references, trial, rate):
    """Learn from one motion after the other."""
    for reference in references:
        recordings = trial([Run(reference=reference, law=network) for network in networks], 0)
        lessons = [Lesson.of(reference, recording) for recording in recordings]
        networks = [each.adapt([lesson], rate) for each, lesson in zip(networks, lessons, strict=True)]
    return networks


@pytest.mark.parametrize("kind", [StaticBSN, ExtendedBSN])
def test_the_plain_gradient_is_safe_in_any_order_up_to_a_rate_and_the_normalised_update_at_none(kind, axis, sines):
    plain = ChangingMotions.of(kind.zero(1, normalised=False), axis, sines, record_dt=0.004)
    normalised = ChangingMotions.of(kind.zero(1), axis, sines, record_dt=0.004)
    safe = plain.safe_rate[0]
    assert safe > 0.3 * min(
        LearningStability.of(kind.zero(1, normalised=False), axis, [sine], record_dt=0.004).largest_rate[0]
        for sine in sines
    )
    assert plain.worst(safe)[0][0] <= STABLE_GROWTH
    assert plain.drawn(safe, np.random.default_rng(0))[0] <= STABLE_GROWTH
    assert normalised.safe_rate[0] < 0.05
    assert normalised.bound(0.8)[0] > 1.5


def test_a_negative_rate_is_refused():
    with pytest.raises(FFGymError, match="learning rate"):
        of_steps(np.eye(2)).bound(-1.0)
