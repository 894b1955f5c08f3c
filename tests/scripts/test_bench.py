"""The benchmark measures the batch simulation against the bare engine."""

import numpy as np
import pytest

from ffgym.robot import RigidArm
from ffgym.simulation import Run
from ffgym.studies import circle_references, thesis_laws
from scripts.bench import Config, bare_rate, main, measure


@pytest.mark.slow
def test_the_benchmark_prints_its_ratio(capsys):
    (pair,) = main(Config(repeats=1))
    assert 0 < pair.whole < pair.stepping
    assert pair.bare > 0
    assert "median ratio to the bare engine: stepping" in capsys.readouterr().out


def test_one_measurement_of_a_few_runs_has_three_rates(irb4600):
    arm = RigidArm(irb4600)
    reference = circle_references(arm, ["p1"], [0.1], [0.001])["p1", 0.1]
    runs = [Run(reference=reference, law=law) for law in thesis_laws(irb4600)]
    pair = measure(irb4600, arm, runs, threads=1)
    assert 0 < pair.whole <= pair.stepping
    assert 0 < pair.bare < 1e9


def test_the_bare_engine_runs_simulations_of_different_lengths(one_axis):
    assert bare_rate(one_axis, np.array([10, 30, 20, 30]), threads=1) > 0
