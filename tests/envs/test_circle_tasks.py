"""Circle tasks: which circles, where, how fast, in which order, and which sub-environment runs which."""

import gymnasium as gym
import numpy as np
import pytest

from ffgym.envs import tasks as tasks_module
from ffgym.envs.circle_path import CircleTasks
from ffgym.paths import RADII, SPEEDS
from ffgym.recordings.metrics.path_error import fit_circle
from tests.envs.env_samples import CIRCLE

FAST = {"speeds": [0.1], "radii": [0.001, 0.002]}
"""Short motions."""


def tasks_of(env):
    return [motion.task for motion in env.unwrapped.core.motions]


def radii_run(motion):
    """Radii [m] of the circles of a motion, in the order in which they run, from where its TCP goes."""
    t, q = motion.reference.t, motion.reference.q
    circles = [phase for phase in motion.reference.phases if phase.kind == "circle"]
    return [
        round(fit_circle(motion.arm.tcp_position(q[(t >= phase.start) & (t < phase.end)])).radius, 6)
        for phase in circles
    ]


@pytest.fixture(scope="module")
def drawn(irb4600):
    """Function that draws a motion from tasks."""

    def draw(options=None, seed=0, **arguments):
        return CircleTasks(irb4600, **(FAST | arguments)).draw(np.random.default_rng(seed), options or {})

    return draw


def test_the_tool_runs_circles_of_the_radii_at_the_position_and_speed(drawn, irb4600):
    motion = drawn({"position": "p3"})
    assert radii_run(motion) == [0.001, 0.002]
    tcp = motion.arm.tcp_position(motion.reference.q)
    np.testing.assert_allclose(tcp[0], irb4600.position("p3"), atol=1e-9)
    np.testing.assert_allclose(motion.plane[0], irb4600.position("p3"), atol=1e-6)
    np.testing.assert_allclose(np.abs(motion.plane[1]), [0, 0, 1], atol=1e-6)
    speed = np.linalg.norm(np.gradient(tcp, 0.004, axis=0), axis=1)
    rows = motion.rows(0)
    on_circle = rows[:, motion.columns.radius] > 0
    inside = on_circle[1:-1] & on_circle[2:] & on_circle[:-2]
    np.testing.assert_allclose(speed[1:-1][inside], 0.1, rtol=0.03)  # a chord is shorter than its arc
    assert motion.task == {"position": "p3", "speed": 0.1, "radii": [0.001, 0.002]}


def test_a_point_is_a_position_too_and_keeps_its_own_name(drawn, irb4600):
    point = irb4600.position("p2")
    tasks = CircleTasks(irb4600, positions=["p2", point], **FAST)
    rng = np.random.default_rng(0)
    by_point, by_name = tasks.draw(rng, {"position": point}), tasks.draw(rng, {"position": "p2"})
    np.testing.assert_array_equal(by_point.reference.q, by_name.reference.q)
    assert by_name.task["position"] == "p2"
    assert by_point.task["position"].startswith("(")
    assert "p2" in by_name.name


def test_all_of_the_thesis_is_the_default(irb4600):
    listed = CircleTasks(irb4600).list_options()
    assert len(listed) == len(SPEEDS) * 4
    assert {(task["position"], task["speed"]) for task in listed} == {(f"p{k}", v) for k in range(1, 5) for v in SPEEDS}
    assert all(task["radii"] == RADII for task in listed)
    assert len(CircleTasks(irb4600, order="one").list_options()) == len(SPEEDS) * 4 * len(RADII)


def test_listed_runs_as_given_shuffled_in_every_order_and_one_runs_each(drawn):
    radii = [0.002, 0.001]
    assert {tuple(drawn(seed=s, radii=radii).task["radii"]) for s in range(8)} == {(0.002, 0.001)}
    shuffled = [drawn(seed=s, radii=radii, order="shuffled") for s in range(8)]
    assert {tuple(motion.task["radii"]) for motion in shuffled} == {(0.002, 0.001), (0.001, 0.002)}
    for motion in shuffled[:3]:
        assert radii_run(motion) == motion.task["radii"]
    one = [drawn(seed=s, radii=radii, order="one") for s in range(8)]
    assert {tuple(motion.task["radii"]) for motion in one} == {(0.002,), (0.001,)}
    assert radii_run(one[0]) == one[0].task["radii"]


def test_positions_and_speeds_are_drawn_evenly_and_independently(irb4600):
    tasks = CircleTasks(irb4600, positions=["p1", "p4"], speeds=[0.05, 0.1], radii=[0.001])
    rng = np.random.default_rng(0)
    picks = [(task["position"], task["speed"]) for task in (tasks.draw(rng, {}).task for _ in range(400))]
    counts = [picks.count((p, v)) for p in ("p1", "p4") for v in (0.05, 0.1)]
    assert sum(counts) == 400
    assert min(counts) > 70  # 100 expected, standard deviation 8.7


