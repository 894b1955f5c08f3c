"""Mutants of a room: small changes of its code, as cosmic-ray's operators make them."""

import hashlib
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator

from scripts.mutation.rooms import REPOSITORY, Room

_SWAPS = (
    *(
        ("Add", "Sub"),
        ("Sub", "Add"),
        ("Mul", "Div"),
        ("Div", "Mul"),
        ("Pow", "Mul"),
        ("FloorDiv", "Mul"),
        ("Mod", "Mul"),
    ),
)
_COMPARISONS = (
    *(("Lt", "LtE"), ("Lt", "GtE"), ("LtE", "Lt"), ("LtE", "Gt"), ("Gt", "GtE"), ("Gt", "LtE"), ("GtE", "Gt")),
    *(("GtE", "Lt"), ("Eq", "NotEq"), ("NotEq", "Eq"), ("Is", "IsNot"), ("IsNot", "Is")),
)
OPERATORS = (
    *(f"ReplaceBinaryOperator_{old}_{new}" for old, new in _SWAPS),
    *(f"ReplaceComparisonOperator_{old}_{new}" for old, new in _COMPARISONS),
    *("ReplaceUnaryOperator_Delete_USub", "ReplaceUnaryOperator_Delete_Not", "ReplaceUnaryOperator_Delete_Invert"),
    *("AddNot", "ReplaceAndWithOr", "ReplaceOrWithAnd", "ReplaceTrueWithFalse", "ReplaceFalseWithTrue"),
    *("NumberReplacer", "ZeroIterationForLoop"),
)
"""Operators whose mutants run: others of the library raise a TypeError on numbers, and every test would notice."""

_SIGNATURES = ("parameters", "lambdef")
"""Nodes of the grammar whose operators are marks between parameters."""


@dataclass(frozen=True)
class Mutant:
    """A change of one place."""

    module: str
    """Module, from the repository's root."""
    operator: str
    """Operator of cosmic-ray."""
    occurrence: int
    """Number of its place in the module."""
    line: int
    text: str
    """Line as it was."""
    number: int
    """Number among mutants of this operator in lines of that text."""

    @property
    def key(self) -> tuple[str, str, str, int]:
        """Name that stays as other lines of the module change."""
        return self.module, self.operator, self.text, self.number

    def code(self) -> str:
        """Code of the mutated module."""
        source = (REPOSITORY / self.module).read_text(encoding="utf-8")
        mutated: str = mutate_code(source, get_operator(f"core/{self.operator}")(), self.occurrence)
        return mutated


def list_mutants(room: Room) -> list[Mutant]:
    """List all mutants of a room."""
    return [mutant for module in room.modules() for mutant in _mutants_of(module)]


def draw_mutants(mutants: Iterable[Mutant], count: int, seed: int) -> list[Mutant]:
    """Draw mutants without preference; a changed line elsewhere changes nothing about the others."""

    def rank(mutant: Mutant) -> str:
        return hashlib.sha256(repr((seed, mutant.key)).encode()).hexdigest()

    return sorted(mutants, key=rank)[:count]


def _mutants_of(module: str) -> Iterable[Mutant]:
    """Mutants of one module."""
    source = (REPOSITORY / module).read_text(encoding="utf-8")
    lines = source.splitlines()
    nodes = list(ast_nodes(get_ast(source)))
    for name in OPERATORS:
        operator = get_operator(f"core/{name}")()
        places = [(node, start) for node in nodes for start, _ in operator.mutation_positions(node)]
        seen: Counter[str] = Counter()
        for occurrence, (node, (line, _)) in enumerate(places):
            # decorators and the star of a signature declare, and compute nothing
            if node.search_ancestor("decorator") is not None or node.parent.type in _SIGNATURES:
                continue
            text = lines[line - 1].strip()
            yield Mutant(module, name, occurrence, line, text, seen[text])
            seen[text] += 1
