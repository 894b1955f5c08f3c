"""Measurement protocols: motions that a machine makes to be identified, tested or diagnosed, and their recordings."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
