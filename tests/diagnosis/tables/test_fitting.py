"""A structure that made a table is given back; ties are told; a search that is stopped goes on with the same bits."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.core.executors import Executor
from ffgym.diagnosis.tables.document import table_document
from ffgym.diagnosis.tables.error_table import ErrorTable, MotionKey, SignQuestion, TableRow
from ffgym.diagnosis.tables.fitting import FitTask, fit_structure
from ffgym.diagnosis.tables.parts import SINGLE, find_structure
from ffgym.diagnosis.tables.procedure import conclude, diagnose_table
from ffgym.diagnosis.tables.ranking import rank_structures
from ffgym.diagnosis.tables.simulated import TableSimulator
from ffgym.diagnosis.tables.structure_fit import StructureFit
from ffgym.diagnosis.tables.structures import extends
from ffgym.diagnosis.tables.verdict import judge_structures, write_sentence
from ffgym.robot import load_robot

DT = 0.001


def empty_table():
    rows = [
        TableRow(
            table="synthetic",
            use="held_out" if position == "p3" else "fitted",
            motion=MotionKey(position=position, speed_mm_s=40.0),
            radius_mm=radius,
            law=law,
            statistic=statistic,
            value_mm=1.0,
        )
        for position in ("p1", "p2", "p3")
        for radius in (1.0, 3.0)
        for law in ("none", "lugre_dynamic")
        for statistic in ("rms", "max")
    ]
    return ErrorTable(
        title="synthetic",
        source="",
        robot="irb4600_60_205",
        rows=tuple(rows),
        sign_of=SignQuestion(law="lugre_dynamic", speed_mm_s=40.0, radius_mm=1.0),
    )


@pytest.fixture(scope="module")
def table():
    """Errors of a robot with 80 % of the friction of its main joints behind their springs."""
    empty, robot = empty_table(), load_robot("irb4600_60_205")
    structure = find_structure("arm_friction")
    x = np.zeros(len(structure.numbers))
    x[-1] = np.log(0.8 / 0.2)
    values = TableSimulator(empty, robot).values([structure.candidate(robot, x)], empty.rows, DT)[0]
    rows = [replace(row, value_mm=float(value)) for row, value in zip(empty.rows, values, strict=True)]
    return replace(empty, rows=tuple(rows))


@pytest.fixture(scope="module")
def diagnosis(table, tmp_path_factory):
    return diagnose_table(
        table,
        structures=("description", "numbers", "arm_friction"),
        pairs=False,
        folder=tmp_path_factory.mktemp("fits"),
        executor=Executor(jobs=1),
        steps=3,
        judge_dt=DT,
        sessions=("circles",),
    )


def test_the_structure_that_made_a_table_is_named_with_its_number(diagnosis):
    assert (diagnosis.verdict, diagnosis.structure) == ("named", "arm_friction")
    best = diagnosis.ranked[0].fit
    share = next(number for number in best.numbers if number.name == "share of friction behind the elasticity")
    assert share.low < 0.8 < share.high
    assert share.value > 0.65
    assert diagnosis.ranked[0].sign_right == diagnosis.ranked[0].sign_cells == 3


def test_a_session_separates_it_from_its_rival(diagnosis):
    first = diagnosis.sessions[0]
    assert first.between[0] == "arm_friction"
    assert first.over_noise > 1
    assert "[[step]]" in first.toml


def test_the_document_has_every_structure_and_row(diagnosis):
    document = table_document(diagnosis)
    assert document["verdict"] == "named"
    assert len(document["rows"]) == 24
    first = document["structures"][0]
    assert first["name"] == "arm_friction"
    assert first["free_parameters"] == 10
    assert first["fitted_within_1_5"] == first["fitted_rms"] == 8
    assert first["held_out_rms"] == 4
    assert len(first["leave_one_position_out"]) == 2
    assert len(first["predicted_mm"]) == 24


@pytest.mark.slow
def test_a_search_that_is_stopped_goes_on_with_the_same_bits(table, tmp_path):
    def task(folder):
        folder.mkdir()
        return FitTask(table=table, name="numbers", folder=folder, steps=2, judge_dt=DT)

    class Stopped(Exception):
        pass

    def stop(text):
        if "step 1" in text:
            raise Stopped

    whole, parts = task(tmp_path / "whole"), task(tmp_path / "parts")
    once = fit_structure(whole)
    with pytest.raises(Stopped):
        fit_structure(parts, stop)
    told = []
    again = fit_structure(parts, told.append)
    assert told[0].startswith("numbers: step 1")
    assert (again.x, again.cost) == (once.x, once.cost)
    assert parts.file.read_bytes() == whole.file.read_bytes()


def test_a_state_of_another_search_is_refused(table, tmp_path):
    task = FitTask(table=table, name="description", folder=tmp_path, steps=1, judge_dt=DT)
    fit_structure(task)
    with pytest.raises(FFGymError, match="is of another table, robot, motion, structure"):
        fit_structure(replace(task, steps=2))


def fit_of(name, table, factor, free=1, seed=0):
    wrong = factor * np.exp(np.random.default_rng(seed).normal(scale=0.05, size=len(table.rows)))
    predicted = tuple((table.values * wrong).tolist())
    left_out = tuple(np.where(table.fitted, predicted, np.nan).tolist())
    return StructureFit(
        name=name,
        title=name,
        free_parameters=free,
        cost=1.0,
        prior_cost=0.0,
        steps=1,
        numbers=(),
        x=(),
        predicted_mm=predicted,
        left_out_mm=left_out,
        left_out_by="refit",
        fingerprint="",
    )


def test_ties_are_told_as_ties(table):
    fits = [fit_of("backlash", table, 1.0, seed=1), fit_of("delay", table, 1.0, seed=2), fit_of("drive", table, 2.0)]
    ranked = rank_structures(table, fits, seed=0)
    assert {one.fit.name for one in ranked if one.is_tied} == {"backlash", "delay"}
    assert judge_structures(ranked)[0] == "ambiguous"


def test_a_structure_that_ties_with_its_own_extension_alone_is_named(table):
    fits = [fit_of("delay+backlash", table, 1.0, free=2, seed=1), fit_of("delay", table, 1.0, seed=2)]
    assert judge_structures(rank_structures(table, fits, seed=0)) == ("named", "delay")


@pytest.mark.parametrize(("wrong_cells", "verdict"), [(1, "named"), (2, "partly"), (3, "partly")])
def test_a_structure_with_the_wrong_sign_in_half_of_the_cells_explains_the_table_in_part(table, wrong_cells, verdict):
    fit = fit_of("delay", table, 1.0)
    predicted = list(fit.predicted_mm)
    for law, none in table.sign_pairs()[:wrong_cells]:
        helps = table.values[law] < table.values[none]
        predicted[law] = (1.01 if helps else 0.99) * predicted[none]
    ranked = rank_structures(table, [replace(fit, predicted_mm=tuple(predicted))], seed=0)
    assert (ranked[0].sign_right, ranked[0].sign_cells) == (3 - wrong_cells, 3)
    assert judge_structures(ranked)[0] == verdict


def test_nothing_that_fits_is_unknown(table):
    assert judge_structures(rank_structures(table, [fit_of("delay", table, 2.0)], seed=0))[0] == "unknown"


def test_of_ties_that_explain_nothing_the_one_with_fewest_numbers_is_told():
    table = empty_table()
    fits = [fit_of("backlash", table, 2.0, free=2, seed=1), fit_of("delay", table, 2.0, seed=2)]
    ranked = rank_structures(table, fits, seed=0)
    verdict, best = judge_structures(ranked)
    assert (verdict, best) == ("unknown", "delay")
    assert "of 2 that tie for the best, delay of the torque has fewest" in write_sentence(verdict, best, ranked)


def test_a_structure_that_cannot_be_simulated_is_named():
    table, fit = empty_table(), fit_of("delay", empty_table(), 1.0)
    broken = replace(fit, predicted_mm=(float("nan"), *fit.predicted_mm[1:]))
    with pytest.raises(FFGymError, match="Structure 'delay' as fitted cannot be simulated: 1 of 24 rows"):
        conclude(table, [broken])


@pytest.mark.parametrize("name", SINGLE)
def test_every_structure_has_at_most_14_numbers_and_a_machine(name):
    structure, robot = find_structure(name), load_robot("irb4600_60_205")
    assert len(structure.numbers) <= 14
    assert structure.name == name
    assert all(number.source and number.spread > 0 for number in structure.numbers)
    machine = structure.candidate(robot, np.zeros(len(structure.numbers))).machine
    assert machine.robot.n_joints == 6


def test_pairs_extend_their_parts():
    assert extends("delay+backlash", "delay")
    assert extends("delay", "numbers")
    assert not extends("delay", "backlash")
    assert not extends("description", "numbers")
    with pytest.raises(FFGymError, match="must name different parts"):
        find_structure("delay+delay")


def test_a_law_that_learns_can_only_be_held_out(table):
    row = replace(table.rows[0], law="bsn_static")
    with pytest.raises(FFGymError, match=r"must be none, lugre_static, lugre_dynamic.* 'held_out'"):
        diagnose_table(replace(table, rows=(*table.rows, row)), learn=lambda *_: None, folder=Path("unused"))


def test_a_law_that_learns_needs_a_function_that_makes_it(table):
    row = replace(table.rows[0], law="bsn_static", use="held_out")
    with pytest.raises(FFGymError, match="learn on the machine"):
        diagnose_table(replace(table, rows=(*table.rows, row)), folder=Path("unused"))
