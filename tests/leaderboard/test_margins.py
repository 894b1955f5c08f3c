from dataclasses import dataclass, replace

import numpy as np
import pytest

from ffgym.agents.entrants import ENTRANTS, REGISTRY
from ffgym.agents.torque_response import TorqueResponse
from ffgym.core.executors import Executor
from ffgym.leaderboard.board import Board
from ffgym.leaderboard.comparison.standings import standings
from ffgym.leaderboard.evaluation import jobs, margins
from ffgym.leaderboard.evaluation.closed_loop import environment_for
from ffgym.leaderboard.evaluation.margins import (
    CIRCLES,
    Change,
    LoopMargins,
    dies_out,
    find_stable,
    measure_margins,
    search_margins,
)
from ffgym.leaderboard.plants import NOMINAL, ROBOT, TestPlant, drives_plant, find_plant
from ffgym.leaderboard.presentation.table import table_of
from ffgym.leaderboard.presentation.words import margins_sentence
from ffgym.leaderboard.results import Margins, encode_row
from ffgym.leaderboard.tasks import make_references
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation import SimulatedRig
from tests.leaderboard.synthetic_rows import outcome, row

SLOW = (replace(CIRCLES[0], radii=(0.002,)),)
MARGINS = Margins(seed=0, fingerprint=drives_plant().fingerprint, artefact=None, gain=0.5, delay_ms=8.0)


def linear_robot():
    """The built-in robot with viscous friction, and a thousandth of the rest, by which torques are scaled."""
    robot = load_robot(ROBOT)
    friction = robot.friction.scale(coulomb=1e-3, bristle_stiffness=1e-3, bristle_damping=0.0)
    return replace(robot, friction=replace(friction, static=friction.coulomb))


@dataclass(frozen=True)
class Proportional:
    """Policy and agent of torques proportional to the position error."""

    gain: float
    """Gain in those of the servo."""
    preview: int = 1
    action_scale: float = 1e5
    channel: str = "torque"

    def agent(self, robot, layout):
        assert layout.preview >= self.preview
        gain = self.gain * robot.servo.position_gain / layout.action_size

        class Feedback:
            def predict(self, observation, state=None, episode_start=None, deterministic=False):
                return gain * layout.read(observation, "error"), None

        return Feedback()


@dataclass(frozen=True)
class Push:
    """Policy and agent that push all motors from a sample on, until the robot stops."""

    begin: int
    preview: int = 1
    action_scale: float = 1e5

    def agent(self, robot, layout):
        begin = self.begin

        class Pushing:
            def predict(self, observation, state=0, episode_start=None, deterministic=False):
                state = state or 0
                return np.full((len(observation), robot.n_joints), float(state >= begin)), state + 1

        return Pushing()


@pytest.fixture(scope="module")
def linear_plant():
    arm = RigidArm(linear_robot())
    return TestPlant(
        name="linear", rig=SimulatedRig(arm=arm), env_id="ffgym/CirclePath-v0", env_arguments={"robot": arm.robot}
    )


def is_stable(arm, q, gain, change):
    """Whether the eigenvalues of the robot and a sampled position gain, in those of the servo, are below 1."""
    response, n = TorqueResponse.of(arm, q, "motor"), arm.robot.n_joints
    states = len(response.transition)
    size = states + n * (1 + change.delay)
    # state, torque at this sample, and torques that are on their way, the oldest last
    read = np.zeros((n, size))
    read[:, :states], read[:, states : states + n] = response.output, response.direct
    own = -change.factor * gain * arm.robot.servo.position_gain[:, None] * read
    loop = np.zeros((size, size))
    loop[:states, :states], loop[:states, states : states + n] = response.transition, response.entry
    on_their_way = np.concatenate([own, np.eye(n * change.delay, size, states + n)])
    loop[states : states + n] = on_their_way[-n:]
    loop[states + n :] = on_their_way[:-n]
    return np.abs(np.linalg.eigvals(loop)).max() < 1


