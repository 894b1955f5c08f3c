"""Column maps: what the arrays of a file mean, as a small TOML file."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
