from .filters import Hold as Hold
from .filters import LowPass as LowPass
from .history import History as History
from .layer import Layer as Layer
from .layer import Passing as Passing
from .layer import stacked as stacked
from .residual import Residual as Residual
