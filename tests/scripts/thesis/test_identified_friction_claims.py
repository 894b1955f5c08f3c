"""Claims about identified friction (thesis 6.1) hold for a joint as the thesis describes it, and fail for others."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis.identification import friction_torques, identify_friction
from ffgym.robot import RigidArm
from ffgym.simulation import SimulatedRig
from ffgym.simulation.protocols import plan_session, record
from ffgym.simulation.protocols.one_by_one import SpeedLadder, Table61
from scripts.thesis import ITEMS
from scripts.thesis.claims import judge
from scripts.thesis.measured_friction import LADDERS, MeasuredFriction

CLAIMS = {claim.name: claim for item in ITEMS for claim in item.claims}
ITEMS_BY_NAME = {item.name: item for item in ITEMS}


@pytest.fixture(scope="module")
def measured(one_axis):
    """Exact recordings of the one axis, whose friction is that of the thesis, and what was identified from them."""
    arm = RigidArm(one_axis)
    protocols = [SpeedLadder(speeds=speeds, longest=2.0) for speeds in LADDERS[2:]]
    plan = plan_session(arm, [*protocols, Table61(least=1.0, periods=2)])
    torques = friction_torques(arm, list(record(plan, SimulatedRig(arm=arm), record_dt=1e-3)))
    ladders, sines = torques[: len(protocols)], torques[len(protocols) :]
    found = identify_friction([*ladders, *(sines[i - 1] for i in (2, 4, 7))], seed=0, n_resamples=20)
    return MeasuredFriction(joint="j1", records=dict(enumerate(sines, start=1)), found=found)


@pytest.fixture
def with_old(studies, measured):
    """Function that puts the measured joint into the studies, with scaled parameters as the original ones."""

    def put(**factors):
        prior = replace(measured.found.prior, friction=measured.found.friction.scale(**factors))
        studies.joint_1 = replace(measured, found=replace(measured.found, prior=prior))
        return studies

    return put


BAD = {"coulomb": 1.5, "static": 1.5, "bristle_stiffness": 3.0}


@pytest.mark.parametrize(
    "name", ["6.1-match", "T6.1-better", "6.2-dynamic", "6.3-fit", "6.4-fit", "6.5-fit", "6.6-original"]
)
def test_a_claim_holds_for_a_joint_that_is_a_lugre_model(name, with_old):
    assert judge(CLAIMS[name], with_old(**BAD)).verdict == "holds"


def test_the_identified_model_is_no_better_where_the_original_one_was_right(with_old):
    for name in ("T6.1-better", "6.6-original"):
        assert judge(CLAIMS[name], with_old()).verdict == "does not hold"


def test_a_joint_that_is_a_lugre_model_is_captured_at_every_speed(with_old):
    judgement = judge(CLAIMS["6.7-neither"], with_old())
    assert judgement.verdict == "does not hold"
    assert len(judgement.checks) == 2


def test_a_model_that_is_wrong_is_no_good_fit(studies, measured, monkeypatch):
    studies.joint_1 = measured
    wrong = measured.found.friction.scale(coulomb=2.0, static=2.0)
    monkeypatch.setattr(type(measured.found), "friction", wrong)
    for name in ("6.3-fit", "6.4-fit", "6.5-fit"):
        assert judge(CLAIMS[name], studies).verdict == "does not hold"


def test_tables_show_every_parameter_and_every_record(with_old):
    studies = with_old(**BAD)
    [parameters] = ITEMS_BY_NAME["figure-6.1"].numbers(studies)
    [records] = ITEMS_BY_NAME["table-6.1"].numbers(studies)
    published = ["0.5367", "0.5634", "0.0437", "0.15", "69.9787", "0.6753"]  # (6.9) and (6.18)
    assert [row[1] for row in parameters.rows] == published
    assert [row[0] for row in records.rows] == [str(number) for number in range(1, 16)]
    assert records.rows[10][1] == "10"  # the misprint of record 11


def test_captions_name_speeds_and_errors(with_old):
    [figure] = ITEMS_BY_NAME["figure-6.7"].figures(with_old(**BAD))
    assert "10 sin(2π 5 t) (record 15)" in figure.caption
    assert figure.caption.count("RMS error of the") == 2
    over_time, over_speed = ITEMS_BY_NAME["figure-6.2"].figures(with_old())
    assert (over_time.name, over_speed.name) == ("figure-6.2a", "figure-6.2b")
    assert "model" not in over_time.caption


def test_errors_are_those_of_the_joint_in_each_record(measured):
    errors = measured.errors_of("identified")
    assert list(errors) == list(range(1, 16))
    assert all(np.isfinite(each.rms_error) and each.joint == "j1" for each in errors.values())
