"""Means of residuals over what they may depend on."""

from ffgym.report.diagnosis import profiles_plot


def test_a_joint_of_which_too_few_rows_count_has_no_picture(monkeypatch):
    monkeypatch.setattr(profiles_plot, "profiles", lambda *arguments: {})
    assert profiles_plot.profiles_figure({"the log": None}, "torque", 0, 0) is None
