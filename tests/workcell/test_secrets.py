"""The truth of a workcell is shut away: nothing that an agent, a reader of logs or of messages sees holds it."""

import ast
import pickle
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest

import ffgym
from ffgym.agents.oracle import OracleAgent
from ffgym.core.errors import FFGymError
from ffgym.envs import EpisodeRecorder
from ffgym.paths import joint_reference, multisine
from ffgym.recordings import write_recording
from ffgym.robot import load_robot
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import PlantDistribution
from ffgym.workcell import INSTANCES, workcell

ROOT = Path(ffgym.__file__).parents[1]
MAY_IMPORT = ("ffgym/workcell", "ffgym/envs", "scripts", "tests")


def modules():
    for folder in ("ffgym", "agents", "scripts", "docs"):
        yield from (path for path in (ROOT / folder).rglob("*.py") if path.is_file())


def imported(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


@pytest.fixture(scope="module")
def recording():
    cell = workcell("thesis")
    motion = joint_reference(
        cell.robot,
        multisine(cell.robot.work_area.home, np.full((1, 6), 0.005), [2.0], np.zeros((1, 6)), 0.3, ramp=0.1, dwell=0.1),
    )
    return cell.run([Run(reference=motion)], n_threads=1)[0]


def numbers_of(cell):
    """Every number of the machine that its controller does not know, as text would show it."""
    robot, known = cell.machine.physical, cell.robot
    parts = [
        (robot.friction, known.friction),
        (robot.drive, known.drive),
        (robot.bodies, known.bodies),
        (robot.tool, known.tool),
    ]
    hidden = [
        np.setdiff1d(np.ravel(getattr(own, name)), np.ravel(getattr(other, name)))
        for own, other in parts
        for name in ("coulomb", "viscous", "joint_stiffness", "mass")
        if hasattr(own, name)
    ]
    effects = [np.unique(value) for effect in cell.machine.effects for value in effect.values().values()]
    values = np.concatenate(hidden + effects)
    return {repr(float(x)) for x in values if len(repr(float(x))) > 5}  # short ones are in any text


def test_nothing_but_environments_scripts_and_tests_imports_it():
    for path in modules():
        place = path.relative_to(ROOT).as_posix()
        if not place.startswith(MAY_IMPORT):
            assert not any(name.startswith("ffgym.workcell") for name in imported(path)), place


@pytest.mark.parametrize("name", INSTANCES)
def test_it_prints_nothing_but_its_name(name):
    cell = workcell(name)
    for text in (repr(cell), str(cell), repr(cell.machine), f"{cell.machine}"):
        assert name in text
        assert not any(number in text for number in numbers_of(cell))


def test_there_are_numbers_to_hide():
    assert len(numbers_of(workcell("thesis"))) > 30


def test_its_recordings_hold_what_sensors_measure_and_no_more(recording, tmp_path):
    for family in ("friction.effort", "link.position", "link.velocity"):
        assert not recording.has(family)
    for family in ("motor.position", "motor.effort", "tcp.position", "temperature", "reference.position"):
        assert recording.has(family)
    path = tmp_path / "log.csv"
    write_recording(recording, path)
    header = "".join(
        line for line in path.read_text(encoding="utf-8").splitlines(keepends=True) if line.startswith("#")
    )
    assert not any(number in header for number in numbers_of(workcell("thesis")))


def test_a_recording_without_sensors_lacks_the_truth_too():
    cell = workcell("thesis")
    motion = joint_reference(
        cell.robot,
        multisine(cell.robot.work_area.home, np.full((1, 6), 0.002), [2.0], np.zeros((1, 6)), 0.1, ramp=0.04),
    )
    exact = simulate([Run(reference=motion)], machine=cell.machine, n_threads=1)[0]
    assert not exact.has("friction.effort")
    assert not exact.has("link.position")


def test_an_environment_shows_an_agent_nothing_of_it():
    env = gym.make("ffgym/WorkcellCircles-v0", speeds=[0.04], radii=[0.001], positions=["p1"], horizon=20)
    known = gym.make("ffgym/CirclePath-v0", robot="irb4600_60_205_commissioned")
    assert list(env.unwrapped.observation_layout) == list(known.unwrapped.observation_layout)
    for name, entry in env.unwrapped.observation_layout.items():  # scales are of what the controller knows
        np.testing.assert_array_equal(entry.scale, known.unwrapped.observation_layout[name].scale)
    _, info = env.reset(seed=0)
    _, known_info = known.reset(seed=0)
    assert set(info) == set(known_info)
    shown = repr(env) + str(env.spec) + repr(info) + env.spec.to_json() + repr(pickle.dumps(env.spec))
    assert "thesis" in repr(env.unwrapped.core.plant.machines) + shown
    assert not any(number in shown for number in numbers_of(workcell("thesis")))


def test_an_environment_of_another_controller_has_its_servo():
    env = gym.make("ffgym/WorkcellCircles-v0", workcell="thesis_arm", speeds=[0.04], radii=[0.001], positions=["p1"])
    env.reset(seed=0)
    known = load_robot("irb4600_60_205_commissioned_arm")
    np.testing.assert_array_equal(env.unwrapped.core.robot.servo.position_gain, known.servo.position_gain)


def test_the_oracle_is_told_nothing_of_it():
    env = gym.make("ffgym/WorkcellCircles-v0", speeds=[0.1], radii=[0.001], positions=["p1"], horizon=5)
    observation, _ = env.reset(seed=0)
    with pytest.raises(FFGymError, match="shut away"):
        OracleAgent.for_env(env).predict(observation)


def test_a_recorder_of_an_environment_gets_no_truth():
    recorder = EpisodeRecorder()
    env = gym.make(
        "ffgym/WorkcellCircles-v0", speeds=[0.1], radii=[0.001], positions=["p1"], horizon=5, recorder=recorder
    )
    env.reset(seed=0)
    for _ in range(5):
        env.step(env.action_space.sample() * 0)
    (recording,) = recorder.recordings
    assert not any(recording.has(family) for family in ("friction.effort", "link.position", "link.velocity"))


@pytest.mark.parametrize(
    "arguments", [{"plant": "irb4600_60_205"}, {"robot": "irb4600_60_205"}, {"randomization": None}, {"workcell": "x"}]
)
def test_a_workcell_cannot_be_made_another(arguments):
    with pytest.raises(FFGymError, match="workcell"):
        gym.make("ffgym/WorkcellCircles-v0", **arguments)


def test_nothing_of_a_workcell_is_drawn_for_an_episode():
    env = gym.make("ffgym/WorkcellCircles-v0", speeds=[0.04], radii=[0.001], positions=["p1"])
    with pytest.raises(FFGymError, match="leave out the randomization"):
        env.reset(seed=0, options={"randomization": PlantDistribution()})
    with pytest.raises(FFGymError, match="leave out the randomization"):
        gym.make("ffgym/CirclePath-v0", plant="workcell:3", randomization=PlantDistribution()).reset(seed=0)


def test_another_workcell_can_be_chosen_for_an_episode():
    env = gym.make("ffgym/WorkcellCircles-v0", workcell=7, speeds=[0.04], radii=[0.001], positions=["p1"])
    env.reset(seed=0)
    first = env.unwrapped.core.plant.fingerprint()
    env.reset(seed=0, options={"plant": "workcell:cold"})
    assert env.unwrapped.core.plant.fingerprint() != first
