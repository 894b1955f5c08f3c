import numpy as np
import pytest

from ffgym.core.errors import FFGymError
from ffgym.report.learning_plots import LearningCurves, TrialCurves, learning_figure, trials_figure


@pytest.fixture
def curves() -> LearningCurves:
    """Two rates over three iterations, made up."""
    return LearningCurves(
        title="j1, made up",
        rates=np.array([0.5, 2.5]),
        predicted=np.array([[4.0, 2.0, 1.0, 0.5], [4.0, 6.0, 9.0, 13.5]]),
        simulated=np.array([[8.0, 4.2, 2.1, 1.0], [8.0, 12.5, 18.0, 30.0]]),
        eigenvalues=np.array([0.5 + 0.2j, 0.5 - 0.2j, 0.9]),
        largest_rate=2.0 / 0.9,
    )


def test_lines_are_predictions_and_dots_are_simulations_over_their_first_value(curves):
    left = learning_figure([curves]).figure.axes[0]
    drawn = left.get_lines()
    for k in range(2):
        line, dots = drawn[2 * k : 2 * k + 2]
        np.testing.assert_allclose(line.get_ydata(), curves.predicted[k] / curves.predicted[k, 0])
        np.testing.assert_allclose(dots.get_ydata(), curves.simulated[k] / curves.simulated[k, 0])
        assert (dots.get_linestyle(), dots.get_marker()) == ("None", "o")
        assert line.get_color() == dots.get_color()


def test_the_circle_of_the_largest_rate_passes_through_zero_and_the_fastest_eigenvalue(curves):
    right = learning_figure([curves]).figure.axes[1]
    limit, shown, eigenvalues = right.get_lines()
    for circle, rate in ((limit, curves.largest_rate), (shown, 2.5)):
        x, y = circle.get_xdata(), circle.get_ydata()
        np.testing.assert_allclose(np.hypot(x - 1 / rate, y), 1 / rate)
    assert np.hypot(limit.get_xdata() - 0.9, limit.get_ydata()).min() < 1e-9
    np.testing.assert_allclose(eigenvalues.get_xdata(), curves.eigenvalues.real)
    np.testing.assert_allclose(eigenvalues.get_ydata(), curves.eigenvalues.imag)


def test_every_joint_has_a_row_and_its_limit_stands_in_the_caption(curves):
    learning = learning_figure([curves, curves])
    assert len(learning.figure.axes) == 4
    assert "j1, made up: 2.22" in learning.caption


def test_rates_out_of_order_and_missing_curves_are_refused(curves):
    values = vars(curves)
    with pytest.raises(FFGymError, match="must ascend"):
        LearningCurves(**(values | {"rates": np.array([2.5, 0.5])}))
    with pytest.raises(FFGymError, match="simulated has shape"):
        LearningCurves(**(values | {"simulated": curves.simulated[:1]}))


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