def test_margins_of_a_linear_loop_are_those_of_its_eigenvalues(linear_plant):
    arm, gain = linear_plant.rig.arm, 0.7
    [reference] = make_references(arm, SLOW)
    expected = search_margins(lambda changes: [is_stable(arm, reference.q[0], gain, each) for each in changes])
    assert 1 < expected.gain < 16
    assert 0 < expected.delay < 16
    assert measure_margins(linear_plant, Proportional(gain), circles=SLOW, pulse=100.0, n_threads=1) == expected


def radius_with_gains(arm, q, gains, bound, factor):
    """Largest eigenvalue of the robot with servo gains a, b, c, whose errors are in tenths of f_s / K."""
    response, n, dt = TorqueResponse.of(arm, q, "motor"), arm.robot.n_joints, arm.robot.servo.control_dt
    servo, breakaway, (a, b, c) = arm.robot.servo, arm.robot.friction.static, gains
    states = len(response.transition)
    # state, angles before, torque at this sample, last residual
    s, before, torque, last = np.split(np.arange(states + 3 * n), states + n * np.arange(3))
    size = states + 3 * n
    angle = np.zeros((n, size))
    angle[:, s], angle[:, torque] = response.output, response.direct
    change = (angle - np.eye(n, size, states)) / dt
    in_tenths = 10 / breakaway[:, None]
    residual = -in_tenths * (a * servo.position_gain[:, None] * angle + b * servo.velocity_gain[:, None] * change)
    residual[:, last] += c * np.eye(n)
    loop = np.zeros((size, size))
    loop[np.ix_(s, s)], loop[np.ix_(s, torque)] = response.transition, response.entry
    loop[before], loop[torque], loop[last] = angle, factor * bound * breakaway[:, None] * residual, residual
    return np.abs(np.linalg.eigvals(loop)).max()


@pytest.mark.parametrize("name", ["servo_gains", "servo_gains_drives"])
def test_servo_gains_bear_on_the_nominal_robot_what_their_eigenvalues_say(name):
    plant, factors = find_plant(NOMINAL), (2**-0.5, 1.0)  # margins of 0.84 between them
    policy, base = (ENTRANTS[each].ready(plant, [0], ())[0] for each in (name, "elastic"))
    gains, bound = policy.policy.actor.layers[0].weight[0, :3], policy.policy.bound
    [reference] = make_references(plant.rig.arm, SLOW)
    radii = [radius_with_gains(plant.rig.arm, reference.q[0], gains, bound, factor) for factor in factors]
    assert radii[0] < 1 < radii[1]
    changes = [Change(factor=factor) for factor in factors]
    found = find_stable(plant, policy.policy, base.timed, changes, circles=SLOW, n_threads=1)
    assert found.ravel().tolist() == [True, False]


def test_torque_of_the_base_is_not_changed(linear_plant):
    def found(policy, base):
        changes = [Change(factor=1.0), Change(factor=2.0)]
        stable = find_stable(linear_plant, policy, base, changes, circles=SLOW, pulse=100.0, n_threads=1)
        return stable.ravel().tolist()

    assert found(Proportional(3.0), None) == [True, False]
    assert found(Proportional(3.0), Proportional(3.0)) == [True, True]
    assert found(Proportional(6.0), Proportional(6.0, preview=2)) == [False, False]


@pytest.mark.parametrize("channel", ["torque", "setpoint"])
def test_a_pulse_is_one_sample_up_and_down_in_breakaway_torques(channel, linear_plant, monkeypatch):
    torques = []

    def watched(*args, **options):
        env = environment_for(*args, **options)
        step, scale = env.step, env.unwrapped.core.action_size
        monkeypatch.setattr(env, "step", lambda actions: torques.append(actions * scale) or step(actions))
        return env

    monkeypatch.setattr(margins, "environment_for", watched)
    policy = Proportional(0.0, channel=channel)
    find_stable(linear_plant, policy, None, [Change()], circles=SLOW, pulse=100.0, n_threads=1)
    [reference] = make_references(linear_plant.rig.arm, SLOW)
    [start] = [phase.start for phase in reference.phases if phase.kind == "circle"]
    assert np.flatnonzero(np.any(torques, axis=(1, 2))) == [round(start / 0.004)]
    robot = linear_plant.rig.robot
    push = 100.0 * robot.friction.static / (robot.servo.position_gain if channel == "setpoint" else 1.0)
    np.testing.assert_allclose(np.sum(torques, axis=0), [push, -push])