def test_a_motion_that_was_made_before_is_not_made_again(irb4600):
    tasks = CircleTasks(irb4600, **FAST)
    rng = np.random.default_rng(0)
    first = tasks.draw(rng, {"position": "p1"})
    assert tasks.draw(rng, {"position": "p1"}) is first
    assert tasks.draw(rng, {"position": "p1", "radii": 0.001}) is not first
    assert tasks.draw(rng, {"position": "p1", "radii": (0.002, 0.001)}) is not first
    assert tasks.draw(rng, {"position": "p1", "speed": 0.05}) is not first


def test_only_the_motions_used_last_are_kept(irb4600, monkeypatch):
    monkeypatch.setattr(tasks_module, "KEPT", 2)
    tasks, rng = CircleTasks(irb4600, speeds=[0.1], radii=[0.001]), np.random.default_rng(0)
    first, second = (tasks.draw(rng, {"position": p}) for p in ("p1", "p2"))
    assert tasks.draw(rng, {"position": "p1"}) is first
    tasks.draw(rng, {"position": "p3"})
    assert tasks.draw(rng, {"position": "p1"}) is first
    assert tasks.draw(rng, {"position": "p2"}) is not second
    assert len(tasks._cache) == 2


def test_the_sequence_runs_every_motion_once_before_any_twice():
    env = gym.make_vec(
        CIRCLE, num_envs=2, positions=["p1", "p2", "p4"], sampling="sequence", horizon=1, autoreset_mode="SameStep",
        **FAST,
    )  # fmt: skip
    env.reset(seed=3)
    seen = [tasks_of(env)]
    for _ in range(5):
        env.step(np.zeros((2, 6)))
        seen.append(tasks_of(env))
    order = [task["position"] for pair in seen for task in pair]
    assert order == ["p1", "p2", "p4"] * 4


@pytest.mark.parametrize("vector", [False, True])
def test_a_seed_begins_the_sequence_anew_and_no_seed_goes_on(vector):
    settings = FAST | {"positions": ["p1", "p2", "p4"], "sampling": "sequence"}
    env = gym.make_vec(CIRCLE, num_envs=1, **settings) if vector else gym.make(CIRCLE, **settings)
    positions = []
    for seed in (None, None, 5, None, None, None, 5):
        env.reset(seed=seed)
        positions.append(tasks_of(env)[0]["position"])
    assert positions == ["p1", "p2", "p1", "p2", "p4", "p1", "p1"]


def test_a_reset_of_one_does_not_move_the_others_on_in_their_sequence():
    env = gym.make_vec(CIRCLE, num_envs=2, positions=["p1", "p2", "p4"], sampling="sequence", **FAST)
    env.reset(seed=0)
    env.reset(options={"reset_mask": np.array([True, False])})
    env.reset()
    assert [task["position"] for task in tasks_of(env)] == ["p2", "p1"]  # the fifth and the fourth


def test_a_sequence_of_single_circles_runs_each_radius():
    env = gym.make(CIRCLE, positions=["p1"], sampling="sequence", order="one", **FAST)
    radii = []
    for _ in range(4):
        env.reset()
        radii.append(tasks_of(env)[0]["radii"])
    assert radii == [[0.001], [0.002], [0.001], [0.002]]


def test_an_option_takes_its_turn_in_a_sequence_and_changes_that_episode_only():
    env = gym.make(CIRCLE, positions=["p1", "p2", "p4"], sampling="sequence", **FAST)
    positions = []
    for options in (None, {"position": "p3"}, None):
        env.reset(options=options)
        positions.append(tasks_of(env)[0]["position"])
    assert positions == ["p1", "p3", "p4"]


def test_circles_are_numbered_with_their_leads_and_phases_named():
    env = gym.make(CIRCLE, **FAST)
    _, info = env.reset(seed=0, options={"position": "p1"})
    rows, ended = [(info["phase"], info["circle"])], False
    while not ended:
        *_, ended, info = env.step(np.zeros(6))
        rows.append((info["phase"], info["circle"]))
    changes = [row for k, row in enumerate(rows) if k == 0 or row != rows[k - 1]]
    circle = ["lead_in", "circle", "lead_out"]
    assert changes == [
        ("standstill", -1), *[(phase, 0) for phase in circle],
        ("standstill", -1), *[(phase, 1) for phase in circle], ("standstill", -1),
    ]  # fmt: skip
