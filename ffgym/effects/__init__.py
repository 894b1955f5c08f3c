"""Physical effects that a robot may have and its nominal model may lack."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
