"""Models beside recordings that were not diagnosed, along measured motion: set-points are not needed."""

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.held_out import compare_replays, is_better
from ffgym.effects import EFFECTS
from ffgym.paths import joint_reference, multisine
from ffgym.recordings import Recording
from ffgym.simulation import Resolver, Run, TorqueSensor, simulate
from ffgym.simulation.plant import Machine


@pytest.fixture(scope="module")
def machine(one_axis):
    return Machine(robot=one_axis, effects=(EFFECTS["viscous_level"].on(one_axis, "j1", change=0.3),))


@pytest.fixture(scope="module")
def moved(machine, one_axis):
    """A recording of the machine with motor angle and torque alone."""
    path = multisine([0.0], np.full((2, 1), 8.0), [0.4, 1.1], np.zeros((2, 1)), 4.0, name="sines")
    sensors = (Resolver(bits=16), TorqueSensor(noise=np.array([0.01])))
    runs = [Run(reference=joint_reference(one_axis, path))]
    (whole,) = simulate(runs, machine=machine, sensors=sensors, seed=4, record_dt=0.004, n_threads=1)
    columns = {name: values for name, values in whole.columns.items() if name.startswith(("timestamp", "motor."))}
    return Recording(columns, whole.header)


def test_the_machine_itself_leaves_less_than_the_nominal_model_and_not_the_other_way_round(machine, moved, one_axis):
    nominal = Machine(robot=one_axis)
    (level,) = found = compare_replays(nominal, machine, [moved])
    assert (level.quantity, level.component, level.unit) == ("torque", "j1", "N m")
    assert level.after < 0.3 * level.before < 0.3 * level.measured
    assert is_better(found)
    assert not is_better(compare_replays(machine, nominal, [moved]))
    assert not is_better(compare_replays(nominal, nominal, [moved]))


def test_a_narrower_band_holds_less_noise(machine, moved, one_axis):
    wide, narrow = (
        compare_replays(Machine(robot=one_axis), machine, [moved], cutoff=cutoff)[0] for cutoff in (40.0, 5.0)
    )
    assert narrow.after < 0.8 * wide.after
    assert narrow.before == pytest.approx(wide.before, rel=0.1)


def test_without_recordings_there_is_nothing_to_compare(machine, one_axis):
    with pytest.raises(FFGymError, match="nothing to compare"):
        compare_replays(Machine(robot=one_axis), machine, [])
