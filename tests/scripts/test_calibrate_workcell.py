"""The calibration of the workcell: what its numbers do to the files, and that its search goes down and can go on."""

import json
import tomllib
from dataclasses import replace
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.tables.problem import RMS_SPREAD
from ffgym.paths import RADII
from ffgym.published import METHODS, published_mm
from ffgym.robot import load_robot, with_parameters
from ffgym.studies import StudyCell
from ffgym.workcell.reading import build
from scripts.calibrate_workcell import Config, main
from scripts.workcell.free import (
    CALIBRATIONS,
    applied,
    prior_trees,
    round_entries,
    table_at,
    write_result,
)
from scripts.workcell.search import Objective, search
from scripts.workcell.table import SPEEDS, summary, table

THESIS = CALIBRATIONS["thesis"]
FREE, SPREAD = THESIS.free, THESIS.spread


@pytest.fixture(scope="module")
def prior(irb4600):
    return prior_trees(THESIS, irb4600)


def index_of(name):
    return [free.name for free in FREE].index(name)


@pytest.mark.parametrize("calibration", CALIBRATIONS.values(), ids=CALIBRATIONS.keys())
def test_free_numbers_have_names_of_their_own_and_change_entries_that_exist(calibration):
    assert len({free.name for free in calibration.free}) == len(calibration.free)
    prior = prior_trees(calibration, load_robot(calibration.nominal))
    for file, entry in calibration.changes:
        assert table_at(prior[file], entry)["unit"]


def test_a_share_behind_the_elasticity_is_free_in_its_own_workcell_alone():
    arm = CALIBRATIONS["thesis_arm"]
    names = {free.name for free in arm.free} - {free.name for free in FREE}
    assert names == {f"share of friction behind the elasticity, joint {joint}" for joint in (1, 2, 3)}
    prior = prior_trees(arm, load_robot(arm.nominal))
    for end, bound in ((10.0, (0.9, 1.0)), (-10.0, (0.0, 0.1))):
        x = arm.clip(np.full(len(arm.free), end))
        shares = table_at(applied(arm, prior, x)["machine"], "friction.arm_share")["value"]
        assert all(bound[0] <= share < bound[1] for share in shares[:3])
        assert shares[3:] == [0.0] * 3


def test_slip_elements_and_lugre_together_have_the_friction_of_the_thesis(prior, irb4600):
    machine = prior["machine"]
    both = np.array(machine["friction"]["coulomb"]["value"]) + machine["effects"]["slip_elements"]["level"]["value"]
    np.testing.assert_allclose(both, irb4600.friction.coulomb, rtol=1e-12)


def test_numbers_at_zero_are_the_prior(prior):
    assert applied(THESIS, prior, np.zeros(len(FREE))) == prior


def test_a_factor_and_a_shift_change_their_entries_and_joints_alone(prior):
    x = np.zeros(len(FREE))
    x[index_of("stiffness, joint 2")], x[index_of("payload")] = np.log(2.0), 1.5
    trees = applied(THESIS, prior, x)
    before, after = (np.array(table_at(t["machine"], "drive.joint_stiffness")["value"]) for t in (prior, trees))
    np.testing.assert_allclose(after / before, [1, 2, 1, 1, 1, 1])
    assert trees["machine"]["payload"]["mass"]["value"] == prior["machine"]["payload"]["mass"]["value"] + 1.5
    assert trees["controller"] == prior["controller"]
    assert trees["machine"]["links"] == prior["machine"]["links"]


def test_files_that_are_written_are_read_as_what_was_simulated(prior, irb4600, tmp_path):
    machine, controller = tmp_path / "thesis.toml", tmp_path / "irb4600_60_205_commissioned.toml"
    elsewhere = replace(THESIS, machine=machine, controller=controller)
    x = 0.5 * SPREAD * np.random.default_rng(0).uniform(-1, 1, len(FREE))
    write_result(elsewhere, prior, x)
    simulated, tree = round_entries(THESIS, applied(THESIS, prior, x)), tree_of(machine)
    cell, same = build("test", tree), build("test", simulated["machine"])
    np.testing.assert_array_equal(cell.machine.robot.friction.coulomb, same.machine.robot.friction.coulomb)
    np.testing.assert_array_equal(cell.machine.robot.bodies.inertia, same.machine.robot.bodies.inertia)
    for one, other in zip(cell.machine.effects, same.machine.effects, strict=True):
        assert {n: v.tolist() for n, v in one.values().items()} == {n: v.tolist() for n, v in other.values().items()}
    known = with_parameters(irb4600, controller)
    assert known.friction.static.tolist() == simulated["controller"]["friction"]["static"]["value"]
    assert known.quantities["friction.viscous"].origin == ("fitted",) * 6
    assert tree["friction"]["coulomb"]["origin"] == ["sourced", *["fitted"] * 5]


def tree_of(path):
    return tomllib.loads(path.read_text(encoding="utf-8"))


