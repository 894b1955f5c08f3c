"""The simulation approaches the truth at the order of its method, and the script of docs/physics.md reports it."""

import numpy as np
import pytest

from scripts.convergence_table import Config, energy_drift, lugre_errors, main, renewed


def test_error_of_an_inertia_with_lugre_friction_falls_in_proportion_to_the_step(one_axis):
    errors = lugre_errors(one_axis, [0.002 / 2**k for k in range(6)], duration=1.0)
    orders = np.log2(errors[:-1] / errors[1:])
    np.testing.assert_allclose(orders, 1.0, atol=0.1)
    np.testing.assert_array_less(errors[-1], [5e-3, 5e-5])  # [rad/s] of 4, [rad] of 0.0077


def test_energy_drift_of_the_script_falls_in_proportion_to_the_step(irb4600):
    drift, swing = energy_drift(irb4600, [0.00025 / 2**k for k in range(3)]).T
    np.testing.assert_allclose(np.log2(drift[:-1] / drift[1:]), 1.0, atol=0.3)
    assert drift[0] < 0.1 * swing[0]


def test_script_makes_every_table_of_the_page_and_renews_it_in_place(tmp_path, capsys):
    page = tmp_path / "physics.md"
    page.write_text("a\n" + "".join(f"<!-- {name} -->\nold\n<!-- end -->\n" for name in ("lugre", "energy", "circles")))
    budget = Config(
        steps=(0.002, 0.001), energy_steps=(0.0005, 0.00025), duration=0.1, positions=("p1",), speeds=(0.1,),
        radii=(0.001,), write=page,
    )  # fmt: skip
    tables = main(budget)
    assert set(tables) == {"lugre", "energy", "circles"}
    text = page.read_text()
    assert "old" not in text
    assert all(table in text for table in tables.values())
    assert tables["circles"].count("\n") == 1 + 5
    assert "physics_dt" in capsys.readouterr().out


def test_a_page_without_marks_is_not_touched():
    with pytest.raises(ValueError, match="lacks the marks"):
        renewed("nothing here", {"lugre": "table"})
