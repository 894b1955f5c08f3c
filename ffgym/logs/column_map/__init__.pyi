from .column import Column as Column
from .column_map import ColumnMap as ColumnMap
from .load import builtin_columns as builtin_columns
from .load import load_columns as load_columns
from .load import parse_columns as parse_columns