def test_circles_and_changes_side_by_side_are_told_apart(linear_plant):
    changes, circles = [Change(factor=1.0), Change(factor=3.0)], (*SLOW, replace(CIRCLES[2], radii=(0.003,)))
    stable = find_stable(linear_plant, Proportional(3.0), None, changes, circles=circles, pulse=100.0, n_threads=1)
    assert stable.tolist() == [[True, True], [False, False]]


def test_a_loop_that_is_stable_on_some_circles_is_not_stable(linear_plant, monkeypatch):
    monkeypatch.setattr(margins, "find_stable", lambda plant, policy, base, changes, **_: [np.array([True, False])] * 9)
    assert measure_margins(linear_plant, Proportional(1.0)) == LoopMargins(gain=0.0, delay=None)


@pytest.mark.parametrize("others", [[], [Change(factor=0.0)]])
def test_a_loop_that_stops_the_robot_is_unstable_though_its_answer_dies_out_before(linear_plant, others):
    changes, begin = [Change(), *others], 310  # a while behind the pulse
    stable = find_stable(linear_plant, Push(begin), None, changes, circles=SLOW, pulse=100.0, n_threads=1)
    assert stable.ravel().tolist() == [False, *(True for _ in others)]


def test_an_answer_must_be_smaller_in_the_second_half_than_at_first_on_every_motor():
    t = np.arange(100)[:, None]
    assert dies_out(np.hstack([0.99**t, 0.9**t]), 10)
    assert not dies_out(np.hstack([1.001**t, 0.9**t]), 10)
    assert not dies_out(np.ones((100, 1)), 10)
    # an answer of less than two windows
    assert dies_out(0.8 ** t[:15], 10)
    # a large answer that comes late, and dies out
    assert dies_out(np.exp(-(((t - 20) / 10) ** 2)) + 1e-3 * (t < 10), 10)


def test_a_search_ends_at_the_first_change_that_is_not_borne():
    def search(factor, delay):
        return search_margins(lambda changes: [each.factor <= factor and each.delay <= delay for each in changes])

    assert search(2.9, 5) == LoopMargins(gain=pytest.approx(2**1.5), delay=5)
    assert search(0.9, 5) == LoopMargins(gain=pytest.approx(2**-0.25), delay=None)
    assert search(0.01, 5) == LoopMargins(gain=0.0, delay=None)
    assert search(1.0, 0) == LoopMargins(gain=1.0, delay=0)
    assert search(99, 99) == LoopMargins(gain=16.0, delay=16)
    assert search(0.07, 5) == LoopMargins(gain=2**-4, delay=None)
    assert search(1.0, 7) == LoopMargins(gain=1.0, delay=7)
    # borne again behind the first that is not
    found = search_margins(lambda changes: [each.factor != 2 and each.delay not in (4, 6) for each in changes])
    assert found == LoopMargins(gain=pytest.approx(2**0.75), delay=3)


def test_feedback_is_what_a_policy_adds_to_its_base_on_the_machine_with_drives(monkeypatch):
    asked = []

    def measure(plant, policy, base, n_threads):
        asked.append((plant, policy, base))
        return LoopMargins(gain=2.0, delay=3)

    monkeypatch.setattr(jobs, "measure_margins", measure)
    found = jobs.run_margins_job(jobs.MarginsJob(REGISTRY, "servo_gains_drives", 0))
    [(plant, policy, base)] = asked
    assert plant.machine.robot.drive.torque_delay is not None
    assert policy.base == base.make(plant.rig.arm.robot).name == "elastic"
    assert (found.gain, found.delay_ms) == (2.0, pytest.approx(12.0))
    assert found.artefact == ENTRANTS["servo_gains_drives"].artefact("drives", 0)


