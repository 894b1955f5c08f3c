"""The exam of the diagnosis as a picture."""

from scripts.exam.report.outcomes_plot import outcomes_figure as outcomes_figure
