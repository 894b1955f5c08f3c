"""The page of a diagnosis: everything that was found, for every verdict, in one file."""

import base64
import re
from dataclasses import replace
from datetime import UTC, datetime
from types import SimpleNamespace

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.diagnosis.held_out import LoopLevel
from ffgym.diagnosis.result import Diagnosis, Size
from ffgym.effects import EFFECTS
from ffgym.report.diagnosis import DiagnosisReport, evidence, format_diagnosis, render_diagnosis_page
from ffgym.report.diagnosis import words as diagnosis_words
from ffgym.report.diagnosis.words import VERDICTS, _size_words, causes_table, plain_size, rivals_of, write_digits
from ffgym.robot import load_robot
from tests.diagnosis.residual_samples import made_up
from tests.diagnosis.result_samples import full_diagnosis
from tests.report.html_pages import Page


def lost_with_load(state, travel):
    """Load friction of joint 2."""
    lost = np.zeros_like(state.motor_speed)
    lost[:, 1] = 0.1 * np.sign(state.motor_speed[:, 1]) * np.abs(state.load_at_motor[:, 1])
    return lost


@pytest.fixture(scope="module")
def report(irb4600):
    channels = ("torque", "tool")
    before = made_up(irb4600, {"torque": lost_with_load}, channels=channels)
    after = made_up(irb4600, {}, channels=channels, seed=1)
    loop = LoopLevel(quantity="tool", component="x", unit="m", measured=5e-5, before=2.345e-5, after=1.2e-6)
    commands = ("ffgym record irb4600_60_205 found/next.toml --out more_logs",)
    full = full_diagnosis()
    full = replace(full, provenance=full.provenance | {"inputs": ["logs/a.npz sha256:0123"]})
    return DiagnosisReport(diagnosis=full, before=before, after=after, closed_loop=(loop,), commands=commands)


@pytest.fixture(scope="module")
def page(report):
    return render_diagnosis_page(report)


def without_time(page):
    """The page without the time at which it was written, which is on it once."""
    shorter, count = re.subn(r"\d{4}-\d\d-\d\d \d\d:\d\d UTC", "", page)
    assert count == 1
    return shorter


def text_of(page):
    return re.sub(r"<[^>]+>", "", re.sub(r"base64,[\w+/=]+", "", page))


def test_the_page_is_whole_and_needs_nothing_else(page):
    tree = Page(page)
    assert tree.open == []
    assert not {"script", "link", "iframe", "object"} & set(tree.tags)
    assert all(value.startswith("data:") for _, name, value in tree.attributes if name in ("src", "href"))
    assert "http" not in re.sub(r"base64,[\w+/=]+", "", page)
    assert "<image" not in "".join(base64.b64decode(data).decode() for data in re.findall(r"base64,([\w+/=]+)", page))


def test_the_page_tells_everything_that_was_found(page):
    diagnosis, text = full_diagnosis(), text_of(page)
    told = [diagnosis.sentence, diagnosis.verdict, diagnosis.robot, *diagnosis.motions, *diagnosis.quality]
    told += [rival.reason for rival in diagnosis.rivals] + [pattern.message for pattern in diagnosis.patterns]
    told += [one.reason for one in (*diagnosis.not_excited, *diagnosis.not_judgeable)]
    told += ["share = 0.021 (0.019 to 0.024)", "ffgym record irb4600_60_205 found/next.toml", "protocol = &#34;holds"]
    row = "j2load-dependent friction2.1 % of the torque that the gearbox carries1.9 to 2.4 %100 % (torque)"
    told += [f"{row}tied: payload; lost: torque constant and saturation on j2"]
    told += ["machinepayloadnot adopted––ties with load-dependent friction"]
    told += [datetime.now(UTC).strftime("%Y-%m-%d"), "logs/a.npz sha256:0123", "motions that were left out of the fit"]
    told += ["µm5023.41.2"]
    for words in told:
        assert words in text


