from .reading import ALGORITHMS as ALGORITHMS
from .reading import Value as Value
from .reading import changed as changed
from .reading import checked as checked
from .reading import hyperparameters as hyperparameters
