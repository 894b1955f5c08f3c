"""Machines whose effects act at rest stand still until something moves them."""

import numpy as np
import pytest

from ffgym.effects import EFFECTS, ResolverEffect, TorqueEffect
from ffgym.robot import ModelOptions
from ffgym.simulation.plant import Machine, Plant
from tests.effects.effect_samples import as_strong_as_plausible

ACTING = [name for name, effect in EFFECTS.items() if issubclass(effect, TorqueEffect | ResolverEffect)]


def stays(machine, q, steps=200):
    """How far motors and links move in so many physics steps under set-points that hold `q`, motor and link [rad]."""
    plant = Plant(machine, 1, n_threads=1)
    plant.rest(q[None])
    before = plant.state()
    controls = np.zeros((1, steps, plant.model.nu))
    position, _, _ = plant.split_controls(controls)
    position[:] = machine.robot.drive.motor_angle(q)
    plant.drive(controls)
    after = plant.state()
    return (
        np.abs(after.motor_position - before.motor_position).max(),
        np.abs(after.link_position - before.link_position).max(),
    )


@pytest.mark.parametrize("name", ACTING)
def test_a_machine_stands_still_with_the_effect_at_its_strongest(name, irb4600, corners):
    machine = Machine(robot=irb4600, effects=(as_strong_as_plausible(EFFECTS[name], irb4600),))
    assert max(stays(machine, corners["p1"])) < 1e-9


def test_a_machine_with_all_effects_stands_still(irb4600, corners):
    """At half of their strength, as all of them together are more than the wrist's motors can hold."""
    effects = tuple(as_strong_as_plausible(EFFECTS[name], irb4600, share=0.5) for name in ACTING)
    assert max(stays(Machine(robot=irb4600, effects=effects), corners["p3"])) < 1e-9


def test_an_arm_without_gravity_is_bent_by_its_effects_alone(irb4600, corners):
    effect = EFFECTS["kinematic_error"].on(irb4600, amplitude=1e-4, cycles=0.0, phase=np.pi / 2)
    weightless = Machine(robot=irb4600, effects=(effect,))
    plant = Plant(weightless, 1, options=ModelOptions(gravity=False, looks=False), n_threads=1)
    plant.rest(corners["p1"][None])
    state = plant.state()
    deflection = state.link_position - irb4600.drive.joint_angle(state.motor_position)
    np.testing.assert_allclose(deflection, 1e-4, rtol=1e-9)