def test_how_to_read_the_page_comes_first_then_the_verdict_then_the_table_of_causes(page):
    places = [
        page.index(words) for words in ("How to read this page", "<b>ambiguous</b> means", "AMBIGUOUS", 'id="causes"')
    ]
    assert places == sorted(places)


def test_pictures_are_numbered_and_begin_with_the_joint_that_is_blamed(page):
    figures = re.findall(r'<figure id="([\w-]+)">', page)
    assert len(set(figures)) == len(figures)
    assert re.findall(r"<b>(Figure \d+)\.", page) == [f"Figure {i + 1}" for i in range(len(figures))]
    assert next(name for name in figures if name.startswith("depends")) == "depends-torque-2"
    assert {"regimes-torque", "motions", "loops-2", "tool", "candidates", "levels"} <= set(figures)


@pytest.mark.parametrize("verdict", VERDICTS)
def test_every_verdict_has_a_page_and_a_text_without_anything_but_a_sentence(verdict):
    diagnosis = Diagnosis(verdict=verdict, sentence="So it is.", robot="one_axis", motions=("a",))
    page = render_diagnosis_page(DiagnosisReport(diagnosis=diagnosis))
    assert Page(page).open == []
    assert VERDICTS[verdict] in text_of(page)
    assert format_diagnosis(diagnosis) == f"{verdict}: So it is."


def test_a_log_in_which_nothing_stands_out_shows_its_worst_joint(irb4600):
    diagnosis = Diagnosis(verdict="none", sentence="Nothing.", robot="irb4600_60_205", motions=("a",))
    report = DiagnosisReport(diagnosis=diagnosis, before=made_up(irb4600, {}))
    assert len(report.places) == 1
    page = render_diagnosis_page(report)
    assert 'id="regimes-torque"' in page
    assert "extended model</th>" not in page


def test_one_axis_without_a_tool_has_a_page_and_the_same_each_time(one_axis):
    fault = {"servo": lambda state, travel: 0.1 * np.sign(state.motor_speed)}
    diagnosis = Diagnosis(verdict="unknown", sentence="?", robot="one_axis", motions=("a",))
    residual = made_up(one_axis, fault, channels=("torque", "servo"))
    page = render_diagnosis_page(DiagnosisReport(diagnosis=diagnosis, before=residual))
    assert 'id="depends-servo-1"' in page
    again = render_diagnosis_page(DiagnosisReport(diagnosis=diagnosis, before=residual))
    assert without_time(again) == without_time(page)


def test_a_log_without_valid_rows_has_a_page(irb4600):
    residual = made_up(irb4600, {}, channels=("torque", "tool"))
    for motion in residual.motions:
        motion.valid[:] = False
    diagnosis = Diagnosis(verdict="insufficient", sentence="Too short.", robot="r", motions=("a",))
    report = DiagnosisReport(diagnosis=diagnosis, before=residual)
    assert report.places == ()
    assert "Too short." in render_diagnosis_page(report)


def test_residuals_before_and_after_are_of_the_same_motions(irb4600):
    before, after = made_up(irb4600, {}), made_up(irb4600, {})
    with pytest.raises(FFGymError, match="same motions"):
        DiagnosisReport(diagnosis=full_diagnosis(), before=before, after=replace(after, motions=after.motions[:2]))


def test_the_text_fits_a_terminal_and_names_ties_sizes_and_what_to_record():
    text = format_diagnosis(full_diagnosis())
    assert max(map(len, text.splitlines())) <= 120
    for words in (
        "ambiguous: ",
        "2.1 % of the torque that the gearbox carries",
        "1.9 to 2.4 %",
        "cannot be excluded: payload",
        "record next: holds",
    ):
        assert words in text
    assert "torque constant" not in text
    assert re.search(r"torque  j2 +\| N m +0\.6 +0\.012 +0\.09 +0\.013 +small", text)


