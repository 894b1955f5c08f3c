"""Hyper-parameters of the algorithms that train residual policies: a file each, every number with its reason."""

from agents.residual.hyperparameters.reading import ALGORITHMS as ALGORITHMS
from agents.residual.hyperparameters.reading import Value as Value
from agents.residual.hyperparameters.reading import changed as changed
from agents.residual.hyperparameters.reading import checked as checked
from agents.residual.hyperparameters.reading import hyperparameters as hyperparameters
