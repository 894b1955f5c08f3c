"""Physics of exams: effects of the library in other equations, and effects that are outside it."""

# their order, and that of the functions in them, is that of the questions of an exam
from scripts.exam.equations import friction as friction
from scripts.exam.equations import joints as joints
from scripts.exam.equations import outsiders as outsiders
from scripts.exam.equations.frame import OUTSIDERS as OUTSIDERS
from scripts.exam.equations.frame import VARIANTS as VARIANTS
from scripts.exam.equations.frame import Clue as Clue
from scripts.exam.equations.frame import Outsider as Outsider
from scripts.exam.equations.frame import Variant as Variant
