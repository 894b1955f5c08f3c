"""Template of a description for a new robot: entries to fill in, their usual sources, and proposals."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
