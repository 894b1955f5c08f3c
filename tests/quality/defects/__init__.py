"""Things that go wrong with logs, by where: importing this package lists all of them in DEFECTS."""

from tests.quality.defects import clock_faults, column_faults, description_faults, refused, value_faults
from tests.quality.defects.defect import DEFECTS as DEFECTS
from tests.quality.defects.defect import Damaged as Damaged
from tests.quality.defects.defect import Defect as Defect

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
