"""A log that begins while an arm still swings: what springs do by themselves after that counts as noise."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis import diagnose
from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.nuisance import ParameterPrior
from ffgym.diagnosis.prepare import prepare
from ffgym.diagnosis.residual_rows import find_valid_rows
from ffgym.diagnosis.weights import fit_first_swing
from ffgym.effects import EFFECTS
from ffgym.recordings import Recording
from tests.diagnosis.replay.replay_samples import nominal, recorded, small, with_effect

LOGGED = ("timestamp", "motor.position", "motor.effort", "tcp.position")
TORQUE, TOOL = 1e-3, 2e-6


@pytest.fixture(scope="module")
def whole():
    """Recordings of a multisine that begin at rest, of the nominal machine and of one with softer joints."""
    softer = with_effect(small(EFFECTS["joint_stiffness"], nominal().robot, share=0.2))
    return recorded({"nominal": nominal(), "softer": softer})


def begun_at(recording, first, name="m"):
    """The recording from sample `first` on, with noise."""
    rng = np.random.default_rng(first)
    columns = {key: values[first:] for key, values in recording.columns.items() if key.startswith(LOGGED)}
    columns["timestamp"] = columns["timestamp"] - columns["timestamp"][0]
    for key, values in columns.items():
        noise = {"motor.effort": TORQUE, "tcp.position": TOOL}.get(key.rpartition(".")[0], 0.0)
        columns[key] = values + noise * rng.standard_normal(len(values))
    return Recording(columns, replace(recording.header, segment=name, phases=()))


def swing_of(recordings):
    log = assemble_log(nominal().physical, recordings)
    setting = prepare(log, nominal(), ParameterPrior(), np.random.default_rng(0)).problem
    inside = find_valid_rows(log)[..., None]
    return {channel: np.abs(np.where(inside, rows, 0.0)) for channel, rows in fit_first_swing(setting).items()}


def test_an_arm_swings_where_its_log_begins_in_the_middle_of_a_motion_and_less_and_less(whole):
    swing = swing_of([begun_at(whole["nominal"], 150)])["torque"][:, 0, 0]
    assert swing.max() > 100 * TORQUE
    assert swing[-len(swing) // 4 :].max() < 0.7 * swing.max()


def test_an_arm_that_begins_at_rest_does_not_swing(whole):
    assert all(not rows.any() for rows in swing_of([begun_at(whole["nominal"], 0)]).values())


def test_each_motion_has_a_swing_of_its_own(whole):
    swing = swing_of([begun_at(whole["nominal"], 0, "rest"), begun_at(whole["nominal"], 150, "moving")])["torque"]
    assert [bool(rows.any()) for rows in np.moveaxis(swing, 1, 0)] == [False, True]


def test_what_another_spring_leaves_is_no_swing(whole):
    assert all(not rows.any() for rows in swing_of([begun_at(whole["softer"], 0)]).values())


def test_a_sound_machine_is_not_blamed_for_logs_that_begin_in_the_middle_of_a_motion(whole):
    """Before swings were known, these had errors of resolvers and gearboxes that were named without reserve."""
    answer = diagnose(nominal(), [begun_at(whole["nominal"], 150, f"m{i}") for i in range(6)])
    assert answer.verdict == "none"
