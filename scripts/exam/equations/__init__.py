"""Physics of exams: effects of the library in other equations, and effects that are outside it."""

from collections.abc import Mapping
from types import MappingProxyType

# their order, and that of the classes in them, is that of the questions of an exam
from scripts.exam.equations import friction as friction
from scripts.exam.equations import joints as joints
from scripts.exam.equations import outsiders as outsiders
from scripts.exam.equations.frame import Clue as Clue
from scripts.exam.equations.frame import Outsider as Outsider
from scripts.exam.equations.frame import Variant as Variant

VARIANTS: Mapping[str, type[Variant]] = MappingProxyType(Variant.members)
"""Effects of the library in other equations, by name."""

OUTSIDERS: Mapping[str, type[Outsider]] = MappingProxyType(Outsider.members)
"""Effects that the library cannot express, by name."""
