"""Logs of other tools as recordings: files of many formats, and column maps that say what they hold."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