def test_rivals_stand_with_the_cause_whose_joint_they_name():
    full = full_diagnosis()
    other = replace(full.causes[0], joint="j3")
    rivals = (replace(full.rivals[0], against="load_friction on j3"), replace(full.rivals[1], against="load_friction"))
    diagnosis = replace(full, causes=(*full.causes, other), rivals=rivals)
    assert [rival.effect for rival in rivals_of(diagnosis, full.causes[0])] == ["torque_constant"]
    assert [rival.effect for rival in rivals_of(diagnosis, other)] == ["payload", "torque_constant"]


def test_a_sliding_joint_is_told_in_newtons_metres_and_kilograms():
    """Behind the screw, and not as torque of its motor: 2513 rad of the motor per metre."""
    robot = load_robot("ball_screw")
    ratio = float(robot.drive.gear_ratio[0])

    def size(name, value, unit):
        return Size(name=name, value=value, unit=unit, interval=(0.9 * value, 1.1 * value))

    sizes = (size("amplitude", 2e-3, "N m"), size("inertia", 1e-5, "kg m^2"), size("gap", 0.5, "rad"))
    full = full_diagnosis()
    cause = replace(full.causes[0], effect="cogging", joint="x", parameters=sizes)
    level = replace(
        full.levels[0],
        channel="torque",
        component="x",
        unit="N m",
        before=1e-3,
        after=4e-4,
        noise_floor=3e-4,
        measured=2e-3,
    )
    diagnosis = replace(full, causes=(cause,), levels=(level,), rivals=())
    text = format_diagnosis(diagnosis, robot)
    flat = " ".join(text.split())
    assert f"{2e-3 * ratio:.3g} N amplitude, motor side {1.8e-3 * ratio:.3g} to {2.2e-3 * ratio:.3g} N" in flat
    assert f"{1e-5 * ratio**2:.3g} kg inertia" in flat
    assert f"{1e3 * 0.5 / ratio:.3g} mm gap" in flat
    assert re.search(
        rf"torque +x +\| N +{2e-3 * ratio:.3g} +{3e-4 * ratio:.3g} +{1e-3 * ratio:.3g} +{4e-4 * ratio:.3g}", text
    )
    before = made_up(robot, {"torque": lambda state, travel: 1e-4 * np.sign(state.motor_speed)})
    page = render_diagnosis_page(DiagnosisReport(diagnosis=diagnosis, before=before, after=before))
    told = text_of(page)
    assert f"amplitude = {2e-3 * ratio:.3g} N " in told
    drawn = "".join(base64.b64decode(data).decode() for data in re.findall(r"base64,([\w+/=]+)", page))
    assert "friction force [N]" in drawn
    assert "residual [N]" in drawn
    assert "[N m]" not in drawn.replace("load on the motor [N m]", "")
    assert format_diagnosis(diagnosis, load_robot("one_axis")) == format_diagnosis(diagnosis)


def test_what_calibration_allows_for_is_not_called_small_nor_unexplained():
    diagnosis = full_diagnosis()
    level = next(level for level in diagnosis.levels if level.is_small)
    large = replace(level, after=level.measured)
    assert diagnosis.tell_left(level) == "small"
    assert diagnosis.tell_left(large) == "not small"
    assert replace(diagnosis, verdict="none").tell_left(large) == "allowed for"
    text = format_diagnosis(replace(diagnosis, verdict="none", levels=(level, large)))
    assert "allowed for" in text
    assert "NOT SMALL" not in text


def test_a_joint_of_which_too_few_rows_count_has_no_picture_of_what_its_residual_depends_on(monkeypatch):
    monkeypatch.setattr(evidence, "compute_profiles", lambda *arguments: {})
    assert evidence.profiles_figure({"the log": None}, "torque", 0, 0) is None


