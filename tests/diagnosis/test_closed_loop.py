"""Closed loops of models beside that of a machine: that of the machine itself is at noise, the nominal one is not."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.control import DynamicLuGreExact
from ffgym.core.errors import FFGymError
from ffgym.diagnosis.held_out import compare_in_closed_loop
from ffgym.effects import EFFECTS
from ffgym.paths import joint_reference, multisine
from ffgym.recordings import Recording
from ffgym.simulation import Run, sensors_of, simulate
from ffgym.simulation.plant import Machine


@pytest.fixture(scope="module")
def machine(irb4600):
    effects = (EFFECTS["coulomb_level"].on(irb4600, "j1", change=0.3), EFFECTS["payload"].on(irb4600, mass=10.0))
    return Machine(robot=irb4600, effects=effects)


@pytest.fixture(scope="module")
def reference(irb4600, corners):
    path = multisine(corners["p1"], np.full((1, 6), 0.02), [2.0], np.zeros((1, 6)), 0.8, ramp=0.2, dwell=0.1)
    return joint_reference(irb4600, path)


@pytest.fixture(scope="module")
def recordings(machine, reference, irb4600):
    runs = [Run(reference=reference), Run(reference=reference, law=DynamicLuGreExact(irb4600.friction))]
    return simulate(runs, machine=machine, sensors=sensors_of(irb4600), n_threads=1)


def levels(nominal, extended, recordings):
    found = compare_in_closed_loop(nominal, extended, recordings, n_threads=1)
    return {(level.quantity, level.component): level for level in found}


def test_the_model_of_the_machine_leaves_noise_and_the_nominal_one_what_it_lacks(machine, recordings, irb4600):
    found = levels(Machine(robot=irb4600), machine, recordings)
    assert len(found) == 6 + 6 + 3
    for key in (("torque", "j1"), ("tracking error", "j1"), ("torque", "j2"), ("tool", "z")):
        assert found[key].after < 0.1 * found[key].before
    assert all(level.after < irb4600.sensors.tracker_noise for key, level in found.items() if key[0] == "tool")


def test_a_base_that_gives_way_has_joints_that_the_nominal_model_lacks(reference, irb4600):
    nominal = Machine(robot=irb4600)
    soft = Machine(robot=irb4600, effects=(EFFECTS["base_flexibility"].on(irb4600, compliance=1e-7),))
    recordings = simulate([Run(reference=reference)], machine=soft, sensors=sensors_of(irb4600), n_threads=1)
    done = []
    levels = compare_in_closed_loop(nominal, soft, recordings, n_threads=1, progress=lambda *now: done.append(now))
    tool = [level for level in levels if level.quantity == "tool"]
    assert all(level.after < irb4600.sensors.tracker_noise for level in tool)
    assert max(level.before for level in tool) > 3 * irb4600.sensors.tracker_noise
    assert [now[0] for now in done] == sorted(now[0] for now in done)
    assert {total for _, total in done} == {done[-1][0]}, "the total of both simulations, from the beginning"


def test_what_a_law_added_is_added_again(machine, recordings, irb4600):
    compensated = levels(Machine(robot=irb4600), machine, recordings[1:])
    assert compensated["tracking error", "j1"].after < 0.1 * compensated["tracking error", "j1"].measured


def test_without_a_tracker_motors_are_compared(machine, recordings, irb4600):
    columns = {name: values for name, values in recordings[0].columns.items() if not name.startswith("tcp")}
    found = levels(Machine(robot=irb4600), machine, [Recording(columns, recordings[0].header)])
    assert {quantity for quantity, _ in found} == {"tracking error", "torque"}


def test_what_cannot_be_run_again_is_refused(machine, recordings, irb4600):
    nominal, recording = Machine(robot=irb4600), recordings[1]
    for missing, says in (("reference", "no reference.position"), ("compensation", "no compensation.effort")):
        columns = {name: values for name, values in recording.columns.items() if not name.startswith(missing)}
        with pytest.raises(FFGymError, match=says):
            compare_in_closed_loop(nominal, machine, [Recording(columns, recording.header)])
    silent = replace(recording.header, torque_semantics="unspecified")
    with pytest.raises(FFGymError, match="torque_semantics"):
        compare_in_closed_loop(nominal, machine, [Recording(recording.columns, silent)])
    with pytest.raises(FFGymError, match="nothing to compare"):
        compare_in_closed_loop(nominal, machine, [])
