"""Tables, figures and a page of the studies; the only package of ffgym that draws."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
