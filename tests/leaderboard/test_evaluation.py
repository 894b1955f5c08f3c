from dataclasses import replace

import numpy as np
import pytest

from ffgym.agents.catalogue import CATALOGUE
from ffgym.agents.declaration import AgentSetting
from ffgym.agents.entrants import ENTRANTS, REGISTRY
from ffgym.agents.law_agent import LawPolicy
from ffgym.agents.trials import RigTrial, add_sensors
from ffgym.core.errors import FFGymError
from ffgym.leaderboard.adaptation.protocol import lap
from ffgym.leaderboard.entrants import Entrant, ReadyAgent
from ffgym.leaderboard.evaluation.closed_loop import run_references, run_rollouts
from ffgym.leaderboard.evaluation.jobs import (
    Job,
    SeededAgent,
    compute_trails,
    jobs_for,
    lost_cells,
    run_agents,
    run_job,
    score_circles,
)
from ffgym.leaderboard.plants import find_plant
from ffgym.leaderboard.results import CircleResult
from ffgym.leaderboard.tasks import HELD_OUT, SPLITS, THESIS, Task, list_tasks, make_references, noise_seed
from ffgym.paths import RADII, SPEEDS
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation import Run

POSITIONS = ["p1", "p2", "p3", "p4"]
FAST = Task("p2", 0.1, (0.003,), "positions")


def elastic(robot):
    return CATALOGUE["elastic"].make(AgentSetting.of(robot))


def law_cells(plant, law, task, seed=0):
    noise = [np.random.default_rng(noise_seed(task, seed))]
    [recording] = plant.rig.run([Run(reference=make_references(plant.rig.arm, [task])[0], law=law)], seed=noise)
    return score_circles(task, recording)


@pytest.mark.parametrize("name", ["nominal", "draw:4"])
def test_a_law_scores_the_same_on_a_rig_and_as_a_policy_in_the_environment(name):
    plant = find_plant(name)
    [[flight]] = run_rollouts(plant, [LawPolicy(make=elastic, preview=4)], [FAST])
    flown, run = score_circles(FAST, flight.recording), law_cells(plant, elastic(plant.rig.robot), FAST)
    for one, other in zip(flown, run, strict=True):
        assert one.key == other.key
        assert one.rms_mm == pytest.approx(other.rms_mm, rel=1e-6)
        assert one.motor_rms_rad == pytest.approx(other.motor_rms_rad, rel=1e-6)


def test_a_law_scores_the_same_on_the_workcell_with_the_same_noise():
    plant = find_plant("workcell:thesis")
    [[_, flight]] = run_rollouts(
        plant, [LawPolicy(make=elastic, preview=4)], [Task("p3", 0.1, (0.001,), "positions"), FAST]
    )
    [flown], [run] = score_circles(FAST, flight.recording), law_cells(plant, elastic(plant.rig.robot), FAST)
    assert flown.rms_mm == pytest.approx(run.rms_mm, rel=1e-6)


def test_a_law_is_recorded_the_same_on_a_rig_and_as_a_policy_along_any_motion():
    plant = find_plant("draw:4")
    references = make_references(plant.rig.arm, [Task("p3", 0.1, (0.001,), "positions"), FAST])
    flights = run_references(plant.rig, LawPolicy(make=elastic, preview=4), references, record_dt=0.004)
    law = elastic(plant.rig.robot)
    runs = plant.rig.run([Run(reference=reference, law=law) for reference in references], record_dt=0.004)
    for flown, run in zip(flights, runs, strict=True):
        assert flown.columns.keys() == run.columns.keys()
        assert flown.header.phases == run.header.phases
        for name, values in run.columns.items():
            np.testing.assert_allclose(flown.columns[name], values, rtol=1e-6, atol=1e-6, err_msg=name)


def test_who_flies_beside_changes_nothing():
    plant = find_plant("nominal")
    other = Task("p1", 0.1, (0.001,), "train")
    [[alone]] = run_rollouts(plant, [LawPolicy(make=elastic, preview=4)], [FAST])
    flights = run_rollouts(plant, [LawPolicy(make=elastic, preview=4)] * 2, [other, FAST])
    for mine in flights:
        assert mine[1].actions.tobytes() == alone.actions.tobytes()
        assert score_circles(FAST, mine[1].recording) == score_circles(FAST, alone.recording)


def test_actions_that_push_the_robot_out_of_its_limits_lose_the_cell():
    class Push:
        preview, action_scale = 1, 200.0

        def agent(self, robot, layout):
            return self

        def predict(self, observation, state=None, episode_start=None, deterministic=True):
            return np.ones((len(observation), 6)), None

    [[flight]] = run_rollouts(find_plant("nominal"), [Push()], [FAST])
    assert flight.recording is None
    assert len(flight.actions) < 600
    assert [cell.rms_mm for cell in lost_cells(FAST)] == [None]


