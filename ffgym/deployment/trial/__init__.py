"""Randomised on/off experiments on a machine: the plan, the logs read back, and the gain with its certainty.

Figures of merit of a run are in `ffgym.recordings.metrics`, the comparison of agents in `ffgym.leaderboard`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
