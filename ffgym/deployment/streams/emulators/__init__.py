"""Controllers to try a stream on before a machine: a simulated robot behind a delay, a filter and a bad network."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
