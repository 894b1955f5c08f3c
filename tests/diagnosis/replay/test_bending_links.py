"""Links that bend, in a replay as in the simulation, alone and beside a base that gives way."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.replay import predict, replay
from ffgym.diagnosis.residual_rows import find_valid_rows
from ffgym.diagnosis.sensitivity import compute_sensitivities
from ffgym.effects import EFFECTS
from tests.diagnosis.replay.replay_samples import nominal, recorded, rows_left

LINK, BASE = EFFECTS["link_flexibility"], EFFECTS["base_flexibility"]


def bending(*joints, compliance=5e-7):
    return [LINK.on(nominal().robot, joint, compliance=compliance, relaxation=2e-3) for joint in joints]


MACHINES = {
    "first": bending("shoulder"),
    "second": bending("elbow", compliance=2e-6),
    "both": bending("shoulder", "elbow"),
    "base too": [*bending("shoulder"), BASE.on(nominal().robot, compliance=[0.0, 1e-5, 0.0], relaxation=2e-3)],
}


@pytest.mark.parametrize("which", MACHINES)
def test_a_replay_of_links_that_bend_predicts_what_was_simulated(which):
    """But for what replay and simulation of one machine differ by, whose links bend or not."""
    machine = replace(nominal(), effects=tuple(MACHINES[which]))
    stiff, bends = (
        assemble_log(nominal().robot, list(recorded({name: one}).values()))
        for name, one in {"stiff": nominal(), "bends": machine}.items()
    )
    inside = find_valid_rows(bends)
    steps, without, with_it = rows_left(stiff, nominal()), rows_left(bends, nominal()), rows_left(bends, machine)
    for channel in ("torque", "tool"):
        missed, seen = (np.sqrt(np.mean((rows[channel] - steps[channel])[inside] ** 2)) for rows in (with_it, without))
        assert missed < 0.2 * seen, (channel, missed, seen)
    # encoders of links stand before the bend
    assert np.abs((without["link"] - steps["link"])[inside]).max() < 0.3 * np.abs(without["tool"][inside]).max()


def test_columns_of_links_are_what_little_compliance_changes_joint_by_joint():
    log = assemble_log(nominal().robot, list(recorded({"nominal": nominal()}).values()))
    columns = compute_sensitivities(replay(log, nominal()), [LINK], {})
    assert [(column.joint, column.parameter) for column in columns] == [
        ("shoulder", "compliance"),
        ("elbow", "compliance"),
    ]
    small, before = 4e-8, predict(replay(log, nominal()))
    for column in columns:
        machine = replace(nominal(), effects=(LINK.on(nominal().robot, column.joint, compliance=small),))
        then = predict(replay(log, machine))
        for (channel, k), rows in column.parts.items():
            quotient = (then[channel][..., k] - before[channel][..., k]) / small
            assert np.abs(rows - quotient).max() <= 0.1 * np.abs(quotient).max() + 1e-3, (channel, k)
