"""Hyper-parameters of the algorithms that train residual policies: a file each, every number with its reason."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
