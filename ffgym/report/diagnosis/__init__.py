"""What a diagnosis found: pictures, a page, text."""

from ffgym.report.diagnosis.diagnosis_report import DiagnosisReport as DiagnosisReport
from ffgym.report.diagnosis.page import render_diagnosis_page as render_diagnosis_page
from ffgym.report.diagnosis.text import format_closed_loop as format_closed_loop
from ffgym.report.diagnosis.text import format_diagnosis as format_diagnosis
from ffgym.report.diagnosis.text import format_findings as format_findings
from ffgym.report.diagnosis.text import format_held_out as format_held_out
