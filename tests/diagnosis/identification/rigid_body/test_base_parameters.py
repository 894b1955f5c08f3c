"""Base parameters: what torque can tell of an arm, and nothing else changes it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ffgym.diagnosis.identification.rigid_body import TERMS, base_parameters
from ffgym.diagnosis.identification.rigid_body.terms import rigid_motion
from ffgym.robot import load_robot
from tests.robot.arm_samples import gantry, random_arm, two_link

TWO_LINK = (  # links of 0.5 m that hang from hinges about y: the second link's mass joins the first
    "link1.h_x + 0.5 link2.mass",
    "link1.h_z",
    "link1.I_yy + 0.25 link2.mass + 1e+04 rotor_inertia.j1",
    "link2.h_x",
    "link2.h_z",
    "link2.I_yy",
    "rotor_inertia.j2",
)


def in_words(base):
    return tuple(base.text(i) for i in range(len(base.own)))


def random_columns(robot, seed):
    """Motor torque of every parameter at 1 in random states."""
    states = np.random.default_rng(seed).normal(size=(3, 200, robot.n_joints))
    motion = rigid_motion(robot, *states)
    return np.concatenate([part for term in TERMS for part in term.columns(robot, motion)], axis=1)


def rigid_terms():
    return tuple(term for term in TERMS if term.name in ("bodies", "rotor_inertia"))


def test_those_of_two_links_are_the_ones_of_the_textbook():
    assert in_words(base_parameters(two_link(), rigid_terms())) == TWO_LINK


def test_rotors_of_a_gantry_join_the_masses_but_for_the_one_that_lifts():
    assert in_words(base_parameters(gantry(), rigid_terms())) == (
        "link1.mass + 3.6e+05 rotor_inertia.j1 - 3.6e+05 rotor_inertia.j2",
        "link2.mass + 3.6e+05 rotor_inertia.j2",
        "link3.mass",
        "rotor_inertia.j3",
    )


@pytest.mark.parametrize("name", ["irb4600_60_205", "kuka_kr300_r2500", "one_axis"])
def test_there_are_as_many_as_independent_columns(name):
    robot = load_robot(name)
    columns = random_columns(robot, seed=5)
    matrix = columns.swapaxes(1, 2).reshape(-1, columns.shape[1])
    matrix = matrix[:, np.any(matrix, axis=0)]
    values = np.linalg.svd(matrix / np.linalg.norm(matrix, axis=0), compute_uv=False)
    assert len(base_parameters(robot, TERMS).own) == np.sum(values > 1e-9 * values[0])


@given(types=st.text("RP", min_size=1, max_size=4), seed=st.integers(0, 100))
@settings(max_examples=10)
def test_torque_depends_on_base_parameters_only(types, seed):
    robot, rng = random_arm(types, seed), np.random.default_rng(seed)
    base = base_parameters(robot, TERMS)
    silent = np.eye(len(base.labels)) - np.linalg.pinv(base.combination) @ base.combination
    change = silent @ rng.normal(size=len(base.labels))
    columns = random_columns(robot, seed)
    size = np.abs(columns).max() * np.abs(change).max()
    assert np.abs(np.einsum("tkn,k->tn", columns, change)).max() < 1e-7 * size


def test_they_do_not_depend_on_the_random_states():
    robot = load_robot("two_link")
    first, second = (base_parameters(robot, TERMS, seed=seed) for seed in (0, 1))
    np.testing.assert_array_equal(first.own, second.own)
    np.testing.assert_allclose(first.combination, second.combination, rtol=1e-6, atol=1e-6)
