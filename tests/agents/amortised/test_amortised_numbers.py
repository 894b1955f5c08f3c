import numpy as np
import pytest

from ffgym.agents.amortised.draws import draw_machine
from ffgym.agents.amortised.numbers import GROUPS, machine_with, numbers_of, split
from ffgym.core.errors import FFGymError
from ffgym.robot import load_robot
from ffgym.simulation.plant import Machine


@pytest.fixture(scope="module")
def nominal():
    return load_robot("irb4600_60_205_arm_drives")


def test_a_machine_made_from_the_numbers_of_a_drawn_one_has_these_numbers(nominal):
    for seed in range(3):
        numbers = numbers_of(draw_machine(nominal, np.random.default_rng(seed)), nominal)
        assert np.abs(numbers).max() > 0.3
        np.testing.assert_allclose(numbers_of(machine_with(nominal, numbers), nominal), numbers, atol=1e-12)


def test_the_nominal_robot_has_no_numbers_of_its_own(nominal):
    zero = np.zeros(len(GROUPS) * nominal.n_joints + 1)
    np.testing.assert_array_equal(numbers_of(Machine(robot=nominal), nominal), zero)
    made = machine_with(nominal, zero)
    assert made.effects == ()
    np.testing.assert_array_equal(made.robot.friction.coulomb, nominal.friction.coulomb)


def test_shares_and_sizes_beyond_what_is_physical_are_taken_to_their_limits(nominal):
    numbers = np.full(len(GROUPS) * nominal.n_joints + 1, 2.0)
    robot, effects = (machine := machine_with(nominal, numbers)).robot, machine.effects
    assert robot.arm_share.tolist() == [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]
    assert max(float(np.max(effects[0].coulomb)), float(np.max(effects[1].share))) == 0.3
    assert split(numbers_of(machine, nominal), 6)["payload"] == pytest.approx(2.0)


def test_a_vector_of_another_robot_is_refused(nominal):
    with pytest.raises(FFGymError, match=r"numbers of a machine has shape \(14,\), must be \(79\)"):
        machine_with(nominal, np.zeros(14))
