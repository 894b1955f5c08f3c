"""Tables, figures and a page of the studies; the only package of ffgym that draws."""

from ffgym.report._matplotlib import check_figure as check_figure
from ffgym.report._matplotlib import save_figure as save_figure
from ffgym.report.circles.comparison import SpeedTable as SpeedTable
from ffgym.report.circles.comparison import circle_tables as circle_tables
from ffgym.report.circles.figures import ReportFigure as ReportFigure
from ffgym.report.circles.figures import circle_figures as circle_figures
from ffgym.report.circles.figures import one_axis_figures as one_axis_figures
from ffgym.report.circles.findings import Finding as Finding
from ffgym.report.circles.findings import findings as findings
from ffgym.report.circles.headline import headline as headline
from ffgym.report.circles.page import render_report as render_report
from ffgym.report.circles.page import write_report as write_report
from ffgym.report.circles.tables import format_one_axis as format_one_axis
from ffgym.report.circles.tables import format_text as format_text
from ffgym.report.laws import law_styles as law_styles
from ffgym.report.motion.page import render_motion_page as render_motion_page
from ffgym.report.motion.tables import format_motion as format_motion
