"""Submissions on drawn machines and motions: honest agents keep their score, stored torques are worth nothing."""

import base64
import io
from dataclasses import replace

import numpy as np
import pytest

from ffgym.agents.elastic import elastic_law
from ffgym.agents.iterative import IterativeLearning
from ffgym.agents.submission import rows_beside
from ffgym.agents.trials import RigTrial
from ffgym.control import ObservationLayout
from ffgym.core.errors import FFGymError
from ffgym.leaderboard.comparison.scores import Difference
from ffgym.leaderboard.comparison.statistics import Interval
from ffgym.leaderboard.evaluation.closed_loop import run_rollouts
from ffgym.leaderboard.evaluation.jobs import lost_cells, score_circles, score_motion
from ffgym.leaderboard.motions import CIRCLE, KINDS, TILTED
from ffgym.leaderboard.plants import find_plant
from ffgym.leaderboard.submission.drawn import BASE, SpotCheck, ZeroAction, list_public, verify_drawn
from ffgym.leaderboard.submission.judge import SCORE_TOLERANCE, STANDARD
from ffgym.leaderboard.submission.manifest import Refused, sha256_of
from ffgym.leaderboard.submission.python_agent import View
from ffgym.leaderboard.submission.rounds import Round
from ffgym.leaderboard.tasks import Task, make_references
from ffgym.recordings.metrics import contour_errors
from ffgym.robot import load_robot
from ffgym.simulation.sensors import sensors_of
from tests.leaderboard.submission_samples import ABOUT, PYTHON, ROBOT, agent_file, changed, judge, manifest_of

PUBLIC = {"draw:0": (Task("p2", 0.1, (0.001,), "positions"),)}
"""The public machine and circle of these tests."""
ROUND = Round(seed=361, machines=2, motions=4, series="draw:")
"""Round of one motion of each kind, all of them short."""
BESIDE = rows_beside((BASE,), load_robot(ROBOT))
MEMORISER = """
import base64
import io

import numpy as np

from ffgym.agents import LawAgent
from ffgym.agents.elastic import elastic_law
from ffgym.robot import RigidArm

PREVIEW, ACTION_SCALE = {preview}, 200.0
TABLE = np.load(io.BytesIO(base64.b64decode("{table}")))


class Memoriser:
    def __init__(self, robot, layout):
        law = elastic_law(RigidArm(robot))
        self.base = LawAgent(law=law, layout=layout, control_dt=robot.servo.control_dt)
        self.layout = layout

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        count, memory = (0, None) if state is None else state
        action, memory = self.base.predict(observation, memory, episode_start)
        k = min(count, len(TABLE["q"]) - 2)
        known = np.abs(self.layout.read(observation, "reference_position") - TABLE["q"][k]).max(axis=-1) < 1e-5
        stored = TABLE["torque"][k + 1] / self.layout["added_torque"].scale
        return np.where(known[:, None], stored, action), (count + 1, memory)


def make_agent(robot, layout):
    return Memoriser(robot, layout)
"""
"""Agent that knows torques for one motion, and does what elastic feed-forward does elsewhere."""


@pytest.fixture(scope="module")
def memoriser():
    """Submission that stores what iterative learning found on the public machine and circle in four trials."""
    [(name, tasks)] = PUBLIC.items()
    plant = find_plant(name)
    [reference] = make_references(plant.rig.arm, tasks)
    learning = IterativeLearning(arm=plant.rig.arm, target="tcp", base=elastic_law(plant.rig.arm))
    law = learning.learn([reference], RigTrial(rig=plant.rig, n_threads=1), trials=4).law
    table = io.BytesIO()
    np.savez(table, q=reference.q, torque=law.torque(reference).astype(np.float32))
    text = base64.b64encode(table.getvalue()).decode()
    content = MEMORISER.format(preview=elastic_law(plant.rig.arm).preview, table=text).encode()
    return judge(PUBLIC).pack(replace(ABOUT, robot_seconds=4 * reference.duration), PYTHON, content).data


