"""Machine files where a plant or a rig is asked for."""

import gymnasium as gym
import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.effects import EFFECTS
from ffgym.envs.machines import make_rig
from ffgym.simulation.plant import Machine, save_machine, with_payload


@pytest.fixture
def worn(irb4600):
    robot = with_payload(irb4600, 2.0)
    return Machine(robot=robot, effects=(EFFECTS["load_friction"].on(robot, share=0.1),))


@pytest.fixture
def file(worn, tmp_path):
    return save_machine(worn, tmp_path / "worn.toml", title="worn", source="a test")


def begun(plant):
    """Environment on a plant, in an episode."""
    env = gym.make("ffgym/CirclePath-v0", plant=plant)
    env.reset(seed=0)
    return env


def test_an_environment_on_a_machine_file_is_that_on_the_machine(file, worn, irb4600):
    from_file, from_machine, nominal = (begun(plant) for plant in (str(file), worn, irb4600))
    prints = [env.unwrapped.core.plant.fingerprint() for env in (from_file, from_machine, nominal)]
    assert prints[0] == prints[1] != prints[2]
    action = np.full(6, 0.2, dtype=np.float32)
    for _ in range(5):
        np.testing.assert_array_equal(from_file.step(action)[0], from_machine.step(action)[0])
    for env in (from_file, from_machine, nominal):
        env.close()


def test_the_controller_of_a_machine_file_knows_the_robot_that_it_names(file, worn, irb4600):
    rig = make_rig(file)
    assert rig.name == "worn"
    assert rig.robot.tool.mass == irb4600.tool.mass
    assert rig.machine.robot.tool.mass == worn.robot.tool.mass


def test_a_broken_machine_file_says_what_is_wrong_with_it(tmp_path):
    path = tmp_path / "broken.toml"
    path.write_text('[machine]\ntitle = "x"\n', encoding="utf-8")
    with pytest.raises(FFGymError, match=r"broken\.toml.*title and robot"):
        gym.make("ffgym/CirclePath-v0", plant=str(path))
    with pytest.raises(FFGymError, match=r"broken\.toml.*title and robot"):
        make_rig(path)
    with pytest.raises(FFGymError, match="Robot description"):
        make_rig(tmp_path / "missing.toml")
