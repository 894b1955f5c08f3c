"""Things that go wrong with logs, by where: importing this package lists all of them in DEFECTS."""

from tests.logs.quality.defects import clock_faults, column_faults, description_faults, refused, value_faults
from tests.logs.quality.defects.defect import DEFECTS as DEFECTS
from tests.logs.quality.defects.defect import Damaged as Damaged
from tests.logs.quality.defects.defect import Defect as Defect

__all__ = [
    "DEFECTS",
    "Damaged",
    "Defect",
    "clock_faults",
    "column_faults",
    "description_faults",
    "refused",
    "value_faults",
]
