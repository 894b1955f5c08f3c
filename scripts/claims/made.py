"""Tables of made parts of pages, from which claims tell again."""

import re
from collections.abc import Mapping
from functools import cache

from ffgym.core.errors import FFGymError
from ffgym.core.files import read_text
from scripts.claims.page import ROOT


@cache
def table_of(page: str, part: str) -> Mapping[str, Mapping[str, str]]:
    """Read a made table: cells by the first one of their row, and the title of their column.

    Rows whose first cell is the same take the second one into their name, as '10, rms_mm'.

    Raises:
        FFGymError: if the page has no such part.
    """
    found = re.search(rf"<!-- {re.escape(part)} -->\n(.*?)<!-- end -->", read_text(ROOT / page), flags=re.DOTALL)
    if found is None:
        raise FFGymError(f"{page} has no part {part!r}.")
    head, _, *rows = (
        [cell.strip() for cell in line.strip("|").split("|")] for line in found[1].splitlines() if line.startswith("|")
    )
    width = 1 if len({row[0] for row in rows}) == len(rows) else 2
    return {", ".join(row[:width]): dict(zip(head[width:], row[width:], strict=True)) for row in rows}
