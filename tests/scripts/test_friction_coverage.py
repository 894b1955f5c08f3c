"""Friction is found again, and its intervals are right as often as they say."""

import json

import numpy as np
import pytest

from scripts.friction_coverage import Config, main

ALLOWED = np.array([0.02, 0.02, 0.02, np.inf, 0.1, 0.1])
"""Largest relative error of f_c, f_s, f_v, v_s, sigma_0, sigma_1 that acceptance allows; it says nothing of v_s."""


def check(numbers):
    assert (np.array(numbers["largest_error"]) < ALLOWED).all(), numbers["largest_error"]
    coverage = np.array(numbers["coverage"])
    assert (coverage >= 0.8).all(), coverage
    assert (coverage <= 0.98).all() or numbers["repetitions"] < 50, coverage


def test_one_repetition_on_the_thesis_joint(tmp_path, capsys):
    path = tmp_path / "coverage.json"
    numbers = main(Config(repetitions=1, resamples=40, physics_dt=1.25e-4, record_dt=1e-3, json=path))
    assert (np.array(numbers["largest_error"]) < ALLOWED).all(), numbers
    assert json.loads(path.read_text())["repetitions"] == 1
    assert "| j1 |" in capsys.readouterr().out


@pytest.mark.slow
def test_fifty_repetitions_on_the_thesis_joint():
    check(main(Config()))


@pytest.mark.slow
def test_every_joint_of_six():
    numbers = main(Config(robot="irb4600_60_205", repetitions=2))
    assert (np.array(numbers["largest_error"]) < ALLOWED).all(), numbers
