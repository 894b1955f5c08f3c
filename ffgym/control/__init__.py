"""What a controller may compute: references, rigid feed-forward, laws, set-points; what an agent sees, and is."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
