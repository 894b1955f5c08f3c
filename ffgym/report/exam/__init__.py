"""The exam of the diagnosis as a picture."""

from ffgym.report.exam.outcomes_plot import outcomes_figure as outcomes_figure