@pytest.fixture(scope="module")
def verdict(memoriser):
    """Verdict on the memoriser, on what is drawn, beside an agent that makes things worse."""
    return verify_drawn(judge(PUBLIC), memoriser, ROUND, BESIDE, [other(memoriser, agent_file())])


def test_stored_torques_of_public_circles_score_as_their_base_on_what_is_drawn(verdict):
    assert verdict.public_ratio < 0.5
    assert verdict.against_base.ratio == pytest.approx(1.0, abs=SCORE_TOLERANCE)
    ends = verdict.against_base.interval.low, verdict.against_base.interval.high
    assert ends == pytest.approx((1.0, 1.0), abs=SCORE_TOLERANCE)
    assert verdict.is_memorised
    assert verdict.sentence.startswith(
        "accepted, rank 1 of 4: on 2 machines and 4 motions that were drawn it leaves 0."
    )
    assert "memorised: of the error of elastic it leaves 0." in verdict.sentence
    ranks = {row.name: row.rank for row in verdict.rows}
    elastic_left = next(row.by_kind for row in verdict.rows if row.name == "elastic")
    assert ranks["mine"] == ranks["elastic"] == 1 < ranks["none"]
    assert ranks["other"] > 1
    for row in verdict.rows:
        assert list(row.by_kind) == list(KINDS)
        left = {"mine": elastic_left, "elastic": elastic_left, "none": dict.fromkeys(KINDS, 1.0)}.get(row.name)
        assert left is None or row.by_kind == pytest.approx(left, rel=SCORE_TOLERANCE)
        of_all = np.exp(np.mean(np.log(list(row.by_kind.values()))))  # as many motions of each kind
        assert row.score.left == pytest.approx(of_all)
    assert max(elastic_left.values()) < 0.5
    assert (verdict.robot_seconds, verdict.manifest.robot_seconds > 2) == (0.0, True)


@pytest.mark.parametrize(
    ("public", "drawn", "low", "memorised"),
    [
        (0.1, 1.0, 0.9, True),
        (0.1, 0.4, 0.3, False),  # more than half of the gain, sqrt(0.1), is within the interval
        (0.1, 0.2, 0.1, False),
        (1.0, 1.0, 1.0, False),
        (0.95, 1.0, 0.99, False),  # not much better in public
        (1.2, 1.5, 1.4, False),  # worse than the base in public, too
    ],
)
def test_a_submission_is_memorised_if_less_than_half_of_its_public_gain_holds(verdict, public, drawn, low, memorised):
    against = Difference(ratio=drawn, interval=Interval(low, 2 * drawn))
    found = replace(verdict, public_ratio=public, against_base=against)
    assert found.is_memorised == memorised
    assert ("memorised" in found.sentence) == memorised


def test_every_kind_of_motion_is_scored_on_its_path():
    plant, tasks = find_plant("draw:0"), ROUND.draw_motions(load_robot(ROBOT).work_area)
    assert [task.kind for task in tasks] == list(KINDS)
    policies = [View(preview=1, action_scale=1.0, make=ZeroAction)] * 2
    first, same = run_rollouts(plant, policies, tasks, n_threads=1)
    references = make_references(plant.rig.arm, tasks)
    for task, reference, one, other in zip(tasks, references, first, same, strict=True):
        assert one.recording.t[-1] == pytest.approx(reference.duration)
        [cell] = score_motion(task, one.recording)
        assert [cell] == score_motion(task, other.recording)
        assert cell.key == lost_cells(task)[0].key
        # circles of any plane by the circle, other motions by the whole path
        if task.kind in (CIRCLE, TILTED):
            assert [cell] == score_circles(task, one.recording)
        else:
            whole = contour_errors(one.recording)[0]
            assert cell.rms_mm == cell.rms_3d_mm == pytest.approx(1e3 * whole.rms)
            assert cell.max_mm == cell.max_3d_mm == pytest.approx(1e3 * whole.max)
        assert 1e-3 < cell.rms_mm < cell.max_mm < 5  # of motions of some millimetres
        assert all(error > 0 for error in cell.motor_rms_rad)


