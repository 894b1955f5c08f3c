"""A table to fill in for a new robot: what is asked, where answers are found, and what can be proposed."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
