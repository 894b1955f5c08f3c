"""What identifications found: tables, pictures and a page."""

from ffgym.report.identification.friction_report import FrictionReport as FrictionReport
from ffgym.report.identification.loops_plot import friction_loops_figure as friction_loops_figure
from ffgym.report.identification.loops_plot import friction_over_time_figure as friction_over_time_figure
from ffgym.report.identification.page import render_friction_page as render_friction_page
from ffgym.report.identification.rigid_body_page import render_rigid_body_page as render_rigid_body_page
from ffgym.report.identification.rigid_body_report import RigidBodyReport as RigidBodyReport
from ffgym.report.identification.rigid_body_report import rigid_body_numbers as rigid_body_numbers
from ffgym.report.identification.rigid_body_text import format_rigid_body as format_rigid_body
from ffgym.report.identification.stribeck_plot import stribeck_figure as stribeck_figure
from ffgym.report.identification.text import format_friction as format_friction
