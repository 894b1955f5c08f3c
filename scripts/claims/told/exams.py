"""What docs/bench_diagnosis.md tells of its exams, from the parts that `make exam` writes onto it."""

import re
from collections.abc import Iterator
from functools import cache

from ffgym.core.files import read_text
from ffgym.robot import load_robot
from scripts.claims.claim import claim
from scripts.claims.page import ROOT
from scripts.exam.bench import RECORD_DT, RESOLVER_NOISE, TORQUE_NOISE
from scripts.exam.draw import LOUDEST, QUIETEST, ROBOT, SPREAD, TOOL_OFFSET, TORQUE_OFFSET
from scripts.exam.exams import EXAMS

AGAIN = "make exam"
PAGE = ROOT / "docs" / "bench_diagnosis.md"


@cache
def figures(part: str) -> dict[str, list[str]]:
    """Figures of an exam: what was got, and of how many, by their names."""
    (text,) = re.findall(rf"<!-- {part} -->\n(.*?)<!-- end -->", read_text(PAGE), flags=re.DOTALL)
    cells = [[cell.strip() for cell in line.split("|")] for line in text.splitlines() if line.startswith("| ")]
    return {row[2]: row[4:6] for row in cells if len(row) == 8}


def count(part: str, figure: str) -> str:
    """Answers that a figure counts, as '18 of 27'."""
    got, of = figures(part)[figure]
    return f"{float(got.rstrip('%')) * int(of) / 100:.0f} of {of}" if got.endswith("%") else f"{got} of {of}"


@claim("the code itself")
def machines_of_the_exam() -> Iterator[str]:
    """Errors of calibration, noise of sensors, and loudness of what is hidden."""
    yield (
        f"clean ones too: {100 * SPREAD:g} % (one standard deviation) on every rotor inertia, link mass, link inertia, "
        f"friction parameter, joint stiffness and damping; torque offsets of {100 * TORQUE_OFFSET:g} % of Coulomb "
        f"friction; a reflector {1e6 * TOOL_OFFSET:g} micrometres off along each axis."
    )
    yield (
        f"{load_robot(ROBOT).sensors.encoder_bits} bit resolvers with {1e6 * RESOLVER_NOISE:g} microrad of noise, "
        f"torque noise of {100 * TORQUE_NOISE:g} % of Coulomb friction at every row of {1e3 * RECORD_DT:g} ms"
    )
    yield f"is log-uniform from {QUIETEST:g} to {LOUDEST:g}, as far as its"


@claim(AGAIN)
def questions_of_the_exam() -> Iterator[str]:
    """How many questions of each kind a whole exam asks."""
    counts = EXAMS["own"].counts
    yield f"| `clean` | nothing | {counts['clean']} |"
    yield f"each equally often | {counts['single']} |"
    yield f"two waves for one, ... | {counts['foreign']} |"
    yield f"friction at one tooth, ... | {counts['outside']} |"
    yield f"half of it in two waves | {counts['periodic']} |"
    yield f"each loud | {counts['pair']} |"
    yield f"| one for each, and {counts['poor_clean']} |"
    yield f"| {counts['no_tracker']} each |"


@claim(AGAIN)
def questions_of_the_other_exam() -> Iterator[str]:
    """How many questions of each kind the second exam asks."""
    counts = EXAMS["independent"].counts
    yield f"| `clean` | nothing | {counts['clean']} |"
    yield f"in an equation of the plant | {counts['single']} |"
    yield f"cannot express | {counts['outside']} |"
    yield f"| {counts['arm']}, {counts['arm_blind']} |"


@claim(AGAIN)
def what_falls_short() -> Iterator[str]:
    """Figures of the first exam that its text tells again."""
    yield f"Loudness 2 to 10: {count('exam', 'one effect, 2 to 10: right effect and joint first')} are right."
    quiet = count("exam", "one effect, 1.3 to 2: right or in the tie")
    yield f"**Quiet effects** (row 4). {quiet} are named or in the tie"
    got, of = figures("exam")["poor logs: wrong named"]
    assert got == "2"
    yield f"A cause was named wrongly twice in {of}"
    yield f"**Pairs** (row 10), {count('exam', 'pairs, each 10 and more: both named')}."
    left = figures("exam")["energy left on held-out motions, closed loop"]
    median, largest = re.findall(r"[\d.]+", left[0])
    yield f"Half of the models that {left[1]} answers wrote leave no more than noise (median {median})."
    yield f"The largest, {float(largest):.0f}, is a drag"
    median, longest = re.findall(r"[\d.]+", figures("exam")["time of a diagnosis"][0])
    yield f"Half of the diagnoses take less than {median} s"
    yield f"took {longest} s. `--most-causes`"


@claim(AGAIN)
def what_falls_short_of_the_other() -> Iterator[str]:
    """Figures of the second exam that its text tells again."""
    clean, none = figures("independent")["clean logs named"], figures("independent")["clean logs: none"]
    assert clean[0] == "2"
    yield f"**Two clean logs are named** (row 1), of {clean[1]}:"
    yield f"{none[0].replace('%', ' %')} are `none`."
    wrong = figures("independent")["wrong names"]
    assert wrong[0] == "3"
    yield f"**Three wrong names** (row 2), of {wrong[1]},"
    yield f"{count('independent', 'one effect, 10 and more: right or in the tie')} are right or in the tie."
    time, of = figures("independent")["time of a diagnosis"]
    yield f"the longest of {of} took {re.findall(r'[0-9.]+', time)[1]} s"