def test_every_size_of_every_effect_has_a_plain_meaning_with_its_unit():
    """A share is a percentage; a number that is no share keeps its unit; a table of texts holds no other names."""
    for effect, kind in EFFECTS.items():
        sizes = {name: p for name, p in kind.parameters().items() if p.role in ("size", "cycles")}
        assert set(_size_words()[effect]) == set(sizes)
        for name, p in sizes.items():
            text, interval = plain_size(effect, Size(name=name, value=0.25, unit=p.unit, interval=(0.2, 0.3)))
            assert ("25 %" in text) == ("{percent}" in _size_words()[effect][name])
            assert p.unit == "1" or "%" not in text
            assert " to " in interval
    assert set(_size_words()) == set(EFFECTS)
    text, _ = plain_size("foreign", Size(name="pull.x", value=2.0, unit="N", interval=(1.0, 3.0)))
    assert text == "2 N pull (x)"


@pytest.mark.parametrize(
    ("value", "text"), [(378412.0, "378000"), (9.07e4, "90700"), (0.0118, "0.0118"), (2e-7, "2e-07")]
)
def test_a_large_number_has_three_digits_and_no_exponent(value, text):
    assert write_digits(value) == text


def test_the_table_says_on_which_data_the_share_was_explained():
    full = full_diagnosis()
    same = replace(full, levels=tuple(replace(level, after=level.before) for level in full.levels))
    assert "no motion was left out" in " ".join(format_diagnosis(same).split())
    assert "each half was left out" in " ".join(format_diagnosis(replace(full, motions=("a",))).split())


def test_the_table_names_rivals_and_has_a_row_for_each_effect_that_a_tie_left_out():
    full = full_diagnosis()
    dropped = replace(full.rivals[0], effect="viscous_level", joint="j3", against="payload")
    again = replace(dropped, against="load_friction")
    diagnosis = replace(full, rivals=(*full.rivals, dropped, again))
    on_page = causes_table(diagnosis, on_page=True).rows
    assert on_page[0][-1] == "tied: payload, viscous friction level on j3; lost: torque constant and saturation on j2"
    assert on_page[1:] == (
        ("machine", "payload", "not adopted", "-", "-", "ties with load-dependent friction"),
        ("j3", "viscous friction level", "not adopted", "-", "-", "ties with payload and load-dependent friction"),
    )
    assert format_diagnosis(replace(diagnosis, rivals=(*diagnosis.rivals, again))) == format_diagnosis(diagnosis)
    rows = causes_table(diagnosis).rows
    assert rows[0][-1] == "2 tied, 1 lost"
    assert rows[2][-1] == "ties with payload and 1 more"


def test_an_effect_of_another_package_is_described_by_the_first_sentence_of_its_declaration(monkeypatch):
    meaning = "share a of the Coulomb torque,\n  as in {1, 2}. A second sentence, e.g. on its range."
    declared = SimpleNamespace(parameters=lambda: {"share": SimpleNamespace(meaning=meaning)})
    monkeypatch.setattr(diagnosis_words, "EFFECTS", {"cover_friction": declared})
    text, interval = plain_size("cover_friction", Size(name="share", value=0.01, unit="1/rad", interval=(0.009, 0.011)))
    assert text == "0.01 1/rad share (share a of the Coulomb torque, as in {1, 2})"
    assert interval == "0.009 to 0.011 1/rad"


def test_a_verdict_has_at_most_three_lines_and_ends_at_a_clause():
    patterns = "; ".join(f"the residual of j{k} repeats {k} times per turn of the motor of joint {k}" for k in range(9))
    diagnosis = Diagnosis(verdict="unknown", sentence=f"Depends on: {patterns}.", robot="r", motions=("a",))
    text = format_diagnosis(diagnosis)
    assert len(text.splitlines()) == 3
    assert " ".join(text.split()).endswith("turn of the motor of joint 3, and more that is listed below.")


def test_a_page_whose_commands_record_warns_that_the_logs_are_simulated(report, page):
    """Without such a command there is no warning."""
    warning = "on the model that it is given, not on the machine"
    assert warning in page
    without = DiagnosisReport(diagnosis=report.diagnosis, commands=("ffgym record --list",))
    assert warning not in render_diagnosis_page(without)
