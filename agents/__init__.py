"""Feed-forward methods: one file per family; `LawAgent` runs any of them with stable-baselines3's `predict`."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
