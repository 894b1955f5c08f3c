"""What every room may use: errors, files that appear whole or not at all, provenance, executors, typed JSON.

Nothing here knows of robots; what a room needs alone stays in that room.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