class Valley(Objective):
    """An objective whose sizes are known functions of the free numbers, and which simulates nothing."""

    def __init__(self, published):
        self.published, self.calibration = published, THESIS

    def candidate(self, x):
        return x

    def sizes(self, candidates):
        n = self.published.size
        return np.stack(
            [
                (self.published.ravel() * np.exp(0.3 + x[np.arange(n) % len(x)])).reshape(self.published.shape)
                for x in candidates
            ]
        )


def test_the_search_goes_down_and_goes_on_where_it_was(tmp_path):
    valley, state = Valley(np.full((2, 3, 2, 4, 3), 0.1)), tmp_path / "state.json"
    costs = []
    first = search(valley, 2, state, lambda step, point: costs.append(point.cost))
    assert np.all(np.diff(costs) < 0)
    begun = []
    search(valley, 0, state, lambda step, point: begun.append(point))
    np.testing.assert_array_equal(begun[0].x, first.x)
    assert begun[0].cost == first.cost


def test_a_state_of_other_numbers_is_refused(tmp_path):
    state = tmp_path / "state.json"
    state.write_text(json.dumps({"x": {"other": 0.0}, "damping": 1.0}), encoding="utf-8")
    with pytest.raises(FFGymError, match="other free numbers"):
        search(Valley(np.full((2, 3, 2, 4, 3), 0.1)), 1, state, lambda step, point: None)


def test_the_objective_pays_for_misfit_and_for_distance_from_the_prior():
    valley = Valley(np.full((2, 3, 2, 4, 3), 0.1))
    exact = valley.residuals(np.zeros(len(FREE)), valley.published)
    assert not exact.any()
    off = valley.residuals(SPREAD, valley.published * np.exp(RMS_SPREAD))
    assert off[: valley.published.size // 2] == pytest.approx(1.0)
    largest = off[valley.published.size // 2 : valley.published.size]
    assert largest**2 == pytest.approx(0.25)  # largest errors weigh a quarter
    assert off[valley.published.size :] == pytest.approx(1.0)


def test_published_errors_are_by_statistic_law_speed_position_and_radius(prior, irb4600):
    published = Objective(THESIS, irb4600, prior, 1).published
    for (s, statistic), (k, law), (v, speed), (p, position), (r, radius) in product(
        enumerate(("rms", "max")),
        enumerate(("none", "lugre_static", "lugre_dynamic")),
        enumerate((0.010, 0.040)),
        enumerate(("p1", "p2", "p3", "p4")),
        enumerate(RADII),
    ):
        assert published[s, k, v, p, r] == published_mm(law, statistic, speed, radius, position)


@pytest.mark.slow
def test_the_command_line_evaluates_the_prior(tmp_path, monkeypatch, capsys):
    elsewhere = replace(THESIS, machine=tmp_path / "thesis.toml", controller=tmp_path / "commissioned.toml")
    monkeypatch.setitem(CALIBRATIONS, "thesis", elsewhere)
    reached = main(Config(steps=0, state=tmp_path / "state.json", threads=1))
    assert reached["median"] > 0.1
    assert "step 0" in capsys.readouterr().out
    assert (tmp_path / "thesis.toml").exists()


def cells_off_by(factor):
    """All cells of Tables 4.1 to 5.2, off by one factor."""
    return [
        StudyCell(
            agent=law,
            plant="thesis",
            position=position,
            radius_mm=round(radius * 1e3, 6),
            speed_mm_s=round(speed * 1e3, 6),
            rms_mm=factor * published_mm(law, "rms", speed, radius, position),
            max_mm=factor * published_mm(law, "max", speed, radius, position),
            rms_3d_mm=0.0,
            max_3d_mm=0.0,
            motor_rms_rad=[],
        )
        for law in METHODS
        for speed in SPEEDS
        for radius in RADII
        for position in ("p1", "p2", "p3", "p4")
    ]


def test_the_table_has_all_published_numbers_and_the_networks_are_the_check():
    cells = cells_off_by(1.2)
    lines = table(cells).splitlines()
    assert sum(line.count(" / ") for line in lines) == 240
    assert sum("bsn" in line for line in lines) == 24
    assert summary(cells) == pytest.approx(dict.fromkeys(summary(cells), np.log(1.2)))
    assert list(summary(cells)) == ["rms, fitted", "rms, kept out", "max, fitted", "max, kept out"]


def test_the_table_of_fitted_laws_has_no_network_and_needs_no_training(tmp_path, monkeypatch, capsys):
    seen = [cell for cell in cells_off_by(1.2) if not cell.agent.startswith("bsn")]
    laws = list(dict.fromkeys(cell.agent for cell in seen))

    def study(cell, laws, speeds, n_threads):
        return SimpleNamespace(cells=[cell for cell in seen if cell.agent in {law.name for law in laws}])

    monkeypatch.setattr("scripts.workcell.table.circle_study", study)
    place = tmp_path / "table.json"
    reached = main(Config(table=True, fitted=True, threads=1, json=place))
    assert list(reached) == ["rms, fitted", "max, fitted"]
    assert [cell["agent"] for cell in json.loads(place.read_text(encoding="utf-8"))["cells"]] == [
        cell.agent for cell in seen
    ]
    assert laws == ["none", "lugre_static", "lugre_dynamic"]
    assert "bsn" not in capsys.readouterr().out
