"""Joint positions, speeds and accelerations for poses and paths of the tool, for serial arms of any kind."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