def test_margins_are_kept_with_the_row_and_measured_once(tmp_path, monkeypatch):
    measured = []

    def run_margins_job(job):
        measured.append((job.name, job.seed))
        return replace(MARGINS, seed=job.seed, artefact=ENTRANTS[job.name].artefact("drives", job.seed))

    monkeypatch.setattr(jobs, "run_margins_job", run_margins_job)
    for name in ("servo_gains", "elastic", "ppo_elastic"):
        (tmp_path / f"{name}.json").write_text(encode_row(ENTRANTS[name].row()))
    entrants = [ENTRANTS[name] for name in ("servo_gains", "elastic", "ppo_elastic", "sac_elastic")]
    for _ in range(2):
        board = Board(registry=REGISTRY, folder=tmp_path)
        board.measure_margins(entrants, 2, Executor(jobs=1))
    # elastic has no feedback, and sac_elastic no row
    assert measured == [("servo_gains", 0), ("ppo_elastic", 0), ("ppo_elastic", 1)]
    board.keep([("servo_gains", outcome("none", 0, NOMINAL))])
    rows = {row.name: row for row in Board(registry=REGISTRY, folder=tmp_path).current()[0]}
    [found] = rows["servo_gains"].margins
    assert (found.gain, found.delay_ms) == (0.5, 8.0)
    assert [each.seed for each in rows["ppo_elastic"].margins] == [0, 1]
    assert '"margins"' not in (tmp_path / "elastic.json").read_text()


def test_margins_of_other_physics_or_artefacts_are_not_shown(tmp_path):
    artefact = ENTRANTS["servo_gains"].artefact("drives", 0)
    for old in (replace(MARGINS, fingerprint="old", artefact=artefact), replace(MARGINS, artefact="old")):
        row = replace(ENTRANTS["servo_gains"].row(), margins=(old,))
        (tmp_path / "servo_gains.json").write_text(encode_row(row))
        [shown], _ = Board(registry=REGISTRY, folder=tmp_path).current()
        assert shown.margins == ()


def test_tables_have_the_smallest_margins_of_the_seeds():
    def shown(*seeds):
        margins = tuple(replace(MARGINS, seed=i, gain=gain, delay_ms=delay) for i, (gain, delay) in enumerate(seeds))
        rows = [row("none", [NOMINAL]), replace(row("tqc_elastic", [NOMINAL]), margins=margins)]
        found = standings(rows, NOMINAL, "held_out")
        table = table_of(found)
        places = [[column.key for column in table.columns].index(key) for key in ("gain", "delay")]
        [line] = [line for line in table.lines if line.name == "tqc_elastic"]
        return [line.cells[place].text for place in places], margins_sentence(found)

    assert shown() == (["–", "–"], None)
    cells, told = shown((2.0, 12.0), (1.5, 8.0))
    assert cells == ["1.50", "8"]
    assert told.startswith("Of 1 agent with feedback, 1 is stable on a robot with drives")
    assert shown((1.0, 0.0))[1].startswith("Of 1 agent with feedback, 1 is stable")
    cells, told = shown((2.0, 12.0), (0.5, None))
    assert cells == ["0.50", "none"]
    assert told.startswith("Of 1 agent with feedback, 0 are stable")


def test_titles_with_commas_are_joined_by_semicolons():
    stable = (replace(MARGINS, gain=2.0),)
    titles = {"tqc_elastic": "TQC", "ppo_drives": "PPO, drives", "sac_drives": "SAC, drives"}
    learned = [
        replace(row("tqc_elastic", [NOMINAL]), name=name, title=title, margins=stable) for name, title in titles.items()
    ]
    told = margins_sentence(standings([row("none", [NOMINAL]), *learned], NOMINAL, "held_out"))
    names = told.partition("all seeds: ")[2].rstrip(".")
    assert sorted(names.replace("and ", "").split("; ")) == ["PPO, drives", "SAC, drives", "TQC"]
    assert names.count("; and ") == 1
