from .diagnosis_report import DiagnosisReport as DiagnosisReport
from .page import render_diagnosis_page as render_diagnosis_page
from .text import format_closed_loop as format_closed_loop
from .text import format_diagnosis as format_diagnosis
from .text import format_findings as format_findings
from .text import format_held_out as format_held_out