def test_splits_cover_the_thesis_and_share_no_circle():
    cells = [cell.key[1:] for task in list_tasks(SPLITS, POSITIONS) for cell in lost_cells(task)]
    assert len(set(cells)) == len(cells) == 48
    thesis = {cell.key[1:] for task in list_tasks(THESIS, POSITIONS) for cell in lost_cells(task)}
    assert thesis == {(p, r * 1e3, round(v * 1e3)) for p in POSITIONS for r in RADII for v in SPEEDS}
    held_out = {cell.key[1:] for task in list_tasks(HELD_OUT, POSITIONS) for cell in lost_cells(task)}
    trained = {cell.key[1:] for task in list_tasks(["train"], POSITIONS) for cell in lost_cells(task)}
    assert not held_out & trained


def test_noise_differs_from_task_to_task_and_seed_to_seed():
    tasks = list_tasks(SPLITS, POSITIONS)
    assert len({tuple(noise_seed(task, seed)) for task in tasks for seed in range(3)}) == 3 * len(tasks)


def test_drawn_plants_are_all_different_and_always_the_same():
    prints = [find_plant(f"draw:{k}").fingerprint for k in range(4)]
    assert len(set(prints)) == 4
    find_plant.cache_clear()
    assert find_plant("draw:2").fingerprint == prints[2]


@pytest.mark.parametrize("name", ["draw", "draw:x", "draw:-1", "moon", "workcell:moon"])
def test_an_unknown_plant_is_refused(name):
    with pytest.raises(FFGymError, match="Unknown"):
        find_plant(name)


def test_jobs_keep_plants_apart_and_begin_with_the_long_ones():
    wanted = [(name, 0, plant) for plant in ("nominal", "workcell:thesis") for name in "abcdefghij"]
    jobs = jobs_for("registry", wanted, ["train"])
    assert [job.plant for job in jobs] == ["workcell:thesis"] * 2 + ["nominal"] * 3
    assert sorted(agent for job in jobs for agent in job.agents) == sorted((name, 0) for name in "abcdefghij" * 2)
    assert [len(job.agents) for job in jobs] == [5, 5, 4, 3, 3]


def test_a_job_gives_outcomes_of_everybody_who_is_ready():
    job = Job(REGISTRY, "nominal", (("none", 0), ("elastic", 0), ("oracle", 0)), ("speeds",), 2)
    outcomes = dict(run_job(job))
    assert list(outcomes) == ["none", "elastic", "oracle"]
    plain, best = (np.array([cell.rms_mm for cell in outcomes[name].cells]) for name in ("none", "elastic"))
    assert len(plain) == 6
    assert (best < 0.2 * plain).all()
    assert outcomes["oracle"].cells == outcomes["elastic"].cells  # the nominal plant is what is believed
    assert outcomes["none"].fingerprint == find_plant("nominal").fingerprint


def test_the_oracle_has_nothing_to_say_on_a_workcell():
    plant = find_plant("workcell:thesis")
    assert ENTRANTS["oracle"].ready(plant, [0], ()) == [None]


def test_pictures_show_one_held_out_circle_and_its_error():
    plant = find_plant("nominal")
    task = Task("p2", 0.1, (0.001, 0.003), "positions")
    [recording] = plant.rig.run([Run(reference=make_references(plant.rig.arm, [task])[0])])
    [trail] = compute_trails(task, recording)
    assert (trail.radius_mm, trail.speed_mm_s) == (3.0, 100.0)
    cell: CircleResult = score_circles(task, recording)[1]
    assert np.sqrt(np.mean(np.square(trail.deviation_um))) == pytest.approx(1e3 * cell.rms_mm, rel=0.05)
    assert compute_trails(FAST.__class__("p1", 0.1, (0.003,), "train"), recording) == []


def test_an_agent_is_a_law_or_a_policy():
    with pytest.raises(FFGymError, match="either a law or a policy"):
        ReadyAgent()


def test_everybody_has_what_a_row_needs():
    for name, entrant in ENTRANTS.items():
        assert isinstance(entrant, Entrant)
        assert entrant.name == name
        assert entrant.row().about.endswith(".")
        assert len(entrant.seeds) in (1, 5)


