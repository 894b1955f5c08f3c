"""Rooms whose code is mutated, and the tests that may notice it."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

REPOSITORY = Path(__file__).parents[2]


@dataclass(frozen=True, kw_only=True)
class Room:
    """A part of the package."""

    code: tuple[str, ...]
    """Folders that are mutated, from the repository's root."""
    tests: tuple[str, ...]
    """Folders of tests; of these, the files that run a mutated line are asked, fastest first."""

    def modules(self) -> list[str]:
        """Modules that are mutated, from the repository's root."""
        return [file for file in _python_files(self.code) if not file.endswith("/__init__.py")]

    def test_files(self) -> list[str]:
        """Files of tests, from the repository's root."""
        return [file for file in _python_files(self.tests) if Path(file).name.startswith("test_")]


def _python_files(places: tuple[str, ...]) -> list[str]:
    """Files of Python in folders, from the repository's root."""
    return [
        str(file.relative_to(REPOSITORY)) for place in places for file in sorted((REPOSITORY / place).rglob("*.py"))
    ]


ROOMS: Mapping[str, Room] = {
    "plant": Room(
        code=("ffgym/simulation/plant",),
        tests=("tests/simulation", "tests/effects", "tests/envs", "tests/oracle", "tests/robot/friction"),
    ),
    "fit": Room(code=("ffgym/diagnosis/fit",), tests=("tests/diagnosis",)),
    "search": Room(code=("ffgym/diagnosis/search",), tests=("tests/diagnosis",)),
    "statistics": Room(code=("ffgym/leaderboard/comparison",), tests=("tests/leaderboard",)),
}
"""Rooms by name."""
