"""What stands between agent and robot: residuals on a base, history, filters, a slower decision rate.

Layers are given as `layers=(innermost, ..., outermost)` to `gym.make` and `gym.make_vec` alike. They live inside the
environment, below the automatic reset: each is written once, for a batch, and works the same in the single and the
vector environment, in every autoreset mode and in the SB3 adapter. (Gymnasium's own wrappers work outside as usual, but
`make_vec` takes none for an environment that is a vector environment by nature.)
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
