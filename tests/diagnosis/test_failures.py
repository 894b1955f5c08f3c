"""What cannot be computed of a model loses, and ends nothing."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis import clean_recordings as exact_module
from ffgym.diagnosis import diagnose, held_out
from ffgym.diagnosis.fit import fit as module
from ffgym.diagnosis.held_out import compare_in_closed_loop
from ffgym.effects import EFFECTS
from ffgym.effects.friction.viscous import ViscousLevel
from ffgym.simulation.plant import Machine
from tests.diagnosis import test_same_bytes
from tests.diagnosis.test_continuous_time import left


@pytest.fixture(scope="module")
def faulty(one_axis):
    """Two motions of an axis with more friction."""
    return test_same_bytes.logs(one_axis, EFFECTS["coulomb_level"].on(one_axis, change=0.25), seed=1)


@pytest.mark.parametrize("error", [FFGymError, np.linalg.LinAlgError, FloatingPointError, None])
def test_a_rival_that_cannot_be_replayed_loses(error, one_axis, faulty, monkeypatch):
    """By an error, or by numbers that are none."""
    real = module.replay

    def replay(log, machine, like=None, **more):
        run = real(log, machine, like, **more)
        if not any(isinstance(effect, ViscousLevel) for effect in machine.effects):
            return run
        if error is not None:
            raise error("no")
        return replace(run, torque=np.full_like(run.torque, np.nan))

    monkeypatch.setattr(module, "replay", replay)
    found = diagnose(one_axis, faulty)
    assert [cause.effect for cause in found.causes] == ["coulomb_level"]
    assert not any(rival.effect == "viscous_level" for rival in found.rivals)


def unstable(*args, **settings):
    """A simulation that nobody survives."""
    raise FFGymError("Simulation 0 became unstable.")


def test_a_nominal_machine_that_cannot_be_simulated_moves_as_measured(one_axis, faulty, monkeypatch):
    monkeypatch.setattr(exact_module, "simulate", unstable)
    exact, _ = left(one_axis, faulty)
    assert not exact.simulated
    found = diagnose(one_axis, faulty)
    assert [cause.effect for cause in found.causes] == ["coulomb_level"]


@pytest.mark.parametrize("which", ["before", "after"])
def test_a_closed_loop_that_cannot_be_simulated_is_infinitely_far(which, one_axis, faulty, monkeypatch):
    real, other = held_out.simulate, Machine(robot=one_axis, effects=(ViscousLevel(change=np.array([0.1])),))

    def simulate(runs, *, machine, **settings):
        return unstable() if machine[0] is other else real(runs, machine=machine, **settings)

    monkeypatch.setattr(held_out, "simulate", simulate)
    good = Machine(robot=one_axis)
    pair = (other, good) if which == "before" else (good, other)
    for level in compare_in_closed_loop(*pair, faulty, n_threads=1):
        values = {"before": level.before, "after": level.after}
        assert np.isinf(values.pop(which))
        assert np.isfinite([level.measured, *values.values()]).all()


def test_a_set_point_beyond_the_range_is_told_and_ends_nothing(one_axis, faulty):
    most = max(float(np.abs(recording["reference.position.j1"]).max()) for recording in faulty)
    range_ = (most - 1e-3) * np.array([[-1.0, 1.0]])
    narrow = replace(one_axis, kinematics=replace(one_axis.kinematics, range=range_))
    found = diagnose(narrow, faulty)
    assert [cause.effect for cause in found.causes] == ["coulomb_level"], found.sentence
    assert any("reference.position.j1 goes to" in text for text in found.quality)
