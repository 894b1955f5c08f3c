"""Coordinates and constraints: bodies that exist, at the least cost, and no frame is preferred."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.identification.rigid_body import coordinates as coordinates_module
from ffgym.diagnosis.identification.rigid_body.bodies import pseudo_inertia
from ffgym.diagnosis.identification.rigid_body.coordinates import (
    LEAST,
    THINNEST,
    coordinates_of,
)
from ffgym.diagnosis.identification.rigid_body.terms import terms_named
from ffgym.robot import load_robot
from ffgym.robot.parts import Links
from tests.robot.arm_samples import random_arm, two_link

TERMS = terms_named(("bodies", "rotor_inertia", "coulomb"))


def coordinates(robot):
    return coordinates_of(robot, TERMS, np.ones(sum(len(term.labels(robot)) for term in TERMS)))


def described(robot):
    return np.concatenate([term.described(robot) for term in TERMS])


@pytest.mark.parametrize("name", ["irb4600_60_205", "kuka_kr300_r2500", "ball_screw"])
def test_the_reference_is_the_description(name):
    robot = load_robot(name)
    own = coordinates(robot)
    np.testing.assert_allclose(own.parameters(own.reference), described(robot), rtol=1e-9, atol=1e-9)
    assert own.least_eigenvalue(own.reference) == pytest.approx(1)


def test_flat_bodies_get_a_thickness_that_leaves_mass_and_centre_alone():
    robot = two_link()
    plate = Links(mass=robot.bodies.mass, com=robot.bodies.com, inertia=np.tile([0.2, 0.1, 0.3, 0, 0, 0], (2, 1)))
    robot = replace(robot, bodies=plate)
    own = coordinates(robot)
    reference = own.parameters(own.reference)
    np.testing.assert_allclose(reference[:4], described(robot)[:4], rtol=1e-9)
    spread = np.linalg.eigvalsh(pseudo_inertia(reference[:10])[:3, :3] - np.outer(reference[1:4], reference[1:4]) / 12)
    assert spread[0] == pytest.approx(THINNEST * spread[2])


@given(seed=st.integers(0, 1000))
@settings(max_examples=20)
def test_distance_to_the_reference_does_not_depend_on_the_frame_of_a_body(seed):
    """A change of frame turns and moves J and its reference alike, J -> F J F^T."""
    rng = np.random.default_rng(seed)
    robot, frame = random_arm("R", seed), np.eye(4)
    frame[:3, :3], frame[:3, 3] = np.linalg.qr(rng.normal(size=(3, 3)))[0], rng.normal(size=3)
    own = coordinates(robot)
    reference = pseudo_inertia(own.parameters(own.reference)[:10])
    other = reference + 0.1 * np.trace(reference) * np.eye(4)

    def distance(j, j0):
        own = np.linalg.solve(j0, j - j0)
        return np.trace(own @ own)

    moved = distance(frame @ other @ frame.T, frame @ reference @ frame.T)
    assert moved == pytest.approx(distance(other, reference), rel=1e-6)
    entries = np.linalg.solve(own.to_parameters[:10, :10], _parameters(other))
    assert np.sum((entries - own.reference[:10]) ** 2) == pytest.approx(distance(other, reference), rel=1e-6)


def _parameters(pseudo):
    """The ten parameters of a pseudo-inertia."""
    sigma = pseudo[:3, :3]
    inertia = np.trace(sigma) * np.eye(3) - sigma
    rows, columns = [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]
    return np.concatenate([[pseudo[3, 3]], pseudo[:3, 3], inertia[rows, columns]])


def data(own, seed, size):
    """Random equations whose best coordinates are `size` away from the reference."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(3 * own.n, own.n))
    best = own.reference + size * rng.normal(size=own.n)
    return root.T @ root, root.T @ root @ best, best


def test_where_least_squares_gives_bodies_they_are_the_answer():
    own = coordinates(two_link())
    normal, _, best = data(own, seed=0, size=0.01)
    best = np.maximum(best, own.least)
    np.testing.assert_allclose(own.solve(normal, normal @ best), best, rtol=1e-9)


@pytest.mark.parametrize("size", [0.5, 3.0])
def test_where_not_the_answer_is_allowed_and_none_nearby_is_better(size):
    own = coordinates(two_link())
    normal, right, _ = data(own, seed=1, size=size)
    y = own.solve(normal, right)
    assert own.least_eigenvalue(y) >= LEAST - 1e-6
    assert np.all(y >= own.least - 1e-6)

    def cost(at):
        return at @ normal @ at - 2 * right @ at

    rng = np.random.default_rng(2)
    inside = own.reference  # between an allowed point and another all are allowed
    for _ in range(200):
        other = inside + rng.uniform() * (y - inside) + 1e-3 * rng.normal(size=own.n)
        if own.least_eigenvalue(other) >= LEAST and np.all(other >= own.least):
            assert cost(other) >= cost(y) - 1e-6 * abs(cost(y))
    slope = 2 * (normal @ y - right)
    assert slope @ (inside - y) >= -1e-6 * np.abs(slope) @ np.abs(inside - y)


def test_without_the_solver_there_is_one_error_that_says_what_to_install(monkeypatch):
    monkeypatch.setattr(coordinates_module, "is_installed", lambda _: False)
    own = coordinates(two_link())
    normal, right, _ = data(own, seed=1, size=3.0)
    with pytest.raises(FFGymError, match=r"ffgym\[identify\]"):
        own.solve(normal, right)
