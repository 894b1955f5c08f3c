from .layer import History as History
from .layer import Hold as Hold
from .layer import Layer as Layer
from .layer import LowPass as LowPass
from .layer import Passing as Passing
from .layer import stacked as stacked
from .residual import Residual as Residual
