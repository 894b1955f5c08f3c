"""What a robot check prints and draws: complete robots, drafts, arms of any kind."""

import re
from dataclasses import replace

import numpy as np
import pytest

from ffgym.report.robot.page import format_check, render_robot_page, robot_tables
from ffgym.report.robot.pictures import robot_figures
from ffgym.robot import CAPABILITIES, builtin_robots, load_draft
from ffgym.studies.robot_check import check_robot

pytest.importorskip("matplotlib")
pytest.importorskip("jinja2")


@pytest.fixture(scope="module")
def checks():
    drafts = {name: load_draft(name) for name in builtin_robots()}
    whole = drafts["irb4600_60_205"]
    for group in ("servo", "drive", "links", "kinematics"):
        left = {path: q for path, q in whole.quantities.items() if not path.startswith(group)}
        drafts[f"without {group}"] = replace(whole, quantities=left)
    rotors = replace(whole.quantities["drive.rotor_inertia"], value=np.full(6, 30.0))
    drafts["heavy rotors"] = replace(whole, quantities=dict(whole.quantities) | {"drive.rotor_inertia": rotors})
    drafts["nothing"] = replace(whole, quantities={}, geoms=())
    return {name: check_robot(draft) for name, draft in drafts.items()}


def test_text_fits_a_terminal_and_names_what_is_missing(checks):
    for name, check in checks.items():
        text = format_check(check)
        assert max(map(len, text.splitlines())) <= 120, name
        assert check.draft.title in text
        for said in (*check.draft.missing, *check.doubts):
            assert said in " ".join(text.split())
    assert checks["heavy rotors"].doubts


def test_tables_say_of_every_function_whether_it_works(checks):
    for check in checks.values():
        (table,) = [table for table in robot_tables(check) if table.name == "functions"]
        said = {row[0]: row[1] for row in table.rows}
        assert said == {entry.title: "yes" if check.works(entry) else "no" for entry in CAPABILITIES}
        assert all(len(row) == len(table.headings) for table in robot_tables(check) for row in table.rows)


@pytest.mark.parametrize("name", ["one_axis", "without links", "nothing"])
def test_a_page_needs_no_other_file_and_shows_every_source(checks, name):
    page = render_robot_page(checks[name], {"command": "ffgym robot check"})
    assert not re.findall(r'(?:src|href)="(?!data:|#)', page)
    assert "<script" not in page
    for path in checks[name].draft.quantities:
        assert f"<code>{path}</code>" in page


def test_names_that_look_like_html_do_no_harm(checks):
    draft = replace(checks["one_axis"].draft, title="<b>my</b> & robot")
    assert "&lt;b&gt;my&lt;/b&gt; &amp; robot" in render_robot_page(check_robot(draft), {})


def test_every_robot_is_drawn_and_masses_only_where_they_are_known(checks):
    for name in ("ball_screw", "one_axis", "without links", "without kinematics", "nothing"):
        check = checks[name]
        captions = {figure.name: figure.caption for figure in robot_figures(check)}
        assert ("skeleton" in captions) == (check.reach is not None), name
        if "skeleton" in captions:
            assert ("ellipsoids" in captions["skeleton"]) == check.draft.can("link_torque"), name


@pytest.mark.usefixtures("needs_gl")
def test_looks_are_drawn_where_opengl_works(checks):
    assert {figure.name for figure in robot_figures(checks["irb4600_60_205"])} == {"skeleton", "looks"}
