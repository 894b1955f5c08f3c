from .bundle import export_model as export_model
from .bundle import export_run as export_run
from .reference_tables import ReferenceForm as ReferenceForm
from .reference_tables import reference_table as reference_table
