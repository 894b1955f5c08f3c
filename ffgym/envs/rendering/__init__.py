"""Pictures of episodes. Nothing here loads OpenGL before a picture is asked for."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
