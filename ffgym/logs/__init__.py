"""Logs of other tools as recordings: files of many formats, and column maps that say what they hold."""

from ffgym.logs.column_map import ColumnMap as ColumnMap
from ffgym.logs.column_map import builtin_columns as builtin_columns
from ffgym.logs.column_map import load_columns as load_columns
from ffgym.logs.column_map import parse_columns as parse_columns
from ffgym.logs.contents import Contents as Contents
from ffgym.logs.corrected import write_corrected as write_corrected
from ffgym.logs.formats.read import read_contents as read_contents
from ffgym.logs.formats.text_layout import TextLayout as TextLayout
from ffgym.logs.read import read_log as read_log
from ffgym.logs.read import read_logs as read_logs
