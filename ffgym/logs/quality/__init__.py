"""The quality gate: what a recording is good for, each figure beside its limit and the reason of that limit."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
