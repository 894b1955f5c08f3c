"""Folders for use without ffgym: a robot's model, a motion on it as set-points and reference, and its recording."""

from ffgym.export.bundle import export_model as export_model
from ffgym.export.bundle import export_run as export_run
from ffgym.export.reference_table import ReferenceForm as ReferenceForm
from ffgym.export.reference_table import reference_table as reference_table
