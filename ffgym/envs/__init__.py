"""Gymnasium environments, single and vector: tasks, rewards, layers, recorder, pictures of episodes.

The physics is in `ffgym.simulation`, the layout of observations in `ffgym.control`, agents in `ffgym.agents`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
