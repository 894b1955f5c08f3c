"""Rounds of recording, diagnosing, extending the model and compensating with it, and the gain of each.

The diagnosis is in `ffgym.diagnosis`, feed-forward from a model in `ffgym.agents`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
