"""The calibration of the nominal robot on a small budget, and what it writes into a description."""

import shutil
import tomllib
from importlib import resources

import numpy as np
import pytest

from ffgym.robot import load_robot
from scripts import calibrate_nominal
from scripts.calibrate_nominal import FREE, Config, apply, main, prior_robot, write_fitted

GROUPS = ("servo", "drive", "friction")


@pytest.fixture
def copy(tmp_path):
    path = tmp_path / "irb4600_60_205.toml"
    with resources.as_file(resources.files("ffgym.robot") / "data" / path.name) as built_in:
        shutil.copyfile(built_in, path)
    return path


@pytest.fixture
def fast_only(monkeypatch):
    """Score at 40 mm/s alone."""
    monkeypatch.setattr(calibrate_nominal, "SPEEDS", (0.040,))


def numbers(robot):
    """Every number of the groups that a fit may touch."""
    return {
        path: np.asarray(getattr(getattr(robot, path.split(".")[0]), path.split(".")[1]))
        for path in robot.quantities
        if path.startswith(GROUPS)
    }


def test_a_dry_run_scores_the_prior_and_leaves_the_file_alone(copy, fast_only, capsys):
    before = copy.read_bytes()
    result = main(Config(robot=copy, starts=1, iterations=0, dry_run=True))
    assert copy.read_bytes() == before
    assert result["factors"].keys() == FREE.keys()
    assert all(factor > 0 for factor in result["factors"].values())
    assert len(result["ratios"]) == 12
    assert np.all(np.array(result["ratios"]) > 0)
    assert result["cost"] > 0
    assert "cells within a factor 1.5" in capsys.readouterr().out


@pytest.mark.slow
def test_a_step_of_the_search_lowers_the_cost_and_is_written(copy, fast_only):
    dry = main(Config(robot=copy, starts=0, iterations=0, dry_run=True))
    result = main(Config(robot=copy, starts=0, iterations=2))
    assert result["cost"] < dry["cost"]
    np.testing.assert_allclose(
        load_robot(copy).drive.joint_stiffness[0],
        prior_robot(load_robot(copy)).drive.joint_stiffness[0] * result["factors"]["stiffness of joint 1"],
        rtol=1e-3,
    )


def test_the_prior_robot_has_the_numbers_that_the_fit_replaced(irb4600):
    prior = prior_robot(irb4600)
    for path, value in numbers(prior).items():
        quantity = irb4600.quantities[path]
        np.testing.assert_array_equal(value, quantity.value if quantity.prior is None else quantity.prior)
    assert prior.kinematics is irb4600.kinematics


def test_factors_scale_servo_rates_stiffness_and_unsourced_viscous_friction(irb4600):
    prior = prior_robot(irb4600)
    plain = apply(prior, np.ones(len(FREE)))
    factors = np.array([2, 3, 5, 7, 11, 13, 1.5, 1.1, 1.2, 1.3])
    scaled = apply(prior, factors)

    def ratio(group, name):
        return getattr(getattr(scaled, group), name) / getattr(getattr(plain, group), name)

    np.testing.assert_allclose(ratio("servo", "velocity_gain"), [2, 2, 2, 7, 7, 7])
    np.testing.assert_allclose(ratio("servo", "position_gain"), [6, 6, 6, 77, 77, 77])
    np.testing.assert_allclose(ratio("servo", "integral_gain"), [30, 30, 30, 1001, 1001, 1001])
    np.testing.assert_allclose(ratio("drive", "joint_stiffness"), [1.1, 1.2, 1.3, 1, 1, 1])
    np.testing.assert_allclose(ratio("drive", "joint_damping"), [1.1, 1.2, 1.3, 1, 1, 1])
    np.testing.assert_allclose(ratio("friction", "viscous"), [1] + [1.5] * 5)
    for name in ("coulomb", "static", "bristle_stiffness", "bristle_damping", "stribeck_velocity"):
        np.testing.assert_array_equal(getattr(scaled.friction, name), getattr(irb4600.friction, name))


@pytest.mark.parametrize("seed", [None, 0, 1])
def test_the_written_file_holds_the_fitted_numbers_and_keeps_everything_else(copy, seed):
    """A fit that ends at the prior (None) replaces an earlier one too."""
    original, text = load_robot(copy), copy.read_text(encoding="utf-8")
    logs = np.zeros(len(FREE)) if seed is None else np.random.default_rng(seed).normal(scale=0.3, size=len(FREE))
    prior = prior_robot(original)
    fitted = apply(prior, np.exp(logs))
    write_fitted(copy, prior, fitted, "a test")
    written = load_robot(copy)
    for path, value in numbers(fitted).items():
        np.testing.assert_allclose(numbers(written)[path], value, rtol=6e-4)  # written to 4 digits
        quantity, old = written.quantities[path], original.quantities[path]
        for j in (j for j, origin in enumerate(old.origin) if origin == "sourced" and quantity.value.ndim):
            assert quantity.value[j] == old.value[j]
            assert quantity.origin[j if len(quantity.origin) > 1 else 0] == "sourced"
        if old.prior is not None:
            np.testing.assert_array_equal(quantity.prior, old.prior)
            assert quantity.source == "a test"
    comments = [line for line in text.splitlines() if line.startswith("#")]
    assert [line for line in copy.read_text(encoding="utf-8").splitlines() if line.startswith("#")] == comments
    before, after = tomllib.loads(text), tomllib.loads(copy.read_text(encoding="utf-8"))
    for group in before.keys() - set(GROUPS):
        assert after[group] == before[group]


def test_a_second_fit_keeps_the_first_prior(copy):
    original = load_robot(copy)
    for factor in (2.0, 3.0):
        robot = load_robot(copy)
        write_fitted(copy, prior_robot(robot), apply(prior_robot(robot), np.full(len(FREE), factor)), "a test")
    written, table = load_robot(copy), tomllib.loads(copy.read_text(encoding="utf-8"))
    assert "Absolute-Accuracy compliances" in table["drive"]["joint_stiffness"]["prior_source"]
    for path, quantity in original.quantities.items():
        if quantity.prior is not None:
            np.testing.assert_array_equal(written.quantities[path].prior, quantity.prior)
    np.testing.assert_allclose(written.drive.joint_stiffness[:3], 3 * prior_robot(original).drive.joint_stiffness[:3])
    assert written.quantities["friction.viscous"].origin == ("sourced", *["fitted"] * 5)
