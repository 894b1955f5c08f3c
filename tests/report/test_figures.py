import subprocess
import sys

import numpy as np
import pytest
from matplotlib import rcParams
from matplotlib.colors import to_hex

from ffgym.core.errors import FFGymError
from ffgym.recordings.metrics import motor_error, motor_error_rms, relative_rms
from ffgym.report import circle_figures, one_axis_figures, save_figure
from ffgym.report.circles.errors_plot import motor_error_figure, ratios_figure
from ffgym.report.circles.friction_plot import joint_loops_figure, one_axis_figure
from ffgym.report.circles.paths_plot import choose_magnification, flat_circles, paths_figure
from ffgym.report.figure import encode_figure, house_style, new_figure
from ffgym.report.laws import law_styles


def lines_of(axes) -> dict:
    return {line.get_label(): line for line in axes.get_lines()}


def test_drawn_deviation_is_the_scored_one(circle):
    for (law, position, speed), recording in circle.recordings.items():
        [cell] = circle.select(agent=law, position=position, speed_mm_s=round(speed * 1e3, 6))
        [flat] = flat_circles(recording)
        assert np.abs(flat.outward).max() == pytest.approx(cell.max_mm)
        assert np.sqrt(np.mean(flat.outward**2)) == pytest.approx(cell.rms_mm)


def test_magnification_enlarges_the_deviation_and_leaves_the_circle(circle):
    [flat] = flat_circles(next(iter(circle.recordings.values())))
    for factor in (1, 7):
        distance = np.linalg.norm(flat.path(factor) - flat.centre, axis=1)
        np.testing.assert_allclose(distance, flat.radius + factor * flat.outward, rtol=1e-12)


def test_paths_at_true_scale_run_where_the_tool_was(circle):
    recording = next(iter(circle.recordings.values()))
    rows = recording.mask(kind="circle")
    [flat] = flat_circles(recording)
    level = recording.vector("tcp.position")[rows, :2] * 1e3  # the circles of the test are level
    np.testing.assert_allclose(np.diff(flat.path(1), axis=0), np.diff(level, axis=0), atol=1e-4)


def test_no_enlarged_circle_passes_its_own_centre(circle):
    for speed in (0.04, 0.1):
        factor = choose_magnification(circle, speed)
        flats = [
            flat for key, recording in circle.recordings.items() if key[2] == speed for flat in flat_circles(recording)
        ]
        assert factor == 1 or all((flat.radius + factor * flat.outward).min() > 0 for flat in flats)


def test_paths_grid_has_a_row_per_speed_and_says_its_magnification(circle):
    titles = [axes.get_title() for axes in paths_figure(circle).figure.axes]
    for title, speed in zip(titles, (0.04, 0.1), strict=True):
        factor = choose_magnification(circle, speed)
        assert title == f"p1, {speed * 1e3:g} mm/s, " + ("true scale" if factor == 1 else f"error × {factor:g}")


def test_bars_are_as_high_as_the_motor_errors(circle):
    for axes, speed in zip(motor_error_figure(circle).figure.axes, (0.04, 0.1), strict=True):
        for bars, law in zip(axes.containers, law_styles(["none", "lugre_static", "lugre_dynamic"]), strict=True):
            expected = motor_error_rms(circle.recordings[law, "p1", speed]) * 1e3
            np.testing.assert_allclose([bar.get_height() for bar in bars], expected)
        assert [label.get_text() for label in axes.get_xticklabels()] == list(circle.robot.joints)


def test_friction_loops_show_friction_and_added_torque_of_the_same_run(circle):
    panel = joint_loops_figure(circle.only(speeds=[0.1])).figure.axes[2]  # second joint, first law
    recording = circle.recordings["lugre_static", "p1", 0.1]
    moving = ~recording.mask(kind="standstill")
    drawn = {label: line.get_ydata() for label, line in lines_of(panel).items()}
    for label, family in (
        ("friction of the robot", "friction.effort"),
        ("added by static LuGre", "compensation.effort"),
    ):
        y = drawn[label]
        np.testing.assert_array_equal(y[~np.isnan(y)], recording.joint_array(family)[moving, 1])


def test_friction_loops_beside_a_law_show_both_laws_and_no_friction(circle):
    loops = joint_loops_figure(circle, beside="lugre_dynamic")
    assert len(loops.figure.axes) == 6  # the other law that compensates, six joints
    for axes in loops.figure.axes:
        assert lines_of(axes).keys() == {"added by dynamic LuGre", "added by static LuGre"}
    where = (circle.cells[0].position, 0.04)
    recordings = [circle.recordings[law, *where] for law in ("lugre_static", "lugre_dynamic")]
    moving = ~recordings[0].mask(kind="standstill")
    added, others = (recording.joint_array("compensation.effort")[moving] for recording in recordings)
    share = relative_rms(added - others, others)[2]
    assert f"{circle.robot.joints[2]} {share:.1%}" in loops.caption


