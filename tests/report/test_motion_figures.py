"""Pictures, tables and page of any motion: what is drawn is what was simulated."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ffgym.control import DynamicLuGreExact, NoCompensation
from ffgym.paths import joint_reference, joint_sine
from ffgym.recordings.metrics import Contour
from ffgym.report import format_motion, render_motion_page
from ffgym.report.figure import POINTS, keep_peaks
from ffgym.report.motion.plot import motion_figures
from ffgym.report.tool_path import SHARE, ToolPath, choose_scale, choose_sights
from ffgym.simulation import SimulatedRig
from ffgym.studies import circle_references, motion_study

ANGLE = np.linspace(0, 2 * np.pi, 400)
CIRCLE = np.stack([np.cos(ANGLE), np.sin(ANGLE), 0 * ANGLE], axis=1)


@pytest.fixture(scope="module")
def study(irb4600, arm):
    reference = next(iter(circle_references(arm, ["p1"], [0.04], [0.005]).values()))
    return motion_study(
        [reference], laws=[NoCompensation(), DynamicLuGreExact(irb4600.friction)], rig=SimulatedRig(arm=arm)
    )


@pytest.fixture(scope="module")
def sine_study(one_axis):
    path = joint_sine([0.5], 2.0, 0.5, dt=one_axis.servo.control_dt, name="sine")
    return motion_study([joint_reference(one_axis, path)], laws=[NoCompensation()])


def only_motion(study):
    (name,) = study.references
    return name


@pytest.mark.parametrize(
    ("axis", "labels"), [(2, ("x [mm]", "y [mm]")), (1, ("x [mm]", "z [mm]")), (0, ("y [mm]", "z [mm]"))]
)
def test_a_flat_path_is_seen_along_its_normal(axis, labels):
    (sight,) = choose_sights(0.05 * np.roll(CIRCLE, axis - 2, axis=1) + [1.0, 2.0, 3.0])
    assert sight.labels == labels


def test_a_tilted_flat_path_is_seen_in_its_own_plane_without_distortion():
    turn = np.linalg.qr(np.array([[1.0, 2.0, 0.5], [0.3, 1.0, 2.0], [1.0, 0.0, 1.0]]))[0]
    path = 0.05 * CIRCLE @ turn.T + [1.0, 0.0, 0.5]
    (sight,) = choose_sights(path)
    flat = sight.flat(path)
    np.testing.assert_allclose(np.linalg.norm(flat - flat.mean(axis=0), axis=1), 50.0, rtol=2e-2)
    np.testing.assert_allclose(np.linalg.norm(np.diff(flat, axis=0), axis=1), 50 * np.diff(ANGLE), rtol=1e-3)


@pytest.mark.parametrize(
    ("size", "labels"),
    [
        ((2, 1, 1), [("x [mm]", "y [mm]"), ("x [mm]", "z [mm]")]),
        ((1, 2, 1), [("x [mm]", "y [mm]"), ("y [mm]", "z [mm]")]),
        ((1, 1, 9), [("x [mm]", "y [mm]"), ("x [mm]", "z [mm]")]),
        ((0, 0, 1), [("x [mm]", "z [mm]"), ("y [mm]", "z [mm]")]),
        ((1, 0, 0), [("x [mm]", "y [mm]"), ("x [mm]", "z [mm]")]),
    ],
    ids=["space", "space, along y", "a tower", "upright line", "level line"],
)
def test_other_paths_are_seen_from_above_and_from_the_longer_side(size, labels):
    t = np.linspace(0, 1, 300)
    curve = t if 0 in size else np.stack([np.sin(7 * t), np.sin(11 * t), np.sin(5 * t)], axis=1).T
    path = 0.1 * (np.broadcast_to(curve, (3, 300)) * np.array(size)[:, None]).T
    assert [sight.labels for sight in choose_sights(path)] == labels


@given(st.floats(1e-9, 1.0))
def test_the_magnification_is_round_and_as_large_as_the_share_allows(largest):
    beside = np.array([[0.0, 0, 0], [3.0, 4, 0]])
    factor = choose_scale([ToolPath(label="law", nearest=beside, error=np.array([[0, 0, largest]] * 2))], beside)
    assert f"{factor:e}"[0] in "125"
    assert float(f"{factor:.0e}") == pytest.approx(factor)
    assert factor == 1 or factor * largest <= SHARE * 5 * (1 + 1e-9)
    assert factor * largest > SHARE * 5 / 2.5 * (1 - 1e-9) or largest > SHARE * 5


def test_a_tool_without_any_deviation_is_drawn_to_scale():
    still = ToolPath(label="law", nearest=np.eye(3)[:2], error=np.zeros((2, 3)))
    assert choose_scale([still], still.nearest) == 1.0


def test_the_drawn_path_leaves_the_reference_by_the_magnified_error(study):
    name = only_motion(study)
    figure = motion_figures(study, name)[0].figure
    (axes,) = figure.axes
    factor = float(axes.get_title().removeprefix("error × "))
    assert factor > 1
    contour = Contour.of(study.recordings["none", name])
    line, dot = axes.lines[:2]
    drawn = (contour.nearest + factor * contour.error)[:, :2] * 1e3
    np.testing.assert_allclose(line.get_xydata()[0], drawn[0], atol=1e-9)
    np.testing.assert_allclose(dot.get_xydata()[0], drawn[contour.distance.argmax()], atol=1e-9)


def test_figures_of_the_tool_are_there_only_where_it_was_seen(study, sine_study):
    assert [f.name for f in motion_figures(study, only_motion(study))] == [
        "path",
        "path-error",
        "motor-errors",
        "torques",
    ]
    assert [f.name for f in motion_figures(sine_study, "sine")] == ["motor-errors", "torques"]


def test_captions_carry_the_numbers_of_the_study(study, sine_study):
    captions = {f.name: f.caption for f in motion_figures(study, only_motion(study))}
    none, lugre = study.results
    assert f"no compensation {none.path[0].max_mm:.3f} mm" in captions["path"]
    contours = [Contour.of(recording) for recording in study.recordings.values()]
    out_of_plane = max(np.abs(contour.error[:, 2]).max() for contour in contours)
    assert f"up to {1e3 * out_of_plane:.3f} mm are out of its plane" in captions["path"]
    assert f"dynamic LuGre {max(s.max_mm for s in lugre.path):.3f} mm" in captions["path-error"]
    assert f"{max(none.torque_use):.0%}" in captions["torques"]
    (only,) = sine_study.results
    assert (
        f"no compensation: j1, {only.motor_rms_rad[0] * 1e3:.2f} mrad" in motion_figures(sine_study, "sine")[0].caption
    )


def test_limits_are_drawn_where_a_torque_comes_near_them(sine_study):
    figures = {f.name: f.figure for f in motion_figures(sine_study, "sine")}
    assert len(figures["torques"].axes[0].lines) == 1
    weak = replace(sine_study.robot, drive=replace(sine_study.robot.drive, peak_torque=0.01 * np.ones(1)))
    (axes,) = {f.name: f.figure for f in motion_figures(replace(sine_study, robot=weak), "sine")}["torques"].axes
    assert [line.get_ydata()[0] for line in axes.lines[1:]] == [-100.0, 100.0]


def test_thinning_keeps_every_peak_and_the_ends():
    rng = np.random.default_rng(0)
    values = rng.normal(size=50_000)
    values[31_415] = 99.0
    kept = keep_peaks(values)
    assert len(kept) <= POINTS + 2
    assert np.all(np.diff(kept) > 0)
    assert {0, 31_415, len(values) - 1, int(values.argmin())} <= set(kept.tolist())
    assert keep_peaks(values[:10]).tolist() == list(range(10))
    gaps = np.where(np.arange(50_000) < 20_000, np.nan, values)
    assert {31_415, int(np.nanargmin(gaps))} <= set(keep_peaks(gaps).tolist())


def test_the_page_stands_alone_and_escapes_what_it_is_told(study):
    page = render_motion_page(study, ["a <b>note</b>"], {"command": "test", "seed": None})
    assert "a &lt;b&gt;note&lt;/b&gt;" in page
    assert not re.search(r"(src|href)=[\"'](?!data:|#)", page)
    assert page.count("data:image/svg+xml") == 4
    none = study.results[0]
    for stretch in none.path:
        assert f"{stretch.rms_mm:.3f}" in page
        assert f'<td class="l">{stretch.label}</td><td>{stretch.start:.2f}</td>' in page
    for joint in study.robot.joints:
        assert f'<td class="l">{joint}</td>' in page
    assert f"{1e3 * none.motor_rms_rad[5]:.2f}" in page


def test_a_robot_without_a_tool_has_a_page_too(sine_study):
    page = render_motion_page(sine_study, [], {})
    assert "Path error" not in page
    assert page.count("data:image/svg+xml") == 2


def test_the_text_has_every_law_and_joint_and_fits_a_terminal(study, sine_study):
    text = format_motion(study)
    assert max(map(len, text.splitlines())) <= 120
    for result in study.results:
        assert f"{result.path[0].rms_mm:.3f}" in text
        for j in range(6):
            assert f"{result.motor_rms_rad[j] * 1e3:.2f} ({result.motor_max_rad[j] * 1e3:.2f})" in text
            assert f"{result.torque_use[j]:.1%}" in text
    assert "path error" in text
    assert "path error" not in format_motion(sine_study)
