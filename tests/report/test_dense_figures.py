"""Pages stay small enough to be sent, however many samples their figures show."""

import numpy as np

from ffgym.report.figure import encode_figure, house_style, new_figure


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
