from .bundle import export_model as export_model
from .bundle import export_run as export_run
from .model import ReferenceForm as ReferenceForm
from .model import reference_table as reference_table
