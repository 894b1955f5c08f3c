"""A state of the engine is that of the instant at which it was read, whenever its fields are asked for."""

import numpy as np
import pytest

from ffgym.effects import EFFECTS, State
from ffgym.simulation.plant import Machine, Plant


@pytest.fixture
def plant(one_axis):
    """Two plants with an effect that acts at every step, at rest."""
    cogging = EFFECTS["cogging"].on(one_axis, "j1", amplitude=0.1, cycles=12.0, phase=0.0)
    plant = Plant(Machine(robot=one_axis, effects=(cogging,)), 2, n_threads=1)
    plant.rest(np.zeros((2, 1)))
    return plant


def read(plant):
    return plant._forces.state(plant._forces.choose(slice(None)))


def test_fields_that_are_asked_for_later_are_those_of_then(plant, one_axis):
    early, late = read(plant), read(plant)
    then = {name: np.array(getattr(early, name)) for name in State.names() if name not in ("rigid_load", "wound")}
    controls = np.zeros((2, 200, plant.model.nu))
    plant.split_controls(controls)[2][...] = 0.3 * one_axis.drive.peak_torque
    plant.drive(controls)
    assert np.abs(read(plant).motor_speed).min() > 0.01
    for name, value in then.items():
        np.testing.assert_array_equal(getattr(late, name), value, err_msg=name)


def test_a_state_has_no_other_fields(plant):
    with pytest.raises(AttributeError, match="A state has no speed"):
        _ = read(plant).speed
