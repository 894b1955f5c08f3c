"""What stands between agent and robot: residuals on a base, history, filters, a slower decision rate.

Layers are given as `layers=(innermost, ..., outermost)` to `gym.make` and `gym.make_vec` alike. They live inside the
environment, below the automatic reset: each is written once, for a batch, and works the same in the single and the
vector environment, in every autoreset mode and in the SB3 adapter. (Gymnasium's own wrappers work outside as usual, but
`make_vec` takes none for an environment that is a vector environment by nature.)
"""

from ffgym.control import Agent as Agent
from ffgym.envs.layers.filters import Hold as Hold
from ffgym.envs.layers.filters import LowPass as LowPass
from ffgym.envs.layers.history import History as History
from ffgym.envs.layers.layer import Layer as Layer
from ffgym.envs.layers.layer import Passing as Passing
from ffgym.envs.layers.layer import stacked as stacked
from ffgym.envs.layers.residual import Residual as Residual
