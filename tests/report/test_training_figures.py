"""Figures of learning: mean squares over iterations, basis functions, and what the feedback does."""

import numpy as np

from scripts.thesis.network_plots import (
    basis_figure,
    feedback_over_speed_figure,
    feedback_parts_figure,
    training_caption,
    training_figure,
)

JOINTS = ("j1", "j2")


LEFT = {"a network": {"error": np.array([[1, 1], [0.5, 0.5], [0.25, 0.05]]), "signal": np.array([[1, 1], [0.5, 0.75]])}}


def test_mean_squares_are_drawn_over_iterations():
    top, bottom = training_figure(LEFT, JOINTS).axes
    np.testing.assert_allclose(top.get_lines()[0].get_ydata(), [1.0, 0.5, 0.25])
    np.testing.assert_allclose(bottom.get_lines()[1].get_ydata(), [1.0, 0.75])
    assert [line.get_label() for line in top.get_lines()] == list(JOINTS)


def test_a_caption_says_what_is_left():
    assert "a network: j1 0.25 and 0.5, j2 0.05 and 0.75" in training_caption(LEFT, JOINTS)


def test_the_close_up_of_a_basis_shows_the_same_functions_nearer():
    speeds = np.linspace(-20, 20, 401)
    values = np.stack([np.clip(1 - np.abs(speeds - c), 0, 1) for c in (-1, 0, 1)], axis=1)
    whole, near = basis_figure(speeds, values, close_up=1.0).axes
    assert whole.get_xlim() == (-20, 20)
    assert near.get_xlim() == (-1, 1)
    for axes in (whole, near):
        np.testing.assert_array_equal([line.get_ydata() for line in axes.get_lines()], values.T)


def test_feedback_over_speed_leaves_standstill_out(circle):
    recording = circle.recordings["none", "p1", 0.1]
    panels = feedback_over_speed_figure(recording).axes
    moving = ~recording.mask(kind="standstill")
    assert len(panels) == 6
    [line] = panels[2].get_lines()
    drawn = ~np.isnan(line.get_xdata())
    np.testing.assert_array_equal(drawn, moving)
    np.testing.assert_array_equal(line.get_ydata(), recording.joint_array("feedback.effort")[:, 2])


def test_feedback_on_one_axis_has_one_panel(sine):
    panels = feedback_over_speed_figure(next(iter(sine.recordings.values()))).axes
    assert [axes.get_visible() for axes in panels] == [True, False, False]


def test_feedback_is_drawn_with_and_without_its_integral_part(circle):
    recording = circle.recordings["none", "p1", 0.1]
    whole, rest = feedback_parts_figure(recording, joint=1).axes[0].get_lines()
    integral = recording.joint_array("feedback.integral")[:, 1]
    np.testing.assert_allclose(whole.get_ydata() - rest.get_ydata(), integral, atol=1e-12)
