"""Policies that decide in one go decide as each does alone."""

import numpy as np
import pytest

from ffgym.agents.law_agent import LawPolicy
from ffgym.agents.residual.actor import ActorCrew
from ffgym.control import Batchable, NoCompensation, ObservationLayout
from ffgym.core.errors import FFGymError
from ffgym.leaderboard.evaluation.closed_loop import fly
from ffgym.leaderboard.evaluation.jobs import cells_of
from ffgym.leaderboard.plants import plant_named
from ffgym.leaderboard.tasks import Task
from tests.agents.residual.residual_samples import policy_of, random_actor

TASKS = [Task("p2", 0.1, (0.001,), "positions"), Task("p3", 0.1, (0.003,), "positions")]


@pytest.fixture
def layout(irb4600):
    return ObservationLayout(irb4600, 8, 30.0 * irb4600.friction.static)


@pytest.mark.parametrize("factored", [True, False])
def test_actors_share_rows_in_their_order(factored):
    rng = np.random.default_rng(3)
    actors = tuple(random_actor(rng, factored=factored) for _ in range(3))
    crew = ActorCrew(actors=actors)
    assert (crew.n_motors, crew.n_features) == (2, 18)
    features, begins = rng.normal(size=(12, 18)), rng.random(12) < 0.5
    state = rng.normal(size=crew.initial_state((12,)).shape)
    together, after = crew.act(features, state, begins)
    for k, actor in enumerate(actors):
        rows = slice(4 * k, 4 * k + 4)
        alone, own = actor.act(features[rows], state[rows], begins[rows])
        np.testing.assert_array_equal(together[rows], alone)
        np.testing.assert_array_equal(after[rows], own)


def test_rows_that_cannot_be_shared_out_and_actors_of_other_shapes_are_refused():
    rng = np.random.default_rng(3)
    crew = ActorCrew(actors=(random_actor(rng), random_actor(rng)))
    with pytest.raises(FFGymError, match="5 rows cannot be shared out equally among 2 actors"):
        crew.act(np.zeros((5, 18)), crew.initial_state((5,)))
    for actors in ((), (random_actor(rng), random_actor(rng, factored=True))):
        with pytest.raises(FFGymError, match="one or more actors of the same shape"):
            ActorCrew(actors=actors)


def test_policies_fly_together_as_each_does_alone():
    plant, seeds = plant_named("workcell:thesis"), [0, 4, 1]  # its sensors have noise
    policies = [policy_of(seed=seed) for seed in (5, 6, 7)]
    flights = fly(plant, policies, TASKS, seeds=seeds)
    for policy, seed, own in zip(policies, seeds, flights, strict=True):
        [alone] = fly(plant, [policy], TASKS, seeds=[seed])
        for task, one, other in zip(TASKS, own, alone, strict=True):
            assert one.actions.tobytes() == other.actions.tobytes()
            assert cells_of(task, one.recording) == cells_of(task, other.recording)
    assert flights[0][0].actions.tobytes() != flights[1][0].actions.tobytes()


def test_a_crew_is_made_once_for_all(irb4600, layout, monkeypatch):
    first = policy_of()
    assert isinstance(first, Batchable)
    monkeypatch.setattr("ffgym.agents.residual.policy.base_law", counted := Counted())
    agent = first.batched_with([policy_of(seed=6), policy_of(seed=7)], irb4600, layout)
    assert len(agent.actor.actors) == 3
    assert counted.calls == 1


class Counted:
    """In place of what makes base laws."""

    calls = 0

    def __call__(self, *_):
        self.calls += 1


@pytest.mark.parametrize(
    "other",
    [
        policy_of(base="none"),
        policy_of(bound=0.5),
        policy_of(memory=1),
        policy_of(action_scale=31.0),
        policy_of(preview=9),
        LawPolicy(make=lambda robot: NoCompensation(n_joints=robot.n_joints), preview=8),
    ],
)
def test_policies_that_differ_in_more_than_weights_decide_alone(other, irb4600, layout):
    assert policy_of().batched_with([policy_of(seed=6), other], irb4600, layout) is None
