"""Put numbers into the text of a description, and leave all else in it as it is."""

from collections.abc import Sequence

from ffgym.robot.reading.rules import RULES
from ffgym.robot.template.proposals import Proposal
from ffgym.robot.template.toml_text import MARK, filled_entry


def filled_text(toml: str, proposals: Sequence[Proposal], types: tuple[str, ...]) -> str:
    """Text of a description with entries added: in place of their waiting lines, or at the end.

    Args:
        toml: text of the description.
        proposals: entries that it lacks.
        types: 'hinge' or 'slide', one per joint.
    """
    lines = toml.splitlines()
    for proposal in proposals:
        entry = filled_entry(proposal, RULES[proposal.path], types)
        start, stop = _waiting(lines, proposal.path)
        lines[start:stop] = entry if stop > start else ["", *entry]
    return "\n".join(lines) + "\n"


def _waiting(lines: Sequence[str], path: str) -> tuple[int, int]:
    """Rows of the lines that wait for the numbers of an entry; the end of the text, twice, if there are none."""
    head = f"{MARK}[{path}]"
    if head not in lines:
        return len(lines), len(lines)
    start = stop = lines.index(head)
    while (
        stop < len(lines) and lines[stop].startswith(MARK) and (stop == start or not lines[stop].startswith(f"{MARK}["))
    ):
        stop += 1
    return start, stop