def test_circles_along_any_path_are_those_of_the_circle_test():
    plant, [circle, square, *_] = find_plant("draw:0"), ROUND.draw_motions(load_robot(ROBOT).work_area)
    policy = View(preview=1, action_scale=1.0, make=ZeroAction)
    [[alone]] = run_rollouts(plant, [policy], [circle], n_threads=1)
    [[beside, _]] = run_rollouts(plant, [policy], [circle, square], n_threads=1)
    assert score_motion(circle, alone.recording) == score_motion(circle, beside.recording)


def test_machines_side_by_side_run_as_each_alone():
    tasks = [PUBLIC["draw:0"][0], ROUND.draw_motions(load_robot(ROBOT).work_area)[0]]
    machines = [find_plant(name) for name in ("draw:0", "draw:1")]
    policy = View(preview=1, action_scale=1.0, make=ZeroAction)
    [both] = run_rollouts(machines[0], [policy], tasks, machines=machines, n_threads=1)
    for machine, task, rollout in zip(machines, tasks, both, strict=True):
        [[alone]] = run_rollouts(machine, [policy], [task], n_threads=1)
        for name, values in alone.recording.columns.items():
            assert np.array_equal(values, rollout.recording.columns[name]), name


def test_noise_of_sensors_differs_from_machine_to_machine():
    task, plant = PUBLIC["draw:0"][0], find_plant("draw:0")
    machines = [replace(plant, name=name, sensors=sensors_of(load_robot(ROBOT))) for name in ("one", "two", "one")]
    policy = View(preview=1, action_scale=1.0, make=ZeroAction)
    [rollouts] = run_rollouts(plant, [policy], [task] * 3, machines=machines, n_threads=1)
    first, second, same = (rollout.recording.columns["tcp.position.x"] for rollout in rollouts)
    assert np.array_equal(first, same)
    assert not np.array_equal(first, second)


@pytest.mark.parametrize(
    ("series", "compared"),
    [("workcell:", ["workcell:thesis"]), ("workcell:drives-", ["workcell:thesis"]), ("draw:", list(STANDARD))],
)
def test_drawn_workcells_are_compared_with_the_public_one(series, compared):
    assert list_public(STANDARD, series) == compared
    assert list_public(["nominal"], series) == ["nominal"]


def test_an_agent_that_uses_what_other_robots_see_is_refused():
    robot = load_robot(ROBOT)
    layout = ObservationLayout(robot, 1, robot.friction.static)

    class Follower(ZeroAction):
        def predict(self, observation, state=None, episode_start=None, deterministic=True):
            return np.full((len(observation), 6), 0.1 + 1e-3 * (len(observation) > 1)), None

    for agent, message in ((ZeroAction(robot, layout), ""), (Follower(robot, layout), "what other robots see")):
        check = SpotCheck(agent, agent, 1)
        action, _ = check.predict(np.zeros((3, layout.size)), None, np.ones(3, dtype=bool))
        assert action.shape == (3, 6)
        if not message:
            check.compare()
            continue
        with pytest.raises(Refused, match=message):
            check.compare()


def test_machines_of_other_controllers_are_refused_in_one_line(memoriser, monkeypatch):
    monkeypatch.setattr("ffgym.leaderboard.submission.drawn.controller_of", str)
    with pytest.raises(FFGymError, match="have different controllers"):
        verify_drawn(judge(PUBLIC), memoriser, ROUND, BESIDE)


def test_another_submission_beside_it_is_refused_by_its_name(memoriser):
    small, cheap = replace(ROUND, machines=1, motions=1), other(memoriser, agent_file())
    with pytest.raises(Refused, match="other \\(1\\), beside it: refused, agent: It does not define"):
        verify_drawn(judge(PUBLIC), cheap, small, BESIDE, [other(memoriser, b"PREVIEW = 1")])
    with pytest.raises(Refused, match="submission 1 beside it: refused, archive"):
        verify_drawn(judge(PUBLIC), cheap, small, BESIDE, [b"no file"])


def other(data, content):
    """Submission with another agent, and the claims of this one."""
    files = manifest_of(data)["files"] | {"agent.py": sha256_of(content)}
    return changed(
        data, {"agent.py": content}, {"name": "other", "files": files} | {"preview": 1, "action_scale": 10.0}
    )
