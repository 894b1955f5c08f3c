"""Iterative learning in basis functions: what one circle taught is right on others."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.agents.elastic import elastic_law
from ffgym.agents.iterative_basis import N_BASIS, BasisLaw, learn_basis_weights
from ffgym.agents.trials import SimulatedTrial
from ffgym.core.errors import FFGymError
from ffgym.recordings.metrics import path_errors
from ffgym.robot import RigidArm
from ffgym.simulation import Run, simulate
from ffgym.simulation.plant import Machine
from ffgym.studies import circle_references


@pytest.fixture(scope="module")
def other_robot(arm):
    """Give the robot 1.3 times the friction and 1.2 times the stiffness that the nominal arm believes in."""
    robot, friction = arm.robot, arm.robot.friction
    return replace(
        robot,
        friction=friction.scale(coulomb=1.3, static=1.3, viscous=1.3),
        drive=replace(robot.drive, joint_stiffness=1.2 * robot.drive.joint_stiffness),
    )


@pytest.fixture(scope="module")
def learned(arm, other_robot):
    lap = list(circle_references(arm, ["p1"], [0.04], [0.003]).values())
    trial = SimulatedTrial(arm=RigidArm(other_robot))
    return learn_basis_weights(arm, elastic_law(arm), lap, trial, trials=3)


def test_weights_of_one_circle_halve_the_error_of_others(arm, other_robot, learned):
    others = circle_references(arm, ["p3"], [0.02, 0.1], [0.003]).values()
    runs = [Run(reference=other, law=law) for law in (elastic_law(arm), learned) for other in others]
    errors = [
        path_errors(each)[0].rms for each in simulate(runs, arm=arm, machine=Machine.of(other_robot), n_threads=1)
    ]
    before, after = np.array(errors).reshape(2, -1)
    assert (after < 0.5 * before).all(), (before, after)


def test_without_weights_the_torque_is_that_of_the_base(arm):
    reference = next(iter(circle_references(arm, ["p2"], [0.1], [0.001]).values()))
    base = elastic_law(arm)
    law = BasisLaw(arm=arm, base=base, weights=np.zeros((arm.robot.n_joints, N_BASIS)))
    np.testing.assert_array_equal(law.torque(reference), base.torque(reference))


def test_weights_of_another_robot_are_refused(arm):
    with pytest.raises(FFGymError, match=r"weights of basis functions .*\(6, 7\)"):
        BasisLaw(arm=arm, base=elastic_law(arm), weights=np.zeros((1, N_BASIS)))