@pytest.mark.parametrize(
    ("name", "minimised", "noisy"),
    [
        ("ilc_motor", lambda cell: np.linalg.norm(cell.motor_rms_rad), False),
        ("ilc_tcp", lambda cell: cell.rms_mm, True),
    ],
    ids=["motors", "tool"],
)
def test_who_practises_each_motion_learns_through_sensors_and_is_scored_on_all_of_them(name, minimised, noisy):
    plant, tasks = find_plant("draw:0"), [FAST, Task("p3", 0.1, (0.001,), "positions")]
    ready = ENTRANTS[name].ready(plant, [0, 1], tuple(tasks))
    starters = [SeededAgent(name=name, seed=seed, ready=each) for seed, each in enumerate(ready)]
    zero = SeededAgent(name="none", seed=0, ready=ENTRANTS["none"].ready(plant, [0], ())[0])
    (_, first), (_, second), (_, nothing) = run_agents(plant, [*starters, zero], tasks)
    for one, other, before in zip(first.cells, second.cells, nothing.cells, strict=True):
        assert minimised(one) < 0.5 * minimised(before)
        assert (one.rms_mm != other.rms_mm) == noisy  # resolvers round, a tracker has noise
    moved = sum(reference.duration for reference in make_references(plant.rig.arm, tasks))
    assert first.robot_seconds == pytest.approx(10 * moved)
    assert first.inference_us is None
    [alone] = ENTRANTS[name].ready(plant, [1], tuple(tasks))
    [(_, again)] = run_agents(plant, [SeededAgent(name=name, seed=1, ready=alone)], tasks)
    assert again == second  # whoever learns beside it


def test_an_estimator_moves_each_machine_for_one_lap_and_leaves_less_than_its_base():
    plant, tasks = find_plant("workcell:drives-1"), [Task("p3", 0.1, (0.003,), "positions")]
    ready = ENTRANTS["amortised_motors"].ready(plant, [0, 1], tuple(tasks))
    [below] = ENTRANTS["elastic"].ready(plant, [0], ())
    seeded = [SeededAgent(name=f"seed {seed}", seed=seed, ready=each) for seed, each in enumerate(ready)]
    (_, first), (_, second), (_, base) = run_agents(
        plant, [*seeded, SeededAgent(name="base", seed=0, ready=below)], tasks
    )
    one_lap = lap(plant.rig.arm).duration
    for seed, outcome in enumerate((first, second)):
        assert outcome.cells[0].rms_mm < 0.7 * base.cells[0].rms_mm
        assert outcome.robot_seconds == pytest.approx(one_lap)
        assert outcome.artefact == ENTRANTS["amortised_motors"].artefact(plant.name, seed)
        assert outcome.env_steps > 1_000_000
    assert first.artefact != second.artefact
    assert first.cells != second.cells


def test_a_seed_chooses_the_network_of_an_estimator():
    rig = find_plant("workcell:drives-1").rig
    settings = [AgentSetting(arm=rig.arm, trial=RigTrial(rig=rig), seed=seed) for seed in (0, 1)]
    [reference] = make_references(rig.arm, [FAST])
    one, other = (CATALOGUE["amortised_motors"].make(setting).torque(reference) for setting in settings)
    assert np.abs(one - other).max() > 1e-3


def test_an_estimator_sees_a_robot_through_its_sensors_wherever_it_is_made():
    rig = find_plant("draw:4").rig
    rigs = [replace(rig, sensors=()), add_sensors(rig)]
    settings = [AgentSetting(arm=rig.arm, trial=RigTrial(rig=each)) for each in rigs]
    [reference] = make_references(rig.arm, [FAST])
    one, other = (CATALOGUE["amortised"].make(setting).torque(reference) for setting in settings)
    np.testing.assert_array_equal(one, other)


def test_an_estimator_that_sees_the_nominal_robot_leaves_its_base_alone():
    plant = find_plant("nominal")
    [ready] = ENTRANTS["amortised"].ready(plant, [0], ())
    [reference] = make_references(plant.rig.arm, [FAST])
    np.testing.assert_array_equal(ready.law.torque(reference), elastic(plant.rig.robot).torque(reference))


def test_arms_that_differ_in_friction_alone_share_their_joint_angles():
    arms = [RigidArm(load_robot(name)) for name in ("irb4600_60_205", "irb4600_60_205_commissioned")]
    one, other = (make_references(arm, [FAST])[0] for arm in arms)
    assert one.q is other.q
    assert [one.robot, other.robot] == [arm.robot for arm in arms]
    longer = replace(arms[0].robot, tool=replace(arms[0].robot.tool, tcp=arms[0].robot.tool.tcp + 0.01))
    assert not np.array_equal(make_references(RigidArm(longer), [FAST])[0].q, one.q)
