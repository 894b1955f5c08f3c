import base64
import re
import sys

import pytest

from ffgym.control import NoCompensation
from ffgym.core.errors import FFGymError
from ffgym.report import circle_figures, findings, one_axis_figures, render_report, write_report
from ffgym.report.circles.page import provenance
from ffgym.studies import circle_study, one_axis_study
from tests.report.html_pages import Page


@pytest.fixture(scope="module")
def page(circle, sine) -> str:
    return render_report(
        circle, sine, {"seed": 7, "command": "ffgym report <out> & more", "versions": {"numpy": "9.9"}}
    )


def test_page_needs_no_other_resource(page):
    tree = Page(page)
    assert not {"script", "link", "iframe", "object"} & set(tree.tags)
    assert all(value.startswith(("data:", "#")) for _, name, value in tree.attributes if name in ("src", "href"))
    assert "http" not in re.sub(r"base64,[\w+/=]+", "", page)
    assert "url(" not in page
    assert "@import" not in page


def test_pictures_refer_to_nothing_outside_themselves(page):
    pictures = [base64.b64decode(data).decode() for data in re.findall(r"svg\+xml;base64,([\w+/=]+)", page)]
    assert pictures
    for picture in pictures:
        assert "<image" not in picture
        assert all(target.startswith("#") for target in re.findall(r'xlink:href="([^"]*)"', picture))


def test_page_is_well_formed(page):
    assert Page(page).open == []


def test_page_holds_every_figure_with_its_caption(page, circle, sine):
    entries = [*circle_figures(circle), *one_axis_figures(sine)]
    assert Page(page).tags.count("figure") == len(entries)
    for entry in entries:
        assert f'id="{entry.name}"' in page
        assert f"{entry.title}.</b>" in page
        assert f"Thesis: {entry.thesis}." in page
        assert len(entry.caption) > 50


def test_page_shows_every_cell_and_every_finding(page, circle, sine):
    for cell in circle.cells:
        assert f'{cell.rms_mm:.3f} <span class="max">({cell.max_mm:.3f})</span>' in page
    for finding in findings(circle):
        assert re.search(rf'class="l verdict \w+">{finding.verdict}</td>', page)
        assert finding.question in page
        assert finding.text in page
    for result in sine.results:
        assert f"<td>{1e3 * result.motor_rms_rad:.3f}</td>" in page


def test_how_to_read_the_page_comes_before_results(page):
    places = [page.index(words) for words in ("How to read this page", 'class="headline"', "Mean path error")]
    assert places == sorted(places)
    (box,) = re.findall(r'<div class="headline">(.*?)</div>', page)
    assert box.count("<p>") == 1


def test_page_says_where_its_numbers_come_from(page, circle):
    assert circle.fingerprint in page
    assert '<th class="l">seed</th><td class="wrap"><code>7</code>' in page
    assert "ffgym report &lt;out&gt; &amp; more" in page
    assert page.count('<th class="l">numpy</th>') == 1
    assert "<code>9.9</code>" in page


def test_report_is_small_and_replaces_an_old_one(circle, sine, tmp_path):
    path = tmp_path / "report.html"
    path.write_text("old")
    assert write_report(path, circle, sine, {}) == path
    assert path.read_text().startswith("<!doctype html>")
    assert path.stat().st_size < 4e6
    assert [entry.name for entry in tmp_path.iterdir()] == ["report.html"]


def test_a_study_of_one_law_without_published_numbers_has_a_page_too(irb4600, one_axis):
    circle = circle_study(irb4600, laws=[NoCompensation()], positions=["p2"], radii=[0.002], speeds=[0.1])
    sine = one_axis_study(one_axis, laws=[NoCompensation()], frequencies=[2.0])
    page = render_report(circle, sine, {})
    assert Page(page).tags.count("figure") == len(circle_figures(circle)) + 2
    assert 'id="ratios"' not in page


def test_an_unwritable_path_is_one_error_that_names_it(circle, sine, tmp_path):
    with pytest.raises(FFGymError, match=r"nowhere/report\.html: the folder .* does not exist") as caught:
        write_report(tmp_path / "nowhere" / "report.html", circle, sine, {})
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("missing", ["matplotlib", "jinja2"])
def test_missing_packages_are_explained(circle, sine, tmp_path, monkeypatch, missing):
    monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(FFGymError, match=rf"needs {missing}; pip install 'ffgym\[report\]'"):
        write_report(tmp_path / "report.html", circle, sine, {})


def test_lists_in_the_provenance_are_read_as_words(circle, sine):
    lines = provenance(circle, sine, {"config": {"positions": ["p1", "p2"], "none_given": ()}})
    assert (lines["positions"], lines["none given"]) == ("p1, p2", "none")
