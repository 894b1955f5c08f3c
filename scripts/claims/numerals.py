"""Numerals of a text, and rules that say which of them claim nothing.

A numeral is a run of digits with its decimal point and exponent. It claims something of a machine, a result or the
code unless a rule says that it only names: a version, a date, a file, an equation, a robot.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

NUMERAL = re.compile(r"\d(?:\d|[.,](?=\d))*(?:[eE][+-]?\d+)?")

_MONTHS = "January|February|March|April|May|June|July|August|September|October|November|December"
_PARTS = (
    "[Tt]ables?|[Ff]igures?|[Cc]hapters?|[Ss]ections?|[Ee]quations?|[Ee]q\\.|[Aa]nnex|[Pp]ages?|[Rr]ows?|[Rr]ecords?"
)

NAMES: Mapping[str, re.Pattern[str]] = MappingProxyType(
    {
        name: re.compile(pattern, flags=re.MULTILINE)
        for name, pattern in {
            "code": r"``.+?``|`[^`]*`",
            "formula": r"\$`.+?`\$|\$[^$\n]+\$",
            "link": r"\]\([^)\s]*\)|https?://[^\s)]+|\b(?:width|height|src|href)=\"[^\"]*\"",
            "date": rf"\b\d{{4}}-\d\d-\d\d\b|\b(?:\d{{1,2}} )?(?:{_MONTHS}) \d{{4}}\b|\b\d{{1,2}} (?:{_MONTHS})\b"
            r"|\((?:19|20)\d\d\)|\b(?:since|of|in) (?:19|20)\d\d\b",
            "citation": r"arXiv:[\d.]+|\b10\.\d{4,}/[^\s\]]+|\bpp?\. ?\d+(?:[-–]\d+)?|\b\d+ \((?:19|20)\d\d\)"
            r"|\b\d+[-–]\d+(?:,? \((?:19|20)\d\d\)|, (?:19|20)\d\d), \d+[-–]\d+|\bISBN [\d-]+|\b\d+\(\d+\)"
            r"|\b[A-Z][a-z]+,? (?:19|20)\d\d\b|, (?:19|20)\d\d,",
            "version": r"\b(?:Python|MuJoCo|NumPy|SciPy|[Gg]ymnasium|RSI|KSS|RobotWare|PolyScope|FMI|ONNX|opset|"
            r"[Vv]ersions?|format|CSV|MAT|HDF|ROS|EtherCAT|C)(?: version)? v?\d[\d.]*|-v\d\b|\bv\d[\d.]*\b",
            "standard": r"\b(?:ISO|IEC|EN|DIN|VDI|RFC|IEEE|UTF|SHA|Latin|Windows|CP)[- ]?\d[\d-]*",
            "product": r"\b(?:IRB|KR|LBR|FD|AT|PE|IFAC-PapersOnLine) ?\d[\d.]*(?:-\d[\d.]*)?(?:/\d[\d.]*)?",
            "part of a work": rf"\b(?:{_PARTS}) \(?\d+(?:\.\d+)*\)?"
            r"(?:(?:,| to| and|, and| or|-|–) \(?\d+(?:\.\d+)*\)?)*"
            r"|(?<![\d%] )\([3-6]\.\d{1,2}(?:,? (?:and )?[3-6]\.\d{1,2})+\)"
            r"|(?<![\d%] )\([3-6]\.\d{1,2}\)(?:,? (?:and|to) \([3-6]\.\d{1,2}\))?"
            r"|\b\d\.\d\.\d\b|\b[Tt]hesis'? \(?\d\.\d+\)?(?:, \d\.\d+)*"
            r"|\b\d\.\d+(?: and \d\.\d+)? of the thesis",
            "seed": r"\bseeds? \d+(?:(?:,| to| and|, and) \d+)*",
            "case": r"(?<![\d.])\d+(?:\.\d+)?(?:(?:, \d+)*,? (?:and|to|or) \d+)? mm/s\b|\br = \d+ mm\b"
            r"|\b\d+ mm circles?\b|\bcircles of \d+(?:\.\d+)? mm\b|\bfactor (?:of )?1\.5\b"
            r"|\b9[05] %(?= (?:confidence|intervals?)\b)",
            "part of a robot": r"\b(?:[Jj]oints?|[Aa]x[ei]s|[Ll]inks?|[Mm]otors?) \d(?:(?:,| to| and|, and| or) \d)*\b",
            "name": r"(?<![\w.])[A-Za-z_Α-ω](?:\w|-(?=\d))*\d\w*(?:[-.]\d+)*|\b\d[dD]\b|\b\d(?:st|nd|rd|th)\b",
            "number of an item": r"^\s*(?:#+ )?\d+\.(?= )",
            "unit": r"\^[({]?[-+]?\d+[)}]?|\b1/(?=[a-z])|(?<=[a-zµ] )\(1\)",
        }.items()
    }
)
"""Rules by the name of what a numeral is part of; the first that covers it counts."""


@dataclass(frozen=True)
class Numeral:
    """A number as it is printed."""

    start: int
    """Place of its first letter in the text."""
    text: str

    @property
    def end(self) -> int:
        """Place behind its last letter."""
        return self.start + len(self.text)


def find_numerals(text: str) -> Iterator[Numeral]:
    """Yield all numerals of a text."""
    for found in NUMERAL.finditer(text):
        yield Numeral(start=found.start(), text=found[0])


def find_names(text: str) -> list[tuple[int, int, str]]:
    """Find begin, end and rule of all passages whose numerals only name something, the first rule first."""
    return [(found.start(), found.end(), rule) for rule, each in NAMES.items() for found in each.finditer(text)]
