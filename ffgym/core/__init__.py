"""Errors and their checks, files that appear whole or not at all, provenance, executors, typed JSON, array types.

Robots do not occur here; a helper of one package is in that package.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
