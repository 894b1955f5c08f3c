"""Things that go wrong with logs, as changes of a clean recording, and what the quality gate must say of each.

Every defect is a function of columns, header and a generator, which returns what it changed. It draws joint, place and
size from the generator. `checks` are findings of which one must name it; none is a defect that no recording can be made
of.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ffgym.recordings import Header, Recording

Columns = dict[str, np.ndarray]


@dataclass
class Damaged:
    """Columns and header with a defect, and where it is."""

    columns: Columns
    header: Header
    joint: str = ""
    columns_at_fault: tuple[str, ...] = ()


@dataclass(frozen=True)
class Defect:
    """A way in which a log is wrong."""

    name: str
    inject: Callable[[Recording, np.random.Generator], Damaged]
    checks: tuple[str, ...]
    """Findings of which one must be refused or flagged; empty if making the recording must fail."""
    needs: tuple[str, ...] = ()
    """Families without which it cannot be injected."""
    robot: bool = False
    """Whether it can only be seen against the description."""
    least_joints: int = 1


DEFECTS: list[Defect] = []


def defect(*checks: str, needs: tuple[str, ...] = (), robot: bool = False, least_joints: int = 1) -> Callable:
    def register(inject: Callable) -> Callable:
        entry = Defect(
            name=inject.__name__, inject=inject, checks=checks, needs=needs, robot=robot, least_joints=least_joints
        )
        DEFECTS.append(entry)
        return inject

    return register


def columns_of(recording: Recording) -> Columns:
    return {name: values.copy() for name, values in recording.columns.items()}


def some_joint(recording: Recording, rng: np.random.Generator) -> str:
    """A joint that moves well, so that a defect of it can matter."""
    travel = {j: np.ptp(recording[f"motor.position.{j}"]) for j in recording.header.joints}
    ratio = dict(zip(recording.header.joints, recording.header.gear_ratio, strict=True))
    side = recording.header.position_side == "motor"
    moved = [j for j, size in travel.items() if size / (abs(ratio[j]) if side else 1) > 3e-3]
    return str(rng.choice(moved))


def two_joints(recording: Recording, rng: np.random.Generator) -> tuple[str, str]:
    first = some_joint(recording, rng)
    while (second := some_joint(recording, rng)) == first:
        pass
    return first, second


def moving_row(recording: Recording, joint: str, rng: np.random.Generator, margin: int = 40) -> int:
    """A row in which a joint is fast."""
    x = recording[f"motor.position.{joint}"]
    speed = np.abs(x[10:] - x[:-10])[margin : -margin - 10]
    return int(rng.choice(np.flatnonzero(speed > 0.5 * speed.max()))) + margin + 5


def on_column(recording: Recording, family: str, joint: str, change: Callable[[np.ndarray], np.ndarray]) -> Damaged:
    name = f"{family}.{joint}"
    columns = columns_of(recording)
    columns[name] = change(columns[name])
    return Damaged(columns, recording.header, joint, (name,))


def permuted(recording, family, rng):
    one, other = two_joints(recording, rng)
    columns = columns_of(recording)
    a, b = f"{family}.{one}", f"{family}.{other}"
    columns[a], columns[b] = columns[b], columns[a]
    return Damaged(columns, recording.header, "", (a, b))


def smooth_noise(recording, rng):
    """A signal of size one that changes within tenths of a second."""
    length = max(2, round(0.3 / recording.dt))
    noise = np.convolve(rng.normal(size=len(recording)), np.ones(length) / length, mode="same")
    return noise / noise.std()
