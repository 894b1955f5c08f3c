"""The logs that ship with the package: what they are, and that the script makes them."""

import numpy as np
import pytest

from ffgym.diagnosis.nominal import EXAMPLE_ROBOT, example_logs
from ffgym.logs.quality import check_quality
from ffgym.recordings.npz import decode
from ffgym.robot import load_robot
from ffgym.workcell import SealedMachine
from scripts.example_logs import STEPS, Config, encode, example_cell, recordings

SEED = Config().seed
SHORTEST = 6
"""Place of the shortest motion."""


def check_same(made, shipped):
    """Equal up to a step of rounding here and there, which other processors take otherwise."""
    assert made.header == shipped.header
    assert list(made.columns) == list(shipped.columns)
    for name, values in made.columns.items():
        step = max((step for family, step in STEPS.items() if name.startswith(family)), default=1e-5)
        assert np.mean(values != shipped[name]) < 0.01
        np.testing.assert_allclose(values, shipped[name], rtol=0, atol=1.001 * step, equal_nan=True)


def test_the_script_makes_the_shortest_log_again():
    (made,) = recordings(SEED, only=[SHORTEST])
    check_same(made, example_logs()[SHORTEST])


@pytest.mark.slow
def test_the_script_makes_all_logs_again():
    for made, shipped in zip(recordings(SEED), example_logs(), strict=True):
        check_same(made, shipped)


def test_the_file_of_a_log_loses_nothing():
    log = example_logs()[SHORTEST]
    assert decode(encode(log)).equals(log)


def test_the_quality_gate_lets_the_logs_pass():
    robot = load_robot(EXAMPLE_ROBOT)
    for log in example_logs():
        report = check_quality(log, robot=robot, needs=["position", "torque", "tracker"])
        assert report.verdict != "insufficient", report.problems


def test_logs_do_not_say_what_is_wrong_with_the_machine():
    cell = example_cell(SEED)
    assert isinstance(cell.machine, SealedMachine)
    for log in example_logs():
        header = log.header.to_json()
        assert not any(effect.name in header for effect in cell.machine.effects)
        assert not any(log.has(family) for family in ("friction.effort", "link.position", "link.velocity"))
