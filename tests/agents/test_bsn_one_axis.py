"""What thesis 5.3.1 finds on one axis: learning converges, two networks beat one, and at 3 Hz both help, but less."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.agents.bspline import ExtendedBSN, StaticBSN
from ffgym.agents.lffc import relative, thesis_training
from ffgym.agents.trials import SimulatedTrial, thesis_motions
from ffgym.control import NoCompensation
from ffgym.robot import RigidArm
from ffgym.studies import one_axis_study


@pytest.fixture(scope="module")
def learned(one_axis):
    """Static and extended network after all 15 updates of the thesis, none locked before."""
    arm = RigidArm(one_axis)
    procedure = replace(thesis_training(1), patience=100)
    return {
        kind: procedure.learn(kind.zero(1), thesis_motions(arm), SimulatedTrial(arm=arm))
        for kind in (StaticBSN, ExtendedBSN)
    }


@pytest.fixture(scope="module")
def reduction(one_axis, learned):
    """Share of the uncompensated RMS motor error that is gone, by law and frequency [Hz]."""
    study = one_axis_study(one_axis, laws=[NoCompensation(), *(learning.best for learning in learned.values())])
    return {(result.agent, result.frequency_hz): result.reduction for result in study.results}


@pytest.mark.parametrize("kind", [StaticBSN, ExtendedBSN])
def test_learning_converges_in_15_iterations_at_a_rate_of_0_8(kind, learned):
    """Converged: mean squares below 2 % of the first, and their last change (5.7) below 0.2 % of the first."""
    learning = learned[kind]
    assert learning.trials == 16
    for mean_square in (learning.error, learning.signal):
        course = relative(mean_square)[:, 0]
        assert course[-1] < 0.02
        assert np.abs(np.diff(course))[-1] < 0.002
        assert np.all(np.diff(course[:9]) < 0)


def test_the_extended_network_beats_the_static_one(reduction):
    assert 0.9 < reduction["bsn_static", 1.0] < reduction["bsn_extended", 1.0]


@pytest.mark.parametrize("name", ["bsn_static", "bsn_extended"])
def test_at_3_hz_it_still_helps_but_less_than_at_1_hz(name, reduction):
    assert 0.02 < reduction[name, 3.0] < reduction[name, 1.0]
