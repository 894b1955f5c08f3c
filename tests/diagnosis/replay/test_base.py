"""A base that gives way, in a replay as in the simulation, alone and beside what bends joints."""

from dataclasses import replace

import numpy as np
import pytest

from ffgym.diagnosis.excitation import sort_effects
from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.problem import compute_tangents
from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.nuisance import ParameterPrior
from ffgym.diagnosis.replay import predict, replay
from ffgym.diagnosis.residual_rows import find_valid_rows
from ffgym.diagnosis.sensitivity import compute_sensitivities
from ffgym.effects import EFFECTS
from tests.diagnosis.replay.replay_samples import nominal, recorded, rows_left

BASE = EFFECTS["base_flexibility"]
AXES = {"about the joints": [0.0, 3e-5, 0.0], "about all": [1e-5, 3e-5, 1e-5]}
"""A hundred times as soft as the floor of a large robot: this one has two light links."""


def on(effects):
    return replace(nominal(), effects=tuple(effects))


def flexible(axes, *others):
    return on([*others, BASE.on(nominal().robot, compliance=AXES[axes], relaxation=2e-3)])


@pytest.mark.parametrize("axes", AXES)
@pytest.mark.parametrize("beside", [None, "cable_pull"])
def test_a_replay_on_a_base_that_gives_way_predicts_what_was_simulated_on_one(axes, beside):
    """But for what replay and simulation of one machine differ by, whose base stands or not."""
    others = [] if beside is None else [EFFECTS[beside].on(nominal().robot, stiffness=20.0, hysteresis=2.0)]
    machines = {"stands": on(others), "gives way": flexible(axes, *others)}  # of no one batch
    stands, gives_way = (
        assemble_log(nominal().robot, list(recorded({name: machine}).values())) for name, machine in machines.items()
    )
    inside = find_valid_rows(gives_way)
    steps, without = rows_left(stands, on(others)), rows_left(gives_way, on(others))
    with_it = rows_left(gives_way, flexible(axes, *others))
    for channel in ("torque", "tool"):
        missed, seen = (np.sqrt(np.mean((rows[channel] - steps[channel])[inside] ** 2)) for rows in (with_it, without))
        assert missed < 0.1 * seen, (channel, missed, seen)


def test_columns_of_a_base_are_what_little_of_it_changes_in_all_channels():
    log = assemble_log(nominal().robot, list(recorded({"nominal": nominal()}).values()))
    run = replay(log, nominal())
    columns = compute_sensitivities(run, [BASE], {})
    assert [(column.joint, column.parameter, column.part) for column in columns] == [
        ("", "compliance", axis) for axis in range(3)
    ]
    small = 1e-8
    before = predict(run)
    for column in columns:
        compliance = [small if axis == column.part else 0.0 for axis in range(3)]
        then = predict(replay(log, on([BASE.on(nominal().robot, compliance=compliance)])))
        for (channel, k), rows in column.parts.items():
            quotient = (then[channel][..., k] - before[channel][..., k]) / small
            assert np.abs(rows - quotient).max() <= 0.1 * np.abs(quotient).max() + 1e-6, (channel, k)


def test_tangents_of_a_base_are_difference_quotients_of_replays():
    values = {"compliance": np.array([3e-5, 1e-5, 0.0]), "relaxation": np.array(2e-3)}
    one = Hypothesis(kind=BASE, joint="", source=None, values=values)
    log = assemble_log(nominal().robot, list(recorded({"nominal": nominal()}).values()))
    machine = one.on(nominal())
    run = replay(log, machine)
    columns, before = compute_tangents(run, nominal(), [one]), predict(run)
    for k, (free, column) in enumerate(zip(one.list_free(), columns, strict=True)):
        changes = [0.2 * free.nudge if n == k else 0.0 for n in range(len(columns))]
        then = predict(replay(log, one.move(changes).on(nominal())))
        quotient = (then["torque"] - before["torque"])[..., 0] / (0.2 * free.nudge / free.step)
        assert np.abs(column["torque", 0] - quotient).max() <= 0.1 * np.abs(quotient).max() + 1e-9, free


@pytest.mark.parametrize("has_one", [False, True])
def test_a_base_is_looked_for_unless_the_model_has_one_that_gives_way(has_one):
    machine = flexible("about all") if has_one else nominal()
    log = assemble_log(nominal().robot, list(recorded({"nominal": nominal()}).values()))
    judgeable, others = sort_effects(log, machine, ParameterPrior())
    assert (BASE in judgeable) == (not has_one)
    assert ("base_flexibility" in {one.effect for one in others}) == has_one
