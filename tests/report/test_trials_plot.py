"""The figure of errors over trials."""

import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.report.learning_plots import TrialCurves, trials_figure

ERRORS = np.array([[9.0, 4.0, 6.0], [2.0, 1.0, 4.0]])


def test_each_circle_has_a_line_and_the_median_has_dots():
    (axes,) = trials_figure([TrialCurves(title="10 mm/s", errors=ERRORS)], "error [µm]").axes
    *circles, median = axes.get_lines()
    np.testing.assert_array_equal([line.get_ydata() for line in circles], ERRORS.T)
    np.testing.assert_array_equal(median.get_ydata(), [6.0, 2.0])
    np.testing.assert_array_equal(median.get_xdata(), [1, 2])
    assert (axes.get_title(), axes.get_ylabel(), axes.get_yscale()) == ("10 mm/s", "error [µm]", "log")


def test_other_laws_are_lines_across_and_stand_in_the_legend_once():
    levels = [{"none": 9.0, "elastic": 0.5}, {"none": 7.0}]
    panels = [TrialCurves(title=str(i), errors=ERRORS, levels=level) for i, level in enumerate(levels)]
    figure = trials_figure(panels, "error")
    drawn = {line.get_label(): line.get_ydata()[0] for line in figure.axes[0].get_lines()[-2:]}
    assert drawn == {"no compensation": 9.0, "elastic feed-forward": 0.5}
    (legend,) = figure.legends
    texts = [text.get_text() for text in legend.get_texts()]
    assert sorted(texts) == sorted(["each circle", "median circle", "no compensation", "elastic feed-forward"])


def test_a_long_history_keeps_room_between_its_ticks():
    (axes,) = trials_figure([TrialCurves(title="a", errors=np.ones((40, 1)))], "error").axes
    assert len(axes.get_xticks()) <= 11


def test_nothing_and_what_has_no_logarithm_are_refused():
    with pytest.raises(FFGymError, match="nothing to draw"):
        trials_figure([], "error")
    for errors in (np.zeros((2, 2)), np.ones((0, 2))):
        with pytest.raises(FFGymError, match="errors of 'a' must be at least one trial and circle, all > 0"):
            TrialCurves(title="a", errors=errors)
