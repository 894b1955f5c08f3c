"""A diagnosis that looks for few causes says that more is left, and the next one, of the extended model, finds it."""

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis import ParameterPrior, examine, use_settings
from ffgym.effects import EFFECTS
from ffgym.envs.machines import make_rig
from ffgym.recordings.io import read_folder
from ffgym.simulation.plant import Machine, save_machine
from ffgym.simulation.protocols import load_protocols, plan_session, record_into

HIDDEN = {"cogging": {"amplitude": 0.05, "cycles": 6.0, "phase": 0.4}, "asymmetry": {"coulomb": 0.2, "viscous": 0.0}}


@pytest.fixture(scope="module")
def recordings(one_axis, tmp_path_factory):
    """Of an axis with two faults."""
    folder = tmp_path_factory.mktemp("two")
    (folder / "short.toml").write_text('[[step]]\nprotocol = "excitation"\ncount = 2\nbase = 0.2\nperiods = 1\n')
    effects = tuple(EFFECTS[name].on(one_axis, "j1", **values) for name, values in HIDDEN.items())
    rig = make_rig(
        save_machine(Machine(robot=one_axis, effects=effects), folder / "cell.toml", title="cell", source="a test")
    )
    motions = plan_session(rig.arm, list(load_protocols(str(folder / "short.toml"))))
    record_into(folder / "logs", motions, rig, record_dt=0.004, n_threads=1)
    return read_folder(folder / "logs")


@pytest.mark.slow
def test_what_one_diagnosis_leaves_the_next_finds(recordings, one_axis):
    machine, found = Machine(robot=one_axis), []
    for verdict in ("partly", "named"):
        examined = examine(machine, recordings, most=1)
        assert examined.diagnosis.verdict == verdict, examined.diagnosis.sentence
        found += [cause.effect for cause in examined.diagnosis.causes]
        machine = examined.machine
    assert sorted(found) == sorted(HIDDEN)
    (cogging,) = [effect for effect in machine.effects if effect.name == "cogging"]
    assert np.all(cogging.amplitude == pytest.approx(0.05, rel=0.1))


@pytest.mark.parametrize("most", [0, 9])
def test_there_is_a_least_and_a_most(most, one_axis):
    with pytest.raises(FFGymError, match="most causes"):
        examine(one_axis, [], most=most)


def test_changed_settings_reach_what_is_not_given(one_axis):
    """The most causes of a diagnosis, and the prior of a description."""
    with use_settings({"search.most_causes": 4, "prior.share": 0.02, "prior.offset": 3.0, "prior.tool_offset": 1e-3}):
        with pytest.raises(FFGymError, match="There is nothing to diagnose"):
            examine(one_axis, [])
        prior = ParameterPrior()
    assert (prior.share, prior.offset, prior.tool) == pytest.approx((0.02, 0.06, 1e-3))
