"""Rows that a recording's mask leaves out change nothing that is identified, whatever is in them."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.identification import signals_of
from ffgym.diagnosis.identification.friction_data import friction_torque
from ffgym.diagnosis.identification.rigid_body.observation import Filtering, equations_of
from ffgym.diagnosis.identification.rigid_body.terms import TERMS
from ffgym.logs.preparation import LowPass
from ffgym.robot import RigidArm
from tests.logs.quality.quality_logs import clean_log, described

SHOULDER, ELBOW = 0, 1
FIRST, LAST = 4000, 4050


@pytest.fixture(scope="module")
def robot():
    return described("two_link", "multisine")


def spoilt(elbow: bool = True):
    """A torque of the elbow that is far off for 50 ms, and a mask that says so."""
    recording = clean_log("two_link", "multisine")
    mask = np.ones(len(recording))
    mask[FIRST:LAST] = 0.0
    torque = recording["motor.effort.elbow"].copy()
    torque[FIRST:LAST] += 5.0
    columns = {"motor.effort.elbow": torque}
    if elbow:
        columns |= {"valid.shoulder": np.ones(len(mask)), "valid.elbow": mask}
    return recording.with_columns(columns)


def test_equations_that_count_are_those_of_the_log_without_the_fault(robot):
    filtering = replace(Filtering(), parallel=LowPass(cutoff=20.0, order=4))
    clean = equations_of(robot, [clean_log("two_link", "multisine")], TERMS[:1], filtering)
    masked = equations_of(robot, [spoilt()], TERMS[:1], filtering)
    blind = equations_of(robot, [spoilt(elbow=False)], TERMS[:1], filtering)
    rows = masked.counts[:, ELBOW]
    assert 0 < clean.counts[:, ELBOW].sum() - rows.sum() < 0.1 * len(rows)
    assert np.array_equal(masked.counts[:, SHOULDER], clean.counts[:, SHOULDER])
    size = np.abs(clean.measured[:, ELBOW]).max()
    assert np.abs(masked.measured - clean.measured)[rows, ELBOW].max() < 0.02 * size
    assert np.abs(blind.measured - clean.measured)[blind.counts[:, ELBOW], ELBOW].max() > 0.5 * size


def test_friction_torque_counts_without_the_masked_rows_of_a_joint(robot):
    torque = friction_torque(RigidArm(robot), spoilt())
    ends = torque.signals.low_pass.end_rows(0.001)
    out = np.flatnonzero(torque.valid & ~torque.counts(ELBOW))
    assert (out[0], out[-1]) == (FIRST - ends, LAST - 1 + ends)
    assert np.array_equal(torque.counts(SHOULDER), torque.valid)


def test_an_uneven_log_says_what_brings_it_to_even_times(robot):
    recording = clean_log("two_link", "multisine")
    uneven = recording.with_columns({"timestamp": recording.t + 1e-4 * (np.arange(len(recording)) % 2)})
    with pytest.raises(FFGymError, match=r"sampled unevenly.*condition brings it to even times"):
        signals_of(robot, uneven)
