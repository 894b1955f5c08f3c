"""The simulation approaches the truth at the order of its method, and the tables of docs/physics.md report it."""

import numpy as np

from scripts.tables.physics import convergence, energy_drift, lugre_errors


def test_error_of_an_inertia_with_lugre_friction_falls_in_proportion_to_the_step(one_axis):
    errors = lugre_errors(one_axis, [0.002 / 2**k for k in range(6)], duration=1.0)
    orders = np.log2(errors[:-1] / errors[1:])
    np.testing.assert_allclose(orders, 1.0, atol=0.1)
    np.testing.assert_array_less(errors[-1], [5e-3, 5e-5])  # [rad/s] of 4, [rad] of 0.0077


def test_energy_drift_of_the_script_falls_in_proportion_to_the_step(irb4600):
    drift, swing = energy_drift(irb4600, [0.00025 / 2**k for k in range(3)]).T
    np.testing.assert_allclose(np.log2(drift[:-1] / drift[1:]), 1.0, atol=0.3)
    assert drift[0] < 0.1 * swing[0]


def test_the_page_has_a_table_of_each_kind_of_error():
    budget = {"positions": ["p1"], "speeds": [0.1], "radii": [0.001]}
    tables = convergence(steps=(0.002, 0.001), energy_steps=(0.0005, 0.00025), duration=0.1, **budget).parts
    assert set(tables) == {"lugre", "energy", "circles"}
    assert tables["circles"].count("\n") == 1 + 5
    assert tables["energy"].splitlines()[0].startswith("| physics_dt [ms] | energy drift [J] |")
