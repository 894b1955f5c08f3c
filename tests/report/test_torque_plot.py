"""Figure and table of predicted beside measured torque."""

import numpy as np
import pytest

from ffgym.report.identification.plots import torque_figure
from ffgym.robot import load_robot
from ffgym.studies.torque_prediction import TorquePrediction
from scripts.tables.recorded import torque_table


@pytest.fixture(scope="module")
def prediction():
    """Shoulder predicted to 1 of 5 N m, elbow exactly; the elbow rests in the first half."""
    measured = np.tile([5.0, 2.0], (100, 1))
    scored = np.ones((100, 2), dtype=bool)
    scored[:50, 1] = False
    wrong = measured.copy()
    wrong[:50, 1] = 100.0  # at rest, not scored
    return TorquePrediction(
        robot=load_robot("two_link"),
        t=0.01 * np.arange(100),
        measured=measured,
        predicted={"description": wrong - [1.0, 0.0], "published friction": wrong},
        scored=scored,
    )


def test_errors_are_over_the_scored_samples_alone(prediction):
    shoulder, elbow = prediction.errors("description")
    assert (shoulder.joint, shoulder.rms_measured, shoulder.rms_error) == ("shoulder", 5.0, 1.0)
    assert (shoulder.max_error, shoulder.mean_error, shoulder.share) == (1.0, 1.0, 0.2)
    assert (elbow.joint, elbow.rms_error) == ("elbow", 0.0)


def test_table_has_a_row_for_each_joint_and_a_column_for_each_prediction(prediction):
    assert torque_table(prediction).splitlines() == [
        "| joint | measured RMS | description | published friction |",
        "|---|---|---|---|",
        "| shoulder | 5.00 | 1.00, 20%, 1.00 | 0.00, 0%, 0.00 |",
        "| elbow | 2.00 | 0.00, 0%, 0.00 | 0.00, 0%, 0.00 |",
    ]


def test_figure_has_a_panel_for_each_joint_with_every_line(prediction):
    pytest.importorskip("matplotlib")
    figure = torque_figure(prediction)
    assert [axes.get_ylabel() for axes in figure.axes] == ["shoulder [N m]", "elbow [N m]"]
    for axes in figure.axes:
        assert [line.get_label() for line in axes.lines] == ["measured", "description", "published friction"]
