"""An identified parameter file is accepted wherever a robot or its parameters are named."""

import gymnasium as gym
import numpy as np
import pytest

import ffgym  # noqa: F401 - registers the environments
from ffgym.agents.catalogue import CATALOGUE
from ffgym.agents.declaration import AgentSetting
from ffgym.cli.laws import setting_for
from ffgym.diagnosis.identification.bristle_fit import NAMES
from ffgym.diagnosis.identification.parameter_file import make_fitted_quantity, parameter_text
from ffgym.paths import joint_reference, joint_sine
from ffgym.robot import RigidArm, load_robot
from ffgym.simulation import Run, SimulatedRig
from ffgym.studies import sine_references

LEARNS = {name for name, entry in CATALOGUE.items() if entry.track == "causal" or "learn" in entry.title}
"""They know no parameters, or take long to make; the contract of all agents has them."""
MODELLED = [name for name in CATALOGUE if name not in LEARNS and CATALOGUE[name].package is None]
ENVIRONMENTS = sorted(name for name in gym.registry if name.startswith("ffgym/") and "Workcell" not in name)
"""Workcells are machines of their own, which no file replaces."""


@pytest.fixture(scope="module")
def identified(tmp_path_factory):
    """Function of a robot's name that writes a file with a tenth more of all its friction."""
    folder = tmp_path_factory.mktemp("identified")

    def write(name):
        robot, path = load_robot(name), folder / f"{name}.toml"
        more = robot.friction.scale(**dict.fromkeys(NAMES, 1.1))
        entries = {}
        for parameter in NAMES:
            value = getattr(more, parameter)
            interval = np.stack([0.9 * value, np.full_like(value, np.inf)], axis=1)
            entry = f"friction.{parameter}"
            entries[entry] = make_fitted_quantity(robot, entry, value, "a test", interval=interval)
        path.write_text(parameter_text(robot, entries, "identified"))
        return path

    return write


def test_the_file_is_the_robot_with_other_friction_and_keeps_its_intervals(identified):
    path = identified("irb4600_60_205")
    robot, nominal = load_robot(path), load_robot("irb4600_60_205")
    np.testing.assert_array_equal(robot.friction.coulomb, 1.1 * nominal.friction.coulomb)
    quantity = robot.quantities["friction.coulomb"]
    np.testing.assert_array_equal(quantity.prior, nominal.friction.coulomb)
    np.testing.assert_array_equal(quantity.interval[:, 0], 0.9 * robot.friction.coulomb)
    assert np.isinf(quantity.interval[:, 1]).all()


@pytest.mark.parametrize("name", MODELLED)
def test_every_agent_that_knows_parameters_takes_them_from_the_file(identified, one_axis, name):
    if CATALOGUE[name].needs_arm:
        pytest.skip("needs a robot with a tool; its parameters come through the same AgentSetting")
    reference = sine_references(one_axis)[1.0]
    rig = SimulatedRig(arm=RigidArm(one_axis))
    setting = setting_for(rig, [reference], identified("one_axis"), n_threads=1)
    assert isinstance(setting, AgentSetting)
    torque = CATALOGUE[name].make(setting).torque(reference)
    assert np.isfinite(torque).all()
    if name in ("lugre_static", "lugre_dynamic"):
        plain = CATALOGUE[name].make(setting_for(rig, [reference], None, n_threads=1)).torque(reference)
        assert np.abs(torque).max() == pytest.approx(1.1 * np.abs(plain).max(), rel=0.02)


@pytest.mark.parametrize("env", ENVIRONMENTS)
def test_every_environment_takes_the_file_as_its_plant(identified, env):
    robot = "one_axis" if "OneAxis" in env else "irb4600_60_205"
    made = gym.make(env, robot=robot, plant=str(identified(robot)))  # ids may have a robot of their own
    observation, _ = made.reset(seed=0)
    observation, *_ = made.step(np.zeros(made.action_space.shape, dtype=np.float32))
    assert np.isfinite(observation).all()
    made.close()


def test_a_motion_runs_on_the_robot_of_the_file(identified):
    robot = load_robot(identified("one_axis"))
    reference = joint_reference(robot, joint_sine([0.1], 1.0, 0.2, dt=robot.servo.control_dt))
    (recording,) = SimulatedRig(arm=RigidArm(robot)).run([Run(reference=reference)])
    assert recording.header.robot == "one_axis"
