"""What a diagnosis writes and reads beside logs: its result, and tables of published errors."""

from dataclasses import replace
from pathlib import Path

from ffgym.core.typed_json import from_json
from ffgym.diagnosis.diagnosis_file import parse_diagnosis, read_diagnosis, write_diagnosis
from ffgym.diagnosis.result import Diagnosis, Level
from ffgym.diagnosis.tables.table_file import load_table
from scripts.fuzz.reader import Reader
from scripts.fuzz.readers.samples import sample_of

_HEAD = """
title = "small"
source = "measured"
robot = "two_link"
rows = "table.csv"
alike = [["p1", "p2"]]
"""
_ROWS = """table,use,motion,position,speed_mm_s,radius_mm,law,statistic,value_mm
small,fitted,,p1,10,1,none,rms,0.1
small,fitted,,p2,10,1,none,rms,0.12
small,held_out,,p1,40,3,lugre_static,max,0.3
"""


def _diagnosis(folder: Path) -> Path:
    found: Diagnosis = from_json(Diagnosis, sample_of(Diagnosis), "diagnosis")
    level = Level(channel="torque", component="j1", unit="N m", measured=0.5, noise_floor=0.01, before=0.02, after=0.01)
    write_diagnosis(folder / "diagnosis.json", replace(found, levels=(level, replace(level, component="j2"))))
    return folder / "diagnosis.json"


def _table(folder: Path) -> Path:
    (folder / "table.toml").write_text(_HEAD.strip() + "\n", encoding="utf-8")
    (folder / "table.csv").write_text(_ROWS, encoding="utf-8")
    return folder / "table.toml"


READERS = (
    Reader(
        name="diagnosis", use=read_diagnosis, makes=(_diagnosis,), covers=(read_diagnosis, parse_diagnosis), share=25
    ),
    Reader(name="error_table", use=load_table, makes=(_table,), covers=(load_table,), share=20),
)
