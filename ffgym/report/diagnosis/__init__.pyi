from .diagnosis_report import DiagnosisReport as DiagnosisReport
from .page import render_diagnosis_page as render_diagnosis_page
from .table_words import format_table_diagnosis as format_table_diagnosis
from .words import compare_levels as compare_levels
from .words import format_diagnosis as format_diagnosis
from .words import format_findings as format_findings
from .words import simulation_note as simulation_note
