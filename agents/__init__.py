"""Feed-forward methods and policies, one file per family; `LawAgent` runs any law with stable-baselines3's `predict`.

Friction and rigid-body laws of a controller are in `ffgym.control`, the comparison of agents in `ffgym.leaderboard`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
