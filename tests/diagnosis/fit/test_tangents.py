"""Tangents of a fitted machine are difference quotients of its replays."""

import numpy as np
import pytest

from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.fit.problem import compute_tangents
from ffgym.diagnosis.log import assemble_log
from ffgym.diagnosis.replay.channels import predict
from ffgym.diagnosis.replay.rows import replay
from ffgym.diagnosis.residual_rows import find_valid_rows
from ffgym.effects import EFFECTS
from tests.diagnosis.replay.replay_samples import nominal, recorded

VALUES = {
    "coulomb_level": {"change": 0.2},
    "cable_pull": {},
    "torque_constant": {"change": 0.03},
    "cogging": {"amplitude": 0.1, "cycles": 48.0},
    "resolver_ripple": {"amplitude": 1e-3, "cycles": 2.0},
}


@pytest.fixture(scope="module")
def log():
    return assemble_log(nominal().robot, list(recorded({"nominal": nominal()}).values()))


def hypotheses(names=tuple(VALUES)):
    found = []
    for name in names:
        given = VALUES[name]
        known = EFFECTS[name].parameters()
        values = {
            n: np.array(given.get(n, p.default if p.default is not None else p.neutral)) for n, p in known.items()
        }
        found.append(Hypothesis(kind=EFFECTS[name], joint=nominal().robot.joints[0], source=None, values=values))
    return found


def test_tangents_are_difference_quotients_of_replays(log):
    all_of_them = hypotheses()
    machine = nominal()
    for one in all_of_them:
        machine = one.on(machine)
    run = replay(log, machine)
    columns, at = compute_tangents(run, nominal(), all_of_them), 0
    now, inside = predict(run), find_valid_rows(log)
    for i, one in enumerate(all_of_them):
        for k, free in enumerate(one.list_free()):
            share = 0.2 * free.nudge / free.step
            moved = one.move([share * free.step if n == k else 0.0 for n in range(len(one.list_free()))])
            other = nominal()
            for j, hypothesis in enumerate(all_of_them):
                other = (moved if j == i else hypothesis).on(other)
            then = predict(replay(log, other))
            quotient = (then["torque"] - now["torque"])[..., 0][inside] / share
            column = columns[at]["torque", 0][inside]
            at += 1
            assert np.abs(column - quotient).max() <= 0.1 * np.abs(quotient).max() + 1e-9, (one.label, free.name)
    assert at == len(columns)


def test_columns_that_are_known_stand_in_their_places(log):
    # a replay for a resolver rounds by what is beside it
    all_of_them, machine = hypotheses(name for name in VALUES if name != "resolver_ripple"), nominal()
    for one in all_of_them:
        machine = one.on(machine)
    run = replay(log, machine)
    columns = compute_tangents(run, nominal(), all_of_them)
    n = len(all_of_them[1].list_free())
    given = [{("torque", 0): np.full(1, k)} for k in range(n)]
    at = len(all_of_them[0].list_free())
    again = compute_tangents(run, nominal(), all_of_them, {1: given})
    assert again[at : at + n] == given
    for one, other in zip(columns[:at] + columns[at + n :], again[:at] + again[at + n :], strict=True):
        assert one.keys() == other.keys()
        for key, rows in one.items():
            np.testing.assert_array_equal(rows, other[key])


@pytest.mark.parametrize("cycles", [1.0, 15.0, 60.0])
def test_the_slope_of_a_frequency_is_found_within_a_radian_of_all_turns_of_a_log(cycles):
    """A hundred turns of a motor from one pose to another."""
    known = EFFECTS["cogging"].parameters()
    values = {name: np.array(p.neutral if p.default is None else p.default) for name, p in known.items()}
    one = Hypothesis(kind=EFFECTS["cogging"], joint="j1", source=None, values=values | {"cycles": np.array(cycles)})
    (frequency,) = [free for free in one.list_free() if free.name == "cycles"]
    assert 2 * np.pi * 100 * frequency.nudge < 0.5
    assert frequency.nudge / cycles > 1e-6  # far from rounding
