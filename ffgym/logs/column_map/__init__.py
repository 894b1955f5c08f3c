"""Column maps: what the arrays of a file mean, as a small TOML file."""

from ffgym.logs.column_map.column import Column as Column
from ffgym.logs.column_map.column_map import ColumnMap as ColumnMap
from ffgym.logs.column_map.load import builtin_columns as builtin_columns
from ffgym.logs.column_map.load import load_columns as load_columns
from ffgym.logs.column_map.load import parse_columns as parse_columns
