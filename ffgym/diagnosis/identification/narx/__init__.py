"""Friction as a small recurrent network of speeds and its own past outputs, thesis 6.2."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
