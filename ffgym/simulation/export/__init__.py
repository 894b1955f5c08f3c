"""Folders for use without ffgym: a robot's model, a motion on it as set-points and reference, and its recording."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