def test_sine_figure_shows_before_and_after_in_each_column(sine):
    axes = one_axis_figure(sine, 3.0).figure.axes
    assert len(axes) == 6
    drawn = lines_of(axes[3])  # error, second column
    assert list(drawn) == ["no compensation", "dynamic LuGre"]
    recording = sine.recordings["lugre_dynamic", 3.0]
    rows = (recording.t >= 1.0) & (recording.t <= 3.0)
    np.testing.assert_allclose(drawn["dynamic LuGre"].get_ydata(), motor_error(recording)[rows, 0] * 1e3)


def test_ratio_dots_are_simulated_over_published(circle):
    [axes] = ratios_figure(circle).figure.axes
    [cell] = circle.select(agent="none", speed_mm_s=40.0)
    assert lines_of(axes)["no compensation"].get_ydata() == pytest.approx([cell.rms_mm / 0.187])
    assert axes.get_yscale() == "log"


def test_ratio_figure_without_published_numbers_is_refused(circle, made_up):
    study = made_up(laws=("none",), rename=lambda law: "unheard_of")
    with pytest.raises(FFGymError, match="No published path error"):
        ratios_figure(study)


def test_a_legend_is_no_wider_than_its_figure(circle):
    slow = circle.only(speeds=[0.04])
    for figure in (paths_figure(slow).figure, motor_error_figure(slow).figure):
        figure.draw_without_rendering()
        [legend] = figure.legends
        box = legend.get_window_extent()
        assert 0 <= box.x0 < box.x1 <= figure.bbox.width


def test_a_law_has_one_colour_in_all_figures(circle, sine):
    expected = law_styles(["lugre_static"])["lugre_static"].colour
    for entry in [*circle_figures(circle), *one_axis_figures(sine)]:
        handles = entry.figure.legends[0].legend_handles
        labels = [text.get_text() for text in entry.figure.legends[0].get_texts()]
        [handle] = [handle for handle, label in zip(handles, labels, strict=True) if "static LuGre" in label]
        colour = handle.get_facecolor() if hasattr(handle, "get_facecolor") else handle.get_color()
        assert to_hex(colour).upper() == expected


def test_unknown_laws_get_styles_of_their_own():
    styles = law_styles(["none", "my_agent", "other", "third"])
    assert styles["my_agent"].label == "my agent"
    assert len({style.colour for style in styles.values()}) == 4


def test_equal_studies_give_equal_pictures(circle):
    first, second = (encode_figure(motor_error_figure(circle).figure) for _ in range(2))
    assert first == second


def test_figures_leave_the_settings_of_the_user_alone(circle):
    before = dict(rcParams)
    rcParams["font.size"] = 23.0
    try:
        encode_figure(motor_error_figure(circle).figure)
        assert rcParams["font.size"] == 23.0
    finally:
        rcParams["font.size"] = before["font.size"]
    assert dict(rcParams) == before


def test_importing_the_report_loads_neither_matplotlib_nor_jinja():
    code = "import sys, ffgym.report; print(sorted({'matplotlib', 'jinja2'} & set(sys.modules)))"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"


def test_drawing_does_not_load_pyplot():
    code = """
import sys
from ffgym.report.figure import encode_figure
from ffgym.report.circles.friction_plot import one_axis_figure
from ffgym.robot import load_robot
from ffgym.studies import one_axis_study
study = one_axis_study(load_robot("one_axis"), frequencies=[3.0])
picture = encode_figure(one_axis_figure(study, 3.0).figure, "png")
print(picture[:4] == b"\\x89PNG", "matplotlib.pyplot" in sys.modules)
"""
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.split() == ["True", "False"]


def test_missing_matplotlib_is_explained(circle, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(FFGymError, match=r"needs matplotlib; pip install 'ffgym\[report\]'"):
        motor_error_figure(circle)


def test_save_figure_writes_by_suffix_and_refuses_others(circle, tmp_path):
    figure = motor_error_figure(circle).figure
    assert save_figure(figure, tmp_path / "a.svg").read_bytes().startswith(b"<?xml")
    with pytest.raises(FFGymError, match="figure format 'bmp'"):
        save_figure(figure, tmp_path / "a.bmp")


def drawn(n_points):
    with house_style():
        figure = new_figure(4.0, 3.0)
        axes = figure.subplots()
        axes.plot(np.random.default_rng(0).normal(size=n_points))
    return encode_figure(figure)


def test_a_line_of_few_points_is_a_vector():
    assert b"<image" not in drawn(5_000)


def test_lines_of_very_many_points_are_pixels_between_vector_axes():
    picture = drawn(300_000)
    assert b"<image" in picture
    assert b"<text" in picture or b"<use" in picture
    assert len(picture) < 1_000_000
