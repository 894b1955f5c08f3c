import re
import sys
from dataclasses import replace

import pytest

from ffgym.logs.quality import Finding, QualityReport
from ffgym.published import published_mm
from ffgym.report import circle_tables, format_one_axis, format_text
from ffgym.report.quality import format_quality
from ffgym.report.table import WIDTH


def test_table_entries_are_the_cells_of_the_study(circle):
    for table in circle_tables(circle):
        for row in table.rows:
            for agent, entry in row.entries.items():
                [cell] = circle.select(agent=agent, position=row.position, speed_mm_s=table.speed_mm_s)
                assert (entry.rms, entry.max) == (cell.rms_mm, cell.max_mm)


def test_text_shows_every_cell_as_rms_and_max(circle):
    text = format_text(circle)
    for cell in circle.cells:
        assert f"{cell.rms_mm:.3f} ({cell.max_mm:.3f})" in text


def test_the_text_names_the_machine_where_it_is_not_the_robot_itself(made_up):
    study = made_up(laws=("none",))
    on_another = replace(study, cells=[replace(cell, plant="worn") for cell in study.cells])
    assert study.robot.title in format_text(study)
    assert "machine" not in format_text(study)
    assert "machine: worn" in " ".join(format_text(on_another).split())


def test_published_numbers_stand_beside_the_simulated_ones_in_the_order_of_the_laws(made_up):
    table = circle_tables(made_up())[0]
    for row in table.rows:
        for agent, entry in row.entries.items():
            where = (0.01, row.radius_mm / 1e3, row.position)
            assert entry.published_rms == published_mm(agent, "rms", *where)
            assert entry.published_max == published_mm(agent, "max", *where)
    lines = [re.split(r"[ |]{2,}", line) for line in format_text(made_up(lambda *_: 2.0)).splitlines()]
    numbers = next(parts for parts in lines if parts[:2] == ["5", "p4"])
    assert numbers[2:6] == ["0.210 (0.420)", "0.105 (0.27)", "0.124 (0.248)", "0.062 (0.15)"]


def test_a_speed_without_published_numbers_says_so(circle):
    before, after = format_text(circle).split("\n100 mm/s\n")
    assert "no numbers were published for these circles at 100 mm/s" in after
    assert "no numbers were published" not in before


def test_ratio_lines_give_each_circle_the_median_and_the_count_within_the_factor(made_up):
    study = made_up(lambda law, speed, radius, position: 1.45 if position == "p1" else 1.75)
    text = format_text(study)
    ratios = re.findall(r"^[135] +(p\d) +\| (\d\.\d\d)$", text, flags=re.MULTILINE)
    assert ratios == [("p1", "1.45"), ("p2", "1.75"), ("p3", "1.75"), ("p4", "1.75")] * 6
    assert text.count("median 1.75; 3 of 12 circles within a factor of 1.5 (0.67 to 1.5)") == 2


def test_a_study_without_the_uncompensated_law_has_tables_but_no_ratio(made_up):
    text = format_text(made_up(laws=("lugre_static",)))
    assert "No run without compensation" in text
    assert "static LuGre" in text


@pytest.mark.parametrize("length", [1, 25, 200])
def test_lines_fit_the_terminal_with_many_laws_and_long_names(made_up, length):
    laws = ("none", "lugre_static", "lugre_dynamic", "bsn_static", "bsn_extended")
    study = made_up(laws=laws, rename=lambda law: law + "x" * length)
    text = format_text(study)
    assert max(len(line) for line in text.splitlines()) <= WIDTH
    assert all(f"{cell.rms_mm:.3f} ({cell.max_mm:.3f})" in text for cell in study.cells)


def test_one_axis_text_shows_every_result(sine):
    text = format_one_axis(sine)
    assert max(len(line) for line in text.splitlines()) <= WIDTH
    for result in sine.results:
        assert f"{result.motor_rms_rad * 1e3:.3f}" in text
        assert f"{result.motor_max_rad * 1e3:.3f}" in text
        assert f"{result.reduction:.1%}" in text


def test_tables_need_no_matplotlib(circle, sine, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert format_text(circle)
    assert format_one_axis(sine)


def test_a_problem_that_several_joints_share_is_told_once():
    shared = [Finding(check="need_friction", verdict="flagged", message="j2, j3 rest.", joint=j) for j in ("j2", "j3")]
    other = Finding(check="spike", verdict="flagged", message="j1 jumps.", joint="j1")
    report = QualityReport(robot="cell", segment="", n_rows=10, duration=1.0, findings=(*shared, other))
    assert format_quality(report).splitlines()[1:] == [
        "flagged: [need_friction] j2, j3 rest.",
        "flagged: [spike] j1 jumps.",
    ]
